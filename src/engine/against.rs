//! The worker that compares the features of a burst with others.

use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use super::trails::Trails;
use crate::monitor::Monitor;
use crate::requests::{AgainstRequest, ComparedWith, JobId, Running};
use std::sync::Arc;
use std::time::Duration;

/// The worker.
pub struct AgainstWorker(Jobs<AgainstRequest, ComparedWith>);

impl AgainstWorker {
    pub(super) fn new(queue: &Arc<JobQueue>, trails: &Trails) -> Self {
        let its = trails.clone();
        let work = move |request: AgainstRequest, monitor: &Monitor| request.compute(&its, monitor);
        Self(Jobs::new(queue, Priority::Search, Duration::ZERO, work))
    }

    /// Starts a comparison; the one that runs is cancelled.
    pub fn start(&self, request: AgainstRequest) -> JobId {
        self.0.submit(request)
    }

    /// What came of those that ended since the last call. Never waits.
    pub fn poll(&self) -> impl Iterator<Item = JobAnswer<ComparedWith>> {
        self.0.take_answers()
    }

    /// What it is doing now, if anything.
    pub fn running(&self) -> Option<Running> {
        self.0.running()
    }

    /// Cancels what it is doing.
    pub fn cancel(&self) {
        self.0.cancel();
    }
}
