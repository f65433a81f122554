//! Matching the features of two bursts.

use super::error::JobError;
use super::request::{Request, Urgency, Work};
use crate::detector::Detection;
use crate::matching::{MatchParams, MatchResult, match_detections};
use std::convert::Infallible;
use std::sync::Arc;

/// Request for matches: snapshot of the features of two bursts and of the parameters.
#[derive(Debug, Clone)]
pub struct MatchRequest {
    /// The features of A.
    pub a: Arc<Detection>,
    /// The features of B.
    pub b: Arc<Detection>,
    /// The parameters.
    pub params: MatchParams,
}

impl Request for MatchRequest {
    type Answer = Matched;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.a, &other.a) && Arc::ptr_eq(&self.b, &other.b) && self.params == other.params
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<Matched, JobError> {
        let result = Arc::new(match_detections(&self.a, &self.b, &self.params, work.monitor)?);
        Ok(Matched { request: self, result })
    }
}

/// Matches with their request.
#[derive(Debug, Clone)]
pub struct Matched {
    /// The request.
    pub request: MatchRequest,
    /// The matches, and their geometry.
    pub result: Arc<MatchResult>,
}
