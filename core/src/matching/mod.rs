//! From two sets of features to matches, and from matches to inliers.
//!
//! A *putative match* pairs a feature of image A with the feature of image B whose descriptor is nearest to its own, if
//! that is clearly nearer than the second nearest (the ratio test of Lowe, "Distinctive Image Features from
//! Scale-Invariant Keypoints", IJCV 2004) and if each is the other's nearest. An *inlier* is a putative match that
//! agrees with a geometry of the two views on which most others agree too. [`match_features`] does it all for whoever
//! matches: [`putative`] → [`geometry`] → where the motions are known, both again at the places that they predict
//! ([`Prediction`]) → where there are frames, the pictures of the inliers ([`aligned`]). [`match_pair`] aligns each
//! pair by itself; a dataset for COLMAP is aligned as a whole, gets the matches [`beside()`] measured ones, loses those
//! that others contradict, and gets those that others imply ([`tracks`]).
//!
//! Match ratio is the share of the keypoints that have a putative match, match score the share that have an inlier
//! match, and inlier ratio the share of the putative matches that are inliers (after Schönberger, Hardmeier, Sattler
//! and Pollefeys, "Comparative Evaluation of Hand-Crafted and Learned Local Features", CVPR 2017, who call it
//! precision). The first two are means over the images, here A and B. Against many others, as in the paper's Table 1,
//! an image's matches with all of them are added up: each counts for both of its images, and shares may pass 1.

pub mod align;
pub mod aligned;
mod beside;
pub mod geometry;
pub mod params;
mod predicted;
pub mod putative;
mod selection;
pub mod tracks;

pub use crate::camera::{self, Camera, CameraModel};
use align::Measured;
pub use aligned::{PairAlignment, Pictures};
use aligned::{align_pair, before_alignment, measure_inliers};
pub use beside::beside;
use beside::forget_contradicted;
pub use geometry::{PointPair, TwoViewModel, Verification, verify};
pub use params::{Geometry, MatchParams};
pub use predicted::{Agreement, Expected, PREDICTED_RATIO, Prediction};
use putative::Neighbours;
pub use putative::{Match, Predicted};
pub use selection::{PairSelection, VOTERS, near_pairs};

use crate::detector::{Descriptor, Feature, Slope};
use crate::error::{Error, Result};
use crate::monitor::Monitor;
use serde::Serialize;
use std::collections::BTreeMap;

/// The matches of two images, A and B.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchResult {
    /// The putative matches, in the order of A's features; each of A is in one at most, with the mutual check of B too.
    pub matches: Vec<Match>,
    /// Geometry that they agree on; `None` where no geometry was requested.
    pub verification: Option<Verification>,
    /// Places that the motions predict from the sure matches; `None` without, or where too little is known.
    pub prediction: Option<Prediction>,
    /// Alignment of the inliers; `None` without a geometry. With it, `verification` is that of the solved places.
    pub alignment: Option<PairAlignment>,
    /// Counts of keypoints, putative matches and inliers.
    pub counts: MatchCounts,
}

/// Features of an image, as matching needs them.
#[derive(Debug, Clone, Copy)]
pub struct MatchSide<'a> {
    /// (u, v) of each feature, pixels.
    pub places: &'a [[f64; 2]],
    /// Descriptor of each feature.
    pub descriptors: &'a [Descriptor],
    /// Shape and motion of each feature; empty where they are unknown, and no match is predicted.
    pub blobs: &'a [Blob],
    /// Pictures of their places; needed where matches are aligned.
    pub pictures: Option<&'a Pictures>,
}

/// Shape and motion of a feature, and the motion of its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blob {
    /// Scale σ, pixels.
    pub sigma: f32,
    /// Orientation, radians from +u towards +v.
    pub orientation: f32,
    /// Motion along which its picture is stacked, pixels per frame.
    pub slope: Slope,
    /// Motion of its place from the field of motion, pixels per frame.
    pub motion: Slope,
    /// Standard deviation of the motion along its least certain direction, pixels per frame; infinite where unknown.
    pub motion_sigma: f32,
}

impl From<&Feature> for Blob {
    fn from(feature: &Feature) -> Self {
        let (slope, _) = feature.motion();
        let Feature { sigma, orientation, field, field_sigma, .. } = *feature;
        Self { sigma, orientation, slope, motion: field, motion_sigma: field_sigma }
    }
}

/// Matches of a pair before its alignment.
#[derive(Debug, Clone, PartialEq)]
pub struct Unaligned {
    /// The matches, verified with the wider error of uncertain places where an alignment follows.
    pub result: MatchResult,
    /// For each match what the pictures say; `None` for what is no inlier, or contradicted, and without an alignment.
    pub measured: Vec<Option<Measured>>,
    /// Distances of contradicted matches, pixels, as [`PairAlignment::contradicted`].
    pub contradicted: BTreeMap<usize, f64>,
}

impl Unaligned {
    /// The result after an alignment by the measurements of this pair alone, where `params` ask for it.
    ///
    /// # Errors
    /// Parameters that make no sense, and cancellation once `monitor` was cancelled.
    pub fn aligned(self, sides: [MatchSide<'_>; 2], params: &MatchParams, monitor: &Monitor) -> Result<MatchResult> {
        let Self { mut result, measured, contradicted } = self;
        align_pair(&mut result, sides, (&measured, contradicted), params, monitor)?;
        Ok(result)
    }
}

/// [`match_features`], and the alignment of the matches where `params` ask for it; the same errors.
pub fn match_pair(sides: [MatchSide<'_>; 2], params: &MatchParams, monitor: &Monitor) -> Result<MatchResult> {
    match_features(sides, params, monitor)?.aligned(sides, params, monitor)
}

/// Matches the features of two images, verifies the matches, and measures the inliers where they are to be aligned.
///
/// # Errors
/// Parameters that make no sense, an alignment of features without pictures, and cancellation.
///
/// # Panics
/// When the numbers of places and descriptors differ: a mistake of the caller.
pub fn match_features([a, b]: [MatchSide<'_>; 2], params: &MatchParams, monitor: &Monitor) -> Result<Unaligned> {
    for side in [&a, &b] {
        assert_eq!(side.places.len(), side.descriptors.len(), "each feature has a place and a descriptor");
    }
    let pictures = match (a.pictures, b.pictures) {
        _ if !params.aligns() => None,
        (Some(a), Some(b)) => Some([a, b]),
        _ => {
            let problem = "features without their frames have no pictures that could be compared";
            return Err(Error::param(params::doc::ALIGN.name, problem, "give the frames, or false"));
        }
    };
    let neighbours = Neighbours::new(a.descriptors, b.descriptors, params, monitor)?;
    let mut matches = neighbours.matches(params);
    let verified = |matches: &[Match], params: &MatchParams| {
        let pair = |m: &Match| PointPair { a: a.places[m.a], b: b.places[m.b], rank: m.rank() };
        verify(&matches.iter().map(pair).collect::<Vec<_>>(), None, params, monitor)
    };
    // The sure matches first: a prediction needs their geometry.
    let mut verification = verified(&matches, params)?;
    let (mut prediction, mut refused) = (None, None);
    if let Some(sure) = verification.as_mut().filter(|_| params.predict)
        && let Some(model) = sure.model.clone()
    {
        let inliers = matches.iter().zip(&sure.inlier).filter(|(_, inlier)| **inlier);
        let inliers: Vec<(usize, usize)> = inliers.map(|(m, _)| (m.a, m.b)).collect();
        // Places are uncertain before the alignment, so predicted matches may err by more.
        let wide = if params.align { before_alignment(params) } else { params.clone() };
        prediction = Prediction::of([a, b], &model, &inliers, &wide);
        match &prediction {
            Some(prediction) if prediction.is_believed() => {
                let mut found = predicted::predicted_matches([a, b], (&model, &matches), prediction, &wide, monitor)?;
                let again = verified(&found, &wide)?;
                // Predicted matches count only where they agree on a geometry again.
                if again.as_ref().is_some_and(|again| again.model.is_some()) {
                    for m in &mut found {
                        let ratio_among_all = neighbours.ratio_among_all(m);
                        m.predicted = m.predicted.map(|predicted| Predicted { ratio_among_all, ..predicted });
                    }
                    (matches, verification) = (found, again);
                }
            }
            // The pictures of the inliers decide then.
            Some(_) if params.align => {}
            Some(_) => {
                sure.refuse();
                refused = Some(Refusal::Motions);
            }
            None => {}
        }
    }
    let mut measured = match (pictures, &verification) {
        (Some(pictures), Some(verified)) => measure_inliers(&matches, &verified.inlier, pictures, monitor)?,
        _ => vec![None; matches.len()],
    };
    let contradicted = forget_contradicted([a, b], (&matches, &mut measured), f64::from(params.max_error_px));
    let (keypoints_a, keypoints_b, putative) = (a.places.len(), b.places.len(), matches.len());
    let inliers = verification.as_ref().map(Verification::inlier_count);
    let not_mutual = Some(neighbours.not_mutual(&matches));
    let counts = MatchCounts { keypoints_a, keypoints_b, putative, inliers, refused, not_mutual };
    let result = MatchResult { matches, verification, prediction, alignment: None, counts };
    Ok(Unaligned { result, measured, contradicted })
}

/// Reason why the geometry of a pair, on which enough matches agreed, is not believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Refusal {
    /// Its motions agree with it no more than those of other places would.
    Motions,
    /// Too few matches agree with the alignment of their pictures.
    Pictures,
    /// Too many matches contradict the tracks of pairs with more inliers.
    Tracks,
}

impl Refusal {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Motions, Self::Pictures, Self::Tracks];

    /// Words for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Motions => "the motions contradict the sure matches' geometry",
            Self::Pictures => "the pictures of too many matches contradict each other",
            Self::Tracks => "too many matches contradict those of other pairs",
        }
    }
}

/// Counts of one pair of images, A and B.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct MatchCounts {
    /// Features of A.
    pub keypoints_a: usize,
    /// Features of B.
    pub keypoints_b: usize,
    /// Number of matches by descriptors alone.
    pub putative: usize,
    /// Number of matches consistent with a common geometry; `None` where none was requested.
    pub inliers: Option<usize>,
    /// Reason why there are none although enough matches agreed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<Refusal>,
    /// Features of A without a match whose nearest in B is nearer to another; `None` of a pair read from files.
    #[serde(skip)]
    pub not_mutual: Option<usize>,
}

impl MatchCounts {
    /// Mean number of features of an image.
    pub fn keypoints_per_image(&self) -> f64 {
        (self.keypoints_a + self.keypoints_b) as f64 / 2.0
    }

    /// Putative matches over keypoints, mean of A and B; 0 where there are no matches.
    pub fn match_ratio(&self) -> f64 {
        self.share_of_keypoints(self.putative)
    }

    /// Inliers over keypoints, mean of A and B; `None` where the geometry was not verified.
    pub fn match_score(&self) -> Option<f64> {
        self.inliers.map(|inliers| self.share_of_keypoints(inliers))
    }

    /// Inliers over putative matches; `None` where the geometry was not verified or there are no matches.
    pub fn inlier_ratio(&self) -> Option<f64> {
        let inliers = self.inliers?;
        (self.putative > 0).then(|| inliers as f64 / self.putative as f64)
    }

    fn share_of_keypoints(&self, matches: usize) -> f64 {
        let share = |keypoints: usize| if keypoints > 0 { matches as f64 / keypoints as f64 } else { 0.0 };
        (share(self.keypoints_a) + share(self.keypoints_b)) / 2.0
    }
}

/// Statistics of many images that were matched with one another, as in the paper's table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct ImageCounts {
    pub keypoints_per_image: f64,
    pub putative_per_image: f64,
    pub inliers_per_image: f64,
    /// Putative matches over keypoints, mean over the images.
    pub match_ratio: f64,
    /// Inliers over keypoints, mean over the images.
    pub match_score: f64,
    /// Inliers over putative matches, of all pairs together; `None` without matches.
    pub inlier_ratio: Option<f64>,
    pub verified_pairs: usize,
}

impl ImageCounts {
    /// Computes the statistics of images with `keypoints` features each, and of the matched pairs of them (by index).
    /// Pairs that were not verified count as pairs without inliers. `None` without images.
    ///
    /// # Panics
    /// When a pair has an index outside `keypoints`: a mistake of the caller.
    pub fn of(keypoints: &[usize], pairs: &[((usize, usize), MatchCounts)]) -> Option<Self> {
        if keypoints.is_empty() {
            return None;
        }
        let images = keypoints.len() as f64;
        // Each match counts for both images.
        let of_images = |count: &dyn Fn(&MatchCounts) -> usize| {
            let mut sums = vec![0; keypoints.len()];
            for ((a, b), counts) in pairs {
                sums[*a] += count(counts);
                sums[*b] += count(counts);
            }
            sums
        };
        let putative = of_images(&|c| c.putative);
        let inliers = of_images(&|c| c.inliers.unwrap_or(0));
        let mean = |sums: &[usize]| sums.iter().sum::<usize>() as f64 / images;
        // An image without keypoints counts as 0, so that means are over all images.
        let share = |sums: &[usize]| {
            let of_one = |(&sum, &all): (&usize, &usize)| if all > 0 { sum as f64 / all as f64 } else { 0.0 };
            sums.iter().zip(keypoints).map(of_one).sum::<f64>() / images
        };
        let all_putative = putative.iter().sum::<usize>();
        Some(Self {
            keypoints_per_image: mean(keypoints),
            putative_per_image: mean(&putative),
            inliers_per_image: mean(&inliers),
            match_ratio: share(&putative),
            match_score: share(&inliers),
            inlier_ratio: (all_putative > 0).then(|| inliers.iter().sum::<usize>() as f64 / all_putative as f64),
            verified_pairs: pairs.iter().filter(|(_, c)| c.inliers.is_some_and(|n| n > 0)).count(),
        })
    }
}
