//! The worker that reads trajectories and compares them, away from the window.

use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use crate::requests::{ComparedPoses, PosesRequest, Running};
use std::sync::Arc;
use std::time::Duration;

/// The worker that compares trajectories.
pub struct PoseWorker {
    jobs: Jobs<PosesRequest, ComparedPoses>,
}

impl PoseWorker {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        Self { jobs: Jobs::new(queue, Priority::Search, Duration::ZERO, PosesRequest::compute) }
    }

    /// Starts a comparison; the one that runs is dropped.
    pub fn submit(&self, request: PosesRequest) {
        self.jobs.submit(request);
    }

    /// What is being done now, if anything.
    pub fn running(&self) -> Option<Running> {
        self.jobs.running()
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        self.jobs.is_idle()
    }

    pub(super) fn poll(&self) -> impl Iterator<Item = JobAnswer<ComparedPoses>> {
        self.jobs.take_answers()
    }
}
