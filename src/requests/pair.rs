//! Matching the features of two bursts, and the pictures of a match.

use super::error::JobError;
use super::picture::{Picture, PictureRequest};
use crate::detector::Detection;
use crate::matching::{MatchParams, MatchResult, match_detections};
use crate::monitor::Monitor;
use std::sync::Arc;

/// What to match: the features of two bursts and the parameters, as they were when it was asked.
#[derive(Debug, Clone)]
pub struct MatchRequest {
    /// The features of A.
    pub a: Arc<Detection>,
    /// The features of B.
    pub b: Arc<Detection>,
    /// The parameters.
    pub params: MatchParams,
}

impl MatchRequest {
    /// Whether both ask for the same matches: of the same two detections, with the same parameters.
    pub fn same_matches(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.a, &other.a) && Arc::ptr_eq(&self.b, &other.b) && self.params == other.params
    }

    /// Matches, on the calling thread and its pool.
    ///
    /// # Errors
    /// [`JobError::Failed`] for parameters that make no sense; [`JobError::Cancelled`].
    pub fn compute(self, monitor: &Monitor) -> Result<Matched, JobError> {
        let result = Arc::new(match_detections(&self.a, &self.b, &self.params, monitor)?);
        Ok(Matched { request: self, result })
    }
}

/// Matches with what they were made from.
#[derive(Debug, Clone)]
pub struct Matched {
    /// What was asked for.
    pub request: MatchRequest,
    /// The matches, and what they agree on.
    pub result: Arc<MatchResult>,
}

/// The two motion-stack images from which a match's patches are cut, or any other two pictures that are wanted
/// together.
#[derive(Debug, Clone)]
pub struct PatchesRequest {
    /// The picture of A.
    pub a: PictureRequest,
    /// The picture of B.
    pub b: PictureRequest,
}

impl PatchesRequest {
    /// Whether both ask for the same pixels.
    pub fn same_pictures(&self, other: &Self) -> bool {
        self.a.same_picture(&other.a) && self.b.same_picture(&other.b)
    }
}

/// The pictures that a [`PatchesRequest`] asked for.
#[derive(Debug, Clone)]
pub struct Patches {
    /// The picture of A.
    pub a: Picture,
    /// The picture of B.
    pub b: Picture,
}
