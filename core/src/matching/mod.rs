//! From two sets of features to matches, and from matches to inliers.
//!
//! A *putative match* pairs a feature of image A with the feature of image B whose descriptor is nearest to its own, if
//! that is clearly nearer than the second nearest (the ratio test of Lowe, "Distinctive Image Features from
//! Scale-Invariant Keypoints", IJCV 2004) and if each is the other's nearest.
//!
//! An *inlier* is a putative match that agrees with a geometry of the two views on which most others agree too.
//!
//! The data flow: descriptors → [`nearest`] (exact nearest neighbours) → [`putative`] (ratio test, mutual check) →
//! [`geometry`] (robust estimation, inliers) → [`counts`] (the numbers of the paper). [`match_detections`] is the
//! composition, [`params`] holds all parameters of its result, [`camera`] the intrinsics where they are known,
//! [`pairs`] selects the pairs of images to match.

pub mod camera;
pub mod counts;
pub mod geometry;
pub mod nearest;
pub mod pairs;
pub mod params;
pub mod putative;

pub use camera::{Camera, CameraModel};
pub use counts::{ImageCounts, MatchCounts};
pub use geometry::{PointPair, TwoViewModel, Verification, verify};
pub use pairs::PairSelection;
pub use params::{Geometry, MatchParams};
pub use putative::{Match, match_descriptors};

use crate::detector::{Descriptor, Detection, Feature, ParamError};
use crate::monitor::{Cancelled, Monitor};

/// Reason why matching failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MatchError {
    /// A parameter makes no sense.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// Matching was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The matches of two images, A and B.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchResult {
    /// The putative matches, in the order of A's features. No feature of A is in two of them, and with the mutual check
    /// none of B either.
    pub matches: Vec<Match>,
    /// Geometry that they agree on; `None` where no geometry was requested.
    pub verification: Option<Verification>,
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
}

/// Matches the features of two detections and verifies the matches.
///
/// # Errors
/// [`MatchError::Param`] for parameters that make no sense, [`MatchError::Cancelled`] once `monitor` was cancelled.
pub fn match_detections(
    a: &Detection,
    b: &Detection,
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<MatchResult, MatchError> {
    let places = |features: &[Feature]| -> Vec<[f64; 2]> {
        features.iter().map(|feature| [f64::from(feature.u), f64::from(feature.v)]).collect()
    };
    let (of_a, of_b) = (places(&a.features), places(&b.features));
    let a = MatchSide { places: &of_a, descriptors: &a.descriptors };
    match_features(a, MatchSide { places: &of_b, descriptors: &b.descriptors }, params, monitor)
}

/// Matches features given by places and descriptors alone, and verifies the matches.
///
/// # Errors
/// As [`match_detections`].
///
/// # Panics
/// When the numbers of places and descriptors differ: a mistake of the caller.
pub fn match_features(
    a: MatchSide<'_>,
    b: MatchSide<'_>,
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<MatchResult, MatchError> {
    for side in [&a, &b] {
        assert_eq!(side.places.len(), side.descriptors.len(), "each feature has a place and a descriptor");
    }
    let matches = match_descriptors(a.descriptors, b.descriptors, params, monitor)?;
    let pair = |m: &Match| PointPair { a: a.places[m.a], b: b.places[m.b], rank: m.ratio };
    let pairs: Vec<PointPair> = matches.iter().map(pair).collect();
    let verification = verify(&pairs, params, monitor)?;
    let counts = MatchCounts {
        keypoints_a: a.places.len(),
        keypoints_b: b.places.len(),
        putative: matches.len(),
        inliers: verification.as_ref().map(Verification::inlier_count),
    };
    Ok(MatchResult { matches, verification, counts })
}
