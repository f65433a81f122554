//! Tasks: small work that must not block the window, such as writing a file, finished even when the window closes.

use super::jobs::{JobAnswer, Jobs};
use super::queue::{Lane, Manner};
use super::{Engine, locked};
use crate::monitor::Monitor;
use crate::requests::{JobError, Urgency};
use std::any::TypeId;
use std::time::Duration;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TaskId(u32);

#[derive(Debug, Clone)]
pub struct TaskDone {
    pub id: TaskId,
    pub label: String,
    pub result: Result<String, JobError>,
}

type Work = Box<dyn FnOnce() -> Result<String, String> + Send>;

/// Number of the newest task, and the tasks whose end was not taken, oldest first.
pub(super) type Tasks = (u32, Vec<(TaskId, String, Jobs<Work, String>)>);

impl Engine {
    pub fn task(&self, label: &str, work: impl FnOnce() -> Result<String, String> + Send + 'static) -> TaskId {
        let run = |work: Work, _: &Monitor| work().map_err(JobError::Failed);
        let jobs = Jobs::new(&self.queue, Urgency::Write, Duration::ZERO, run);
        // Each task is of a kind of its own, so that none supersedes another; they run one at a time, in their order.
        let lane = Lane::Type(TypeId::of::<Tasks>(), Urgency::Write);
        jobs.submit_as(Manner { lane, ..jobs.manner }, Box::new(work));
        let mut tasks = locked(&self.tasks);
        tasks.0 += 1;
        let id = TaskId(tasks.0);
        tasks.1.push((id, label.to_owned(), jobs));
        id
    }

    /// The tasks that ended since the last call, oldest first. Never waits.
    pub fn take_tasks(&self) -> Vec<TaskDone> {
        let mut done = Vec::new();
        locked(&self.tasks).1.retain(|(id, label, jobs)| {
            let ended = jobs.take_answers().pop().map(|JobAnswer { result, .. }| result);
            let goes_on = ended.is_none();
            done.extend(ended.map(|result| TaskDone { id: *id, label: label.clone(), result }));
            goes_on
        });
        done
    }
}
