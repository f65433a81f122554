//! Where the features of a pair were lost on the way to a match, and the pictures of what they were compared with.

use super::Running;
use super::fault::JobError;
use super::jobs::{JobAnswer, Jobs};
use super::pair::MatchRequest;
use super::picture::{Picture, PictureRequest};
use super::picture_jobs::{PICTURE_GRACE, SharedCache};
use super::queue::{JobQueue, Priority};
use crate::inspect::unmatched::{ComparedPair, Losses, Lost, NearestOfBoth};
use crate::matching::MatchResult;
use std::sync::Arc;
use std::time::Duration;

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

/// The workers.
pub struct LossWorkers {
    losses: Jobs<LossesRequest, FoundLosses>,
    pictures: Jobs<Vec<PictureRequest>, Vec<Picture>>,
}

impl LossWorkers {
    pub(super) fn new(queue: &Arc<JobQueue>, cache: &SharedCache) -> Self {
        let its = cache.clone();
        Self {
            losses: Jobs::new(queue, Priority::Search, Duration::ZERO, |request: LossesRequest, monitor| {
                let losses = Losses::new(request.pair(), monitor)?;
                let counts = losses.counts(monitor)?;
                let lost = (0..request.request.a.features.len()).map(|index| losses.lost(index)).collect();
                let nearest = losses.nearest();
                Ok(FoundLosses { request, lost, counts, nearest })
            }),
            pictures: Jobs::new(
                queue,
                Priority::Picture,
                PICTURE_GRACE,
                move |requests: Vec<PictureRequest>, monitor| {
                    requests.iter().map(|request| its.get_or_make(request, monitor)).collect::<Result<_, JobError>>()
                },
            ),
        }
    }

    /// Asks where features were lost.
    pub fn start(&self, request: LossesRequest) {
        self.losses.submit(request);
    }

    /// Asks for the pictures from which patches are cut.
    pub fn request_pictures(&self, requests: Vec<PictureRequest>) {
        self.pictures.submit(requests);
    }

    /// Where they were lost, if that is known since the last call. Never waits.
    pub fn poll(&self) -> impl Iterator<Item = JobAnswer<FoundLosses>> {
        self.losses.take_answers()
    }

    /// The pictures, if they are there since the last call. Never waits.
    pub fn poll_pictures(&self) -> impl Iterator<Item = JobAnswer<Vec<Picture>>> {
        self.pictures.take_answers()
    }

    /// How far it is, if anything is done.
    pub fn running(&self) -> Option<Running> {
        self.losses.running()
    }
}
