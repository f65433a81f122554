//! The report of a study of matches: methods, which hold pairs.

use super::method::MatchMethod;
use crate::detector::{DetectorParams, SlopeGrid};
use crate::matching::{ImageCounts, MatchCounts, MatchParams};
use serde::Serialize;

/// Report of a study of matches.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MatchReport {
    /// The bursts' names, in order.
    pub bursts: Vec<String>,
    /// Number of frames of the first burst.
    pub frames: usize,
    /// (columns, rows) of its frames.
    pub size: (usize, usize),
    /// Matched pairs, as indices of bursts.
    pub pairs: Vec<(usize, usize)>,
    /// The detector's parameters; method and slopes were set by each method.
    pub detector: DetectorParams,
    /// Slopes of BuFF 1D.
    pub slopes_1d: SlopeGrid,
    /// Slopes of BuFF 2D.
    pub slopes_2d: SlopeGrid,
    /// Parameters of matching and verification.
    pub matching: MatchParams,
    /// One row for each method.
    pub methods: Vec<MatchRow>,
}

/// Results of one method. Numbers for an image are means over the images; an image's matches are those with all others
/// it was paired with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MatchRow {
    /// The method.
    pub method: MatchMethod,
    /// Statistics, as in the paper's table.
    #[serde(flatten)]
    pub counts: ImageCounts,
    /// Putative matches of an image on the geometry of the sharp images; `None` without these.
    pub on_gold_geometry_per_image: Option<f64>,
    /// Slopes found and searched in each burst, where the method finds them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slopes_found: Option<Vec<SlopeGrid>>,
    /// Counts of each pair, in the report's order.
    pub by_pair: Vec<PairCounts>,
}

/// Counts of one pair by one method.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PairCounts {
    /// Counts of the match.
    #[serde(flatten)]
    pub counts: MatchCounts,
    /// Number of putative matches on the geometry of the sharp images; `None` where there is none.
    pub on_gold_geometry: Option<usize>,
}

/// The row of a method from the counts of its pairs.
pub(super) fn row(
    method: MatchMethod,
    keypoints: &[usize],
    slopes_found: Option<Vec<SlopeGrid>>,
    pairs: &[(usize, usize)],
    by_pair: Vec<PairCounts>,
) -> MatchRow {
    let counts: Vec<_> = pairs.iter().zip(&by_pair).map(|(&pair, counted)| (pair, counted.counts)).collect();
    let judged = by_pair.iter().any(|pair| pair.on_gold_geometry.is_some());
    // Each match counts for both images.
    let on_gold = 2 * by_pair.iter().filter_map(|pair| pair.on_gold_geometry).sum::<usize>();
    MatchRow {
        method,
        counts: ImageCounts::of(keypoints, &counts).expect("pairs are matched of images that are there"),
        on_gold_geometry_per_image: judged.then(|| on_gold as f64 / keypoints.len() as f64),
        slopes_found,
        by_pair,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_images_matches_with_all_others_are_added_up() {
        let pair = |keypoints_a, keypoints_b, putative, inliers, on_gold| PairCounts {
            counts: MatchCounts { keypoints_a, keypoints_b, putative, inliers: Some(inliers) },
            on_gold_geometry: on_gold,
        };
        // Three images of 10, 20 and 0 features.
        let by_pair = vec![pair(10, 20, 8, 6, Some(5)), pair(10, 0, 0, 0, None), pair(20, 0, 0, 0, Some(0))];
        let row = row(MatchMethod::Gold, &[10, 20, 0], None, &[(0, 1), (0, 2), (1, 2)], by_pair);
        let counts = &row.counts;
        assert_eq!(
            (counts.keypoints_per_image, counts.putative_per_image, counts.inliers_per_image),
            (10.0, 16.0 / 3.0, 4.0)
        );
        assert!((counts.match_ratio - (0.8 + 0.4) / 3.0).abs() < 1e-12);
        assert!((counts.match_score - (0.6 + 0.3) / 3.0).abs() < 1e-12);
        assert_eq!((counts.precision, counts.verified_pairs), (Some(0.75), 1));
        assert_eq!(row.on_gold_geometry_per_image, Some(10.0 / 3.0));
    }
}
