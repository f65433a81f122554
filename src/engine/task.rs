//! Tasks: small work that must not block the window, such as writing a file, finished even when the window closes.

use super::jobs::{JobAnswer, Jobs};
use super::queue::{Lane, Manner};
use super::{JobQueue, locked};
use crate::monitor::Monitor;
use crate::requests::{JobError, Urgency};
use std::any::TypeId;
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
    queue: Arc<JobQueue>,
    started: Mutex<Started>,
}

/// Number of the newest task, and the tasks whose end was not taken, oldest first.
type Started = (u32, Vec<(TaskId, String, Jobs<Work, String>)>);

impl Tasks {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        Self { queue: queue.clone(), started: Mutex::default() }
    }

    pub(super) fn start(&self, label: &str, work: Work) -> TaskId {
        let run = |work: Work, _: &Monitor| work().map_err(JobError::Failed);
        let jobs = Jobs::new(&self.queue, Urgency::Write, Duration::ZERO, run);
        // Each task is of a kind of its own, so that none supersedes another; they run one at a time, in their order.
        jobs.submit_as(Manner { lane: Lane::Type(TypeId::of::<Self>(), Urgency::Write), ..jobs.manner }, work);
        let mut started = locked(&self.started);
        started.0 += 1;
        let id = TaskId(started.0);
        started.1.push((id, label.to_owned(), jobs));
        id
    }

    pub(super) fn take_done(&self) -> Vec<TaskDone> {
        let mut done = Vec::new();
        locked(&self.started).1.retain(|(id, label, jobs)| {
            let ended = jobs.take_answers().pop().map(|JobAnswer { result, .. }| result);
            let goes_on = ended.is_none();
            done.extend(ended.map(|result| TaskDone { id: *id, label: label.clone(), result }));
            goes_on
        });
        done
    }
}
