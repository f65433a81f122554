//! The worker that finds how evenly the frames answer for each feature of a detection.

use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use super::trails::Trails;
use crate::monitor::Monitor;
use crate::requests::{CoherenceRequest, Coherences, JobId, Running};
use std::sync::Arc;
use std::time::Duration;

/// The worker.
pub struct CoherenceWorker(Jobs<CoherenceRequest, Coherences>);

impl CoherenceWorker {
    pub(super) fn new(queue: &Arc<JobQueue>, trails: &Trails) -> Self {
        let its = trails.clone();
        let work = move |request: CoherenceRequest, monitor: &Monitor| request.compute(&its, monitor);
        Self(Jobs::new(queue, Priority::Search, Duration::ZERO, work))
    }

    /// Asks; what was asked before and is not answered yet is superseded, and cancelled.
    pub fn start(&self, request: CoherenceRequest) -> JobId {
        self.0.submit(request)
    }

    /// What was answered since the last call. Never waits.
    pub fn poll(&self) -> impl Iterator<Item = JobAnswer<Coherences>> {
        self.0.take_answers()
    }

    /// How far it is, if anything is done.
    pub fn running(&self) -> Option<Running> {
        self.0.running()
    }

    /// Cancels what it is doing.
    pub fn cancel(&self) {
        self.0.cancel();
    }
}
