//! Tasks: small work that must not block the window, such as writing a file, finished even when the window closes.

use super::jobs::{JobAnswer, Jobs};
use super::{JobQueue, locked};
use crate::monitor::Monitor;
use crate::requests::{JobError, Urgency};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TaskId(u32);

#[derive(Debug, Clone)]
pub struct TaskDone {
    pub id: TaskId,
    pub label: String,
    pub result: Result<String, JobError>,
}

pub(super) type Work = Box<dyn FnOnce() -> Result<String, String> + Send>;

pub(super) struct Tasks {
    jobs: Jobs<Work, String>,
    /// Number of the newest task, and labels of the tasks that have not ended.
    labels: Mutex<(u32, HashMap<u32, String>)>,
}

impl Tasks {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        let run = |work: Work, _: &Monitor| work().map_err(JobError::Failed);
        Self { jobs: Jobs::new(queue, Urgency::Write, Duration::ZERO, run), labels: Mutex::default() }
    }

    pub(super) fn start(&self, label: &str, work: Work) -> TaskId {
        // Each task has a slot of its own: none supersedes another.
        let slot = {
            let mut labels = locked(&self.labels);
            labels.0 += 1;
            let slot = labels.0;
            labels.1.insert(slot, label.to_owned());
            slot
        };
        self.jobs.submit_for(slot, work);
        TaskId(slot)
    }

    pub(super) fn take_done(&self) -> Vec<TaskDone> {
        let answers = self.jobs.take_answers_for();
        let mut labels = locked(&self.labels);
        let done = |(slot, JobAnswer { result, .. })| TaskDone {
            id: TaskId(slot),
            label: labels.1.remove(&slot).unwrap_or_default(),
            result,
        };
        answers.into_iter().map(done).collect()
    }
}
