//! State of the queue: the requests that wait and run, and the choice of the next one.

use super::{Manner, QueuedJob, Standing};
use crate::monitor::{Monitor, Progress};
use crate::requests::{JobError, JobId, Urgency};
use std::sync::{Arc, Mutex};
use std::time::Instant;

pub(super) struct WaitingJob {
    pub(super) kind: u32,
    pub(super) id: JobId,
    pub(super) manner: Manner,
    pub(super) job: Box<dyn QueuedJob>,
}

pub(super) struct RunningJob {
    pub(super) kind: u32,
    pub(super) id: JobId,
    pub(super) manner: Manner,
    pub(super) monitor: Monitor,
    pub(super) started: Instant,
    pub(super) standing: Standing,
    pub(super) progress: Arc<Mutex<Option<Progress>>>,
}

impl RunningJob {
    pub(super) fn enforce_grace(&self) {
        if self.standing != Standing::Latest && self.started.elapsed() >= self.manner.grace {
            self.monitor.cancel();
        }
    }
}

#[derive(Default)]
pub(super) struct State {
    /// In the order of the first request of each kind.
    pub(super) waiting: Vec<WaitingJob>,
    pub(super) running: Vec<RunningJob>,
    pub(super) newest: u64,
    pub(super) kinds: u32,
    pub(super) stop: bool,
}

impl State {
    pub(super) fn next_id(&mut self) -> JobId {
        self.newest += 1;
        JobId(self.newest)
    }

    pub(super) fn supersede(&mut self, kind: u32, standing: Standing) {
        for job in self.running.iter_mut().filter(|job| job.kind == kind) {
            job.standing = job.standing.max(standing);
            // Its answer can no longer be of use: it is cancelled whatever its grace.
            if standing == Standing::Overtaken {
                job.monitor.cancel();
            }
            job.enforce_grace();
        }
    }

    /// Takes the most urgent request that `limit` admits and whose lane is free, of equal ones the longest waiting: a
    /// running request has all cores, and a lane answers in the order of its requests.
    pub(super) fn take(&mut self, limit: Urgency) -> Option<WaitingJob> {
        let is_free = |job: &WaitingJob| {
            job.manner.urgency <= limit
                && (!self.stop || job.manner.urgency == Urgency::Write)
                && !self
                    .running
                    .iter()
                    .any(|running| running.manner.lane == job.manner.lane || running.kind == job.kind)
        };
        let free = self.waiting.iter().enumerate().filter(|(_, job)| is_free(job));
        let index = free.min_by_key(|(index, job)| (job.manner.urgency, *index))?.0;
        Some(self.waiting.remove(index))
    }

    pub(super) fn end_waiting(&mut self, kind: u32, why: &JobError) {
        while let Some(index) = self.waiting.iter().position(|job| job.kind == kind) {
            let old = self.waiting.remove(index);
            old.job.end(old.id, why.clone());
        }
    }
}
