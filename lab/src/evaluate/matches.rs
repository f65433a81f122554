//! Matching between the bursts of a dataset: the columns of the paper's Table 1 that need no reconstruction.
//!
//! Every method finds the features of every burst, with the same parameters and a noise gate of the same rate of false
//! features; the features of chosen pairs of bursts are matched and verified geometrically. As in the paper, an image's
//! matches with all others are added up, so that ratios to its keypoints may exceed 1.
//!
//! # The gold standard
//! Where sharp images of the same views are given, SIFT on them is a row of its own, and there is a further column for
//! all rows: the number of putative matches on the geometry that the *sharp* images' matches agree on. Inliers are
//! counted against a geometry that was found with the same matches, which favours a method with few matches: some
//! always agree on some geometry. This column does not.

use super::methods::{BurstMethod, Searches};
use burstscope_core::burst::Burst;
use burstscope_core::detector::{Descriptor, Detection, SlopeGrid};
use burstscope_core::error::{Error, Result};
use burstscope_core::matching::{
    Blob, Geometry, ImageCounts, MatchCounts, MatchParams, MatchResult, MatchSide, PairSelection, TwoViewModel,
    match_features,
};
use burstscope_core::monitor::{Monitor, Stage};
use rayon::prelude::*;
use serde::Serialize;

/// Kind of pictures of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shot {
    /// Burst whose features are compared.
    Burst,
    /// Sharp image; of several the middle one is used.
    Gold,
}

/// Methods to be compared, with the parameters of search and matching.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchStudy {
    /// The rows, each at most once.
    pub methods: Vec<BurstMethod>,
    /// Whether there are sharp images.
    pub has_gold: bool,
    /// Parameters of their searches.
    pub searches: Searches,
    /// Parameters of matching and verification.
    pub matching: MatchParams,
    /// Selection of the pairs of bursts that are matched.
    pub pairs: PairSelection,
}

/// Features with only the data that matching needs.
struct Features {
    places: Vec<[f64; 2]>,
    descriptors: Vec<Descriptor>,
    blobs: Vec<Blob>,
}

impl From<Detection> for Features {
    fn from(detection: Detection) -> Self {
        let places = detection.features.iter().map(|f| [f64::from(f.u), f64::from(f.v)]).collect();
        let blobs = detection.features.iter().map(Blob::from).collect();
        Self { places, blobs, descriptors: detection.descriptors }
    }
}

impl Features {
    fn side(&self) -> MatchSide<'_> {
        MatchSide { places: &self.places, descriptors: &self.descriptors, blobs: &self.blobs }
    }
}

impl MatchStudy {
    fn check(&self, bursts: usize) -> Result<()> {
        self.matching.validate()?;
        if self.methods.is_empty() {
            let remedy = "give one or more, such as sift-merge,buff-1d";
            return Err(Error::param("methods", "none is given", remedy));
        }
        if self.methods.contains(&BurstMethod::Gold) && !self.has_gold {
            let remedy = "give --gold, or --snr to make noisy bursts of sharp ones; or leave it out";
            return Err(Error::param("methods", "the gold standard needs sharp images", remedy));
        }
        if self.matching.geometry == Geometry::None {
            let remedy = "give fundamental, essential or homography";
            return Err(Error::param("geometry", "inliers are those of a geometry", remedy));
        }
        if bursts < 2 {
            let remedy = "name a folder of bursts, or cut a long sequence with --burst-length";
            return Err(Error::param("pairs", format!("{bursts} bursts make no pair"), remedy));
        }
        Ok(())
    }

    /// Finds the features of every burst by every method, matches the pairs, and counts. `open` opens the pictures of
    /// burst k; sharp ones are requested only if there are any. One burst is held in memory at a time.
    ///
    /// # Errors
    /// A parameter that makes no sense, an error of `open`, or cancellation.
    pub fn run<E: From<Error>>(
        &self,
        names: &[String],
        mut open: impl FnMut(usize, Shot) -> Result<Burst, E>,
        monitor: &Monitor,
    ) -> Result<MatchReport, E> {
        self.check(names.len())?;
        let pairs = self.pairs.pairs(names.len());
        // The sharp images are searched even if their row is not requested, because all rows are judged by their
        // geometry.
        let mut methods = self.methods.clone();
        if self.has_gold && !methods.contains(&BurstMethod::Gold) {
            methods.push(BurstMethod::Gold);
        }
        let steps = (names.len() + 1) * methods.len();
        let mut done = 0;
        let mut step = || {
            done += 1;
            monitor.report(Stage::Evaluate, done as f32 / steps as f32);
        };
        let mut features: Vec<Vec<Features>> = methods.iter().map(|_| Vec::with_capacity(names.len())).collect();
        let mut slopes: Vec<Vec<Option<SlopeGrid>>> = methods.iter().map(|_| Vec::with_capacity(names.len())).collect();
        let (mut frames, mut size) = (0, (0, 0));
        for k in 0..names.len() {
            let burst = open(k, Shot::Burst)?;
            if k == 0 {
                (frames, size) = (burst.len(), burst.size());
            }
            for ((method, features), slopes) in methods.iter().zip(&mut features).zip(&mut slopes) {
                let found = match method {
                    BurstMethod::Gold => {
                        let sharp = open(k, Shot::Gold)?;
                        let mut searches = self.searches.clone();
                        if sharp.len() != burst.len() {
                            // The requested frames are those of bursts; a sharp image may be the only one.
                            searches.detector.frames = None;
                        }
                        searches.search(*method, &sharp, &monitor.silent())?
                    }
                    method => self.searches.search(*method, &burst, &monitor.silent())?,
                };
                slopes.push(found.finding.map(|finding| finding.grid));
                features.push(found.detection.into());
                step();
            }
        }
        let mut results = Vec::with_capacity(methods.len());
        for features in &features {
            let of_pair = |&(a, b): &(usize, usize)| {
                match_features(features[a].side(), features[b].side(), &self.matching, &monitor.silent())
            };
            let found: Result<Vec<MatchResult>> = pairs.par_iter().map(of_pair).collect();
            results.push(found?);
            step();
        }
        let gold = methods.iter().position(|m| *m == BurstMethod::Gold);
        let judges: Vec<Option<&TwoViewModel>> = (0..pairs.len())
            .map(|p| gold.and_then(|g| results[g][p].verification.as_ref()).and_then(|v| v.model.as_ref()))
            .collect();
        let rows = methods.iter().enumerate().filter(|(_, method)| self.methods.contains(method));
        let rows = rows.map(|(m, &method)| {
            let by_pair = (0..pairs.len()).map(|p| {
                let (a, b) = pairs[p];
                let sides = [&features[m][a], &features[m][b]];
                PairCounts {
                    counts: results[m][p].counts,
                    on_gold_geometry: judges[p].map(|judge| self.agreeing(&results[m][p], sides, judge)),
                }
            });
            let keypoints: Vec<usize> = features[m].iter().map(|f| f.places.len()).collect();
            let slopes_found = slopes[m].iter().copied().collect();
            row(method, &keypoints, slopes_found, &pairs, by_pair.collect())
        });
        Ok(MatchReport {
            methods: rows.collect(),
            bursts: names.to_vec(),
            frames,
            size,
            pairs: pairs.clone(),
            searches: self.searches.clone(),
            matching: self.matching.clone(),
        })
    }

    /// The number of putative matches within the error limit of `judge`.
    fn agreeing(&self, result: &MatchResult, sides: [&Features; 2], judge: &TwoViewModel) -> usize {
        let max = f64::from(self.matching.max_error_px);
        let agrees =
            |m: &&burstscope_core::matching::Match| judge.error_px(sides[0].places[m.a], sides[1].places[m.b]) <= max;
        result.matches.iter().filter(agrees).count()
    }
}

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
    /// Parameters of the methods' searches.
    #[serde(flatten)]
    pub searches: Searches,
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
    pub method: BurstMethod,
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

fn row(
    method: BurstMethod,
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
            counts: MatchCounts { keypoints_a, keypoints_b, putative, inliers: Some(inliers), refused: None },
            on_gold_geometry: on_gold,
        };
        // Three images of 10, 20 and 0 features.
        let by_pair = vec![pair(10, 20, 8, 6, Some(5)), pair(10, 0, 0, 0, None), pair(20, 0, 0, 0, Some(0))];
        let row = row(BurstMethod::Gold, &[10, 20, 0], None, &[(0, 1), (0, 2), (1, 2)], by_pair);
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
