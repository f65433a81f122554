//! The worker that compares methods: one piece of work at a time, each with all threads, so that their times can be
//! compared too.
//!
//! Which piece comes next is for the asker to say, who sees what is missing whenever one is finished.

use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use crate::requests::{CompareRequest, Compared, JobId, Running};
use std::sync::Arc;
use std::time::Duration;

/// The worker.
pub struct Comparer(Jobs<CompareRequest, Compared>);

impl Comparer {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        Self(Jobs::new(queue, Priority::Search, Duration::ZERO, CompareRequest::compute))
    }

    /// Starts a piece of work; the one that runs is cancelled.
    pub fn start(&self, request: CompareRequest) -> JobId {
        self.0.submit(request)
    }

    /// What came of the pieces that ended since the last call. Never waits.
    pub fn poll(&self) -> impl Iterator<Item = JobAnswer<Compared>> {
        self.0.take_answers()
    }

    /// What it is doing now, if anything.
    pub fn running(&self) -> Option<Running> {
        self.0.running()
    }

    /// Cancels what it is doing: its answer is [`JobError::Cancelled`](crate::requests::JobError::Cancelled).
    pub fn cancel(&self) {
        self.0.cancel();
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        self.0.is_idle()
    }
}
