//! Background work: takes requests and publishes answers, so that no asker waits. Nothing here names a kind of request.
//!
//! A part of the window that shows an answer holds a [`Wanted`], which asks for one thing at a time: the latest request
//! wins, so scrubbing stays live while a detection runs. Each request ends in exactly one answer, which is published
//! before `on_update` is called. A panic in the work becomes an error with its place.

mod fault;
mod jobs;
mod queue;
mod task;
mod wanted;

pub use task::{TaskDone, TaskId};
pub use wanted::{Ended, Want, Wanted};

use crate::requests::{BurstId, Caches, locked};
use queue::JobQueue;
use std::sync::{Arc, Mutex};

/// Callback after something was published; may be called from any thread.
pub type OnUpdate = Arc<dyn Fn() + Send + Sync>;

pub const DEFAULT_CACHE_BYTES: usize = 256 << 20;

/// Dropping it cancels what runs, finishes the files that are being written, and returns when all threads have ended.
pub struct Engine {
    tasks: Mutex<task::Tasks>,
    caches: Caches,
    queue: Arc<JobQueue>,
}

impl Engine {
    pub fn new(on_update: OnUpdate, cache_bytes: usize) -> Self {
        let queue = Arc::new(JobQueue::new(on_update));
        Self { tasks: Mutex::default(), caches: Caches::new(cache_bytes), queue }
    }

    pub fn keep_trails_of(&self, open: &[BurstId]) {
        self.caches.trails.keep_only(open);
    }

    /// Sets the memory for pictures that are not on show, bytes.
    pub fn set_cache_bytes(&self, bytes: usize) {
        locked(&self.caches.pictures).set_budget(bytes);
    }

    pub fn held(&self) -> Held {
        let (trails, trail_bytes) = self.caches.trails.held();
        Held { picture_bytes: locked(&self.caches.pictures).bytes(), trails, trail_bytes, requests: self.queue.len() }
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Held {
    pub picture_bytes: usize,
    pub trails: usize,
    /// Bytes of the trails, without the open bursts.
    pub trail_bytes: usize,
    pub requests: usize,
}

#[cfg(test)]
mod tests;
