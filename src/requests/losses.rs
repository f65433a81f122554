//! Where the features of a pair were lost on the way to a match.

use super::error::JobError;
use super::pair::MatchRequest;
use crate::inspect::unmatched::{ComparedPair, Losses, Lost, NearestOfBoth};
use crate::matching::MatchResult;
use crate::monitor::Monitor;
use std::sync::Arc;

/// The pair that is asked about.
#[derive(Debug, Clone)]
pub struct LossesRequest {
    /// The features and how they were matched.
    pub request: MatchRequest,
    /// What came of matching them.
    pub result: Arc<MatchResult>,
    /// (columns, rows) of B.
    pub size_b: (usize, usize),
}

impl LossesRequest {
    /// Whether both ask about the same matches.
    pub fn same_pair(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.result, &other.result)
    }

    /// The same as [`crate::inspect::unmatched`] wants it.
    pub fn pair(&self) -> ComparedPair<'_> {
        let MatchRequest { a, b, params } = &self.request;
        ComparedPair { a, b, size_b: self.size_b, result: &self.result, params }
    }

    /// Finds out where each feature of A was lost.
    ///
    /// # Errors
    /// [`JobError::Cancelled`].
    pub fn compute(self, monitor: &Monitor) -> Result<FoundLosses, JobError> {
        let losses = Losses::new(self.pair(), monitor)?;
        let counts = losses.counts(monitor)?;
        let lost = (0..self.request.a.features.len()).map(|index| losses.lost(index)).collect();
        let nearest = losses.nearest();
        Ok(FoundLosses { request: self, lost, counts, nearest })
    }
}

/// Where the features of A were lost.
#[derive(Debug, Clone)]
pub struct FoundLosses {
    /// The pair.
    pub request: LossesRequest,
    /// For each feature of A.
    pub lost: Vec<Lost>,
    /// How many were lost where.
    pub counts: [(Lost, usize); 5],
    /// What single features are asked with.
    pub nearest: Arc<NearestOfBoth>,
}
