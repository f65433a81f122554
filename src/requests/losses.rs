//! Losses of a pair: the step of matching at which each feature of A was lost.

use super::error::JobError;
use super::pair::MatchRequest;
use super::request::{Request, Urgency, Work};
use crate::inspect::unmatched::{ComparedPair, Losses, Lost, NearestOfBoth};
use crate::matching::MatchResult;
use std::convert::Infallible;
use std::sync::Arc;

/// Request for the losses of a pair.
#[derive(Debug, Clone)]
pub struct LossesRequest {
    /// The features and how they were matched.
    pub request: MatchRequest,
    /// Result of matching them.
    pub result: Arc<MatchResult>,
    /// (columns, rows) of B.
    pub size_b: (usize, usize),
}

impl LossesRequest {
    /// The pair in the form that [`crate::inspect::unmatched`] takes.
    pub fn pair(&self) -> ComparedPair<'_> {
        let MatchRequest { a, b, params } = &self.request;
        ComparedPair { a, b, size_b: self.size_b, result: &self.result, params }
    }
}

impl Request for LossesRequest {
    type Answer = FoundLosses;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.result, &other.result)
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<FoundLosses, JobError> {
        let losses = Losses::new(self.pair(), work.monitor)?;
        let counts = losses.counts(work.monitor)?;
        let lost = (0..self.request.a.features.len()).map(|index| losses.lost(index)).collect();
        let nearest = losses.nearest();
        Ok(FoundLosses { request: self, lost, counts, nearest })
    }
}

/// Losses of the features of A.
#[derive(Debug, Clone)]
pub struct FoundLosses {
    /// The pair.
    pub request: LossesRequest,
    /// Step at which each feature of A was lost.
    pub lost: Vec<Lost>,
    /// Number of features that were lost at each step.
    pub counts: [(Lost, usize); 5],
    /// Nearest neighbours of both sides, for questions about single features.
    pub nearest: Arc<NearestOfBoth>,
}
