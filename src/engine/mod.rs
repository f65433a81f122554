//! Background work: takes requests and publishes answers, so that no asker waits. Nothing here names a kind of request.
//!
//! A part of the window that shows an answer holds a [`Wanted`], which asks for one thing at a time: the latest request
//! wins, so scrubbing stays live while a detection runs. Each request ends in exactly one answer, which is published
//! before `on_update` is called. A panic in the work becomes an error with its place.

mod fault;
mod jobs;
mod queue;
mod stores;
mod task;
mod trails;
mod wanted;

pub use stores::Held;
pub use task::{TaskDone, TaskId};
pub use wanted::{Ended, Want, Wanted};

use crate::requests::BurstId;
use queue::JobQueue;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use stores::Stores;

/// Callback after something was published; may be called from any thread.
pub type OnUpdate = Arc<dyn Fn() + Send + Sync>;

pub const DEFAULT_CACHE_BYTES: usize = 256 << 20;

/// Dropping it cancels what runs, finishes the files that are being written, and returns when all threads have ended.
pub struct Engine {
    tasks: task::Tasks,
    stores: Stores,
    queue: Arc<JobQueue>,
}

impl Engine {
    pub fn new(on_update: OnUpdate, cache_bytes: usize) -> Self {
        let queue = Arc::new(JobQueue::new(on_update));
        Self { tasks: task::Tasks::new(&queue), stores: Stores::new(cache_bytes), queue }
    }

    pub fn keep_trails_of(&self, open: &[BurstId]) {
        self.stores.trails.keep_only(open);
    }

    pub fn task(&self, label: &str, work: impl FnOnce() -> Result<String, String> + Send + 'static) -> TaskId {
        self.tasks.start(label, Box::new(work))
    }

    /// The tasks that ended since the last call, oldest first. Never waits.
    pub fn take_tasks(&self) -> Vec<TaskDone> {
        self.tasks.take_done()
    }

    /// Cancels superseded requests whose grace has ended. To be called in every pass.
    pub fn enforce_grace(&self) {
        self.queue.enforce_grace();
    }

    /// Whether nothing runs and nothing waits. Answers may still be there to be polled.
    pub fn is_idle(&self) -> bool {
        self.queue.len() == 0
    }
}

/// Changes of what threads share are whole values, and work runs outside the locks with its panics caught: the data are
/// valid even if the lock is poisoned.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
