//! The worker that remakes the figures of the paper into a folder: the command `figures`, as a request.

use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use crate::figures::{FiguresJob, FiguresReport};
use crate::monitor::Monitor;
use crate::requests::Running;
use std::sync::Arc;
use std::time::Duration;

/// The worker. Finished figures stay in the folder, so that what was cancelled goes on another time.
pub struct FigureWorker {
    jobs: Jobs<FiguresJob, FiguresReport>,
}

impl FigureWorker {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        let make = |job: FiguresJob, monitor: &Monitor| Ok(job.run(&mut |_| {}, monitor)?);
        Self { jobs: Jobs::new(queue, Priority::Dataset, Duration::ZERO, make) }
    }

    /// Starts making figures; what runs is cancelled.
    pub fn start(&self, job: FiguresJob) {
        self.jobs.submit(job);
    }

    /// Cancels what runs and what waits.
    pub fn cancel(&self) {
        self.jobs.cancel();
    }

    /// What is being done now, if anything.
    pub fn running(&self) -> Option<Running> {
        self.jobs.running()
    }

    /// What was published since the last call.
    pub fn poll(&self) -> impl Iterator<Item = JobAnswer<FiguresReport>> + use<> {
        self.jobs.take_answers()
    }
}
