//! Queue for all background work of a window, and the threads that take from it.
//!
//! Every request has a kind, which each asker has of its own. Of one kind the latest request wins: it replaces the one
//! that waits, and supersedes the one that runs, which is cancelled once its grace has ended. Some threads take only
//! urgent work, so that a picture never waits for a dataset. Every request ends in exactly one answer, which is
//! published before its work counts as done; `on_update` is called after that.

mod state;
mod threads;

use super::{OnUpdate, fault, locked};
use crate::monitor::Monitor;
use crate::requests::{JobError, JobId, Running, Urgency};
use state::{RunningJob, State, WaitingJob};
use std::any::TypeId;
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use threads::{unique_key, work};

/// Lowest urgency that each thread takes: pictures never wait for files or searches, nor searches for datasets.
pub(super) const THREADS: [Urgency; 8] = {
    use Urgency::*;
    [Picture, Write, SlowPicture, Search, Search, Search, Dataset, Dataset]
};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Manner {
    pub(super) urgency: Urgency,
    pub(super) grace: Duration,
    /// Requests of a lane run one at a time, in the order in which their kinds asked.
    pub(super) lane: Lane,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lane {
    Kind(u32),
    Type(TypeId, Urgency),
}

/// Work that waits: either `run` or `end` is called, once.
pub(super) trait QueuedJob: Send {
    /// Returns a function that publishes the answer, or [`JobError::Superseded`] in its place.
    fn run(self: Box<Self>, id: JobId, thread: &str, monitor: &Monitor) -> Publish;

    fn end(self: Box<Self>, id: JobId, why: JobError);
}

pub(super) type Publish = Box<dyn FnOnce(Standing) + Send>;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Standing {
    Latest,
    /// A newer one waits: an answer that comes in time is better than none.
    Superseded,
    /// A newer one is answered already.
    Overtaken,
}

struct Shared {
    state: Mutex<State>,
    wake: Condvar,
    on_update: OnUpdate,
}

/// Dropping it cancels all requests except the writing of files, and returns when all threads have ended.
pub struct JobQueue {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

impl JobQueue {
    pub fn new(on_update: OnUpdate) -> Self {
        fault::install_hook();
        let shared = Arc::new(Shared { state: Mutex::default(), wake: Condvar::new(), on_update });
        let start = |limit: Urgency| {
            let (its, thread) = (shared.clone(), unique_key(limit));
            std::thread::Builder::new()
                .name(format!("{}{thread}", fault::THREAD_PREFIX))
                .spawn(move || work(&its, &thread, limit))
                .expect("the system can start a handful of threads")
        };
        let threads = THREADS.into_iter().map(start).collect();
        Self { shared, threads }
    }

    pub(super) fn new_kind(&self) -> u32 {
        let mut state = locked(&self.shared.state);
        state.kinds += 1;
        state.kinds
    }

    pub(super) fn on_update(&self) -> &OnUpdate {
        &self.shared.on_update
    }

    /// Submits a request of `kind`, in place of a waiting one; a running one is superseded.
    pub(super) fn submit(&self, kind: u32, manner: Manner, job: Box<dyn QueuedJob>) -> JobId {
        let mut state = locked(&self.shared.state);
        let id = state.next_id();
        let new = WaitingJob { kind, id, manner, job };
        match state.waiting.iter_mut().find(|job| job.kind == kind) {
            Some(waiting) => {
                let old = std::mem::replace(waiting, new);
                old.job.end(old.id, JobError::Superseded);
            }
            None => state.waiting.push(new),
        }
        state.supersede(kind, Standing::Superseded);
        self.shared.wake.notify_all();
        id
    }

    pub(super) fn publish(&self, kind: u32, publish: impl FnOnce(JobId)) -> JobId {
        let mut state = locked(&self.shared.state);
        let id = state.next_id();
        state.end_waiting(kind, &JobError::Superseded);
        state.supersede(kind, Standing::Overtaken);
        // Under the lock, so that no older answer of the kind comes later.
        publish(id);
        drop(state);
        (self.shared.on_update)();
        id
    }

    pub(super) fn cancel(&self, kind: u32) {
        let mut state = locked(&self.shared.state);
        state.running.iter().filter(|job| job.kind == kind).for_each(|job| job.monitor.cancel());
        state.end_waiting(kind, &JobError::Cancelled);
        drop(state);
        (self.shared.on_update)();
    }

    pub(super) fn enforce_grace(&self) {
        locked(&self.shared.state).running.iter().for_each(RunningJob::enforce_grace);
    }

    pub(super) fn running(&self, kind: u32) -> Option<Running> {
        let state = locked(&self.shared.state);
        let running = state.running.iter().find(|job| job.kind == kind).map(|job| Running {
            id: job.id,
            started: job.started,
            progress: *locked(&job.progress),
        });
        let waiting = || state.waiting.iter().find(|job| job.kind == kind);
        running.or_else(|| waiting().map(|job| Running { id: job.id, started: Instant::now(), progress: None }))
    }

    pub(super) fn len(&self) -> usize {
        let state = locked(&self.shared.state);
        state.waiting.len() + state.running.len()
    }
}

impl Drop for JobQueue {
    fn drop(&mut self) {
        let mut state = locked(&self.shared.state);
        state.stop = true;
        // Files are still written when the window closes; all else would end without a reader.
        let (written, dropped): (Vec<_>, Vec<_>) =
            std::mem::take(&mut state.waiting).into_iter().partition(|job| job.manner.urgency == Urgency::Write);
        state.waiting = written;
        dropped.into_iter().for_each(|job| job.job.end(job.id, JobError::Cancelled));
        state.running.iter().filter(|job| job.manner.urgency != Urgency::Write).for_each(|job| job.monitor.cancel());
        drop(state);
        self.shared.wake.notify_all();
        for thread in self.threads.drain(..) {
            // Panics of work are caught and reported; a panic of the queue itself has been printed.
            let _ = thread.join();
        }
    }
}
