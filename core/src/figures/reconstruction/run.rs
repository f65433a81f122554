//! One method on one trajectory: matches of its bursts, and COLMAP's reconstruction.

use crate::evaluate::MatchMethod;
use crate::synth::Motion;
use serde::{Deserialize, Serialize};

/// Matching results of a method on one trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Matched {
    /// Features of an image, mean over the images.
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
    /// Time for the features of all bursts and their matches, seconds.
    pub seconds: f64,
}

/// Result of COLMAP's mapper from a method's matches.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Reconstructed {
    /// Number of images that have a pose in the largest model.
    pub registered: usize,
    /// Points of the model per image.
    pub points_per_image: Option<f64>,
    /// Mean absolute error of the poses: metres, and degrees.
    pub absolute: Option<[f64; 2]>,
    /// Mean error from one pose to the next: metres, and degrees.
    pub relative: Option<[f64; 2]>,
    /// Registered cameras by their index on the trajectory, with their estimated centres after the alignment, metres.
    pub centres: Vec<(usize, [f64; 3])>,
    /// Time of the mapper, seconds.
    pub mapper_secs: f64,
    /// Last line of the mapper's output where it gave up and left no model.
    pub gave_up: Option<String>,
}

/// Results of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    /// Motion of the camera.
    pub motion: Motion,
    /// Seed of the trajectory.
    pub seed: u64,
    /// The method.
    pub method: MatchMethod,
    /// Number of bursts of the trajectory.
    pub bursts: usize,
    /// Results of matching.
    pub matched: Matched,
    /// Results of COLMAP; `None` without COLMAP.
    pub reconstructed: Option<Reconstructed>,
    /// Centres of the true cameras, metres.
    pub true_centres: Vec<[f64; 3]>,
}
