//! One method on one trajectory: how well its bursts match, and what COLMAP makes of it.

use crate::evaluate::MatchMethod;
use crate::synth::Motion;
use serde::{Deserialize, Serialize};

/// What a method's features of one trajectory are worth.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Matched {
    /// Features of an image, mean.
    pub keypoints: f64,
    /// Putative matches of an image with all others, mean.
    pub putative: f64,
    /// Inliers of an image with all others, mean.
    pub inliers: f64,
    /// Putative matches over features.
    pub match_ratio: f64,
    /// Inliers over features.
    pub match_score: f64,
    /// Inliers over putative matches, if there are any.
    pub precision: Option<f64>,
    /// How long the features of all bursts and their matches took, seconds.
    pub seconds: f64,
}

/// What COLMAP's mapper made of a method's matches.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Reconstructed {
    /// Images that have a pose in the largest model.
    pub registered: usize,
    /// Points of the model for each of its images.
    pub points_per_image: Option<f64>,
    /// Mean absolute error of the poses: metres, and degrees.
    pub absolute: Option<[f64; 2]>,
    /// Mean error from one pose to the next: metres, and degrees.
    pub relative: Option<[f64; 2]>,
    /// The registered cameras by their number on the way, and their estimated centres after the alignment, metres.
    pub centres: Vec<(usize, [f64; 3])>,
    /// How long the mapper took, seconds.
    pub mapper_secs: f64,
    /// What the mapper said last where it gave up and left no model.
    pub gave_up: Option<String>,
}

/// A run with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    /// How the camera went.
    pub motion: Motion,
    /// The trajectory's seed.
    pub seed: u64,
    /// The method.
    pub method: MatchMethod,
    /// Bursts of the trajectory.
    pub bursts: usize,
    /// Its matches.
    pub matched: Matched,
    /// What COLMAP made of them; `None` without COLMAP.
    pub reconstructed: Option<Reconstructed>,
    /// Centres of the true cameras, metres.
    pub true_centres: Vec<[f64; 3]>,
}
