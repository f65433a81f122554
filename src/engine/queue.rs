//! Queue for all background work of a window, and the threads that take from it.
//!
//! Every request has a kind, which each asker has of its own. Of one kind the latest request wins: it replaces the one
//! that waits, and supersedes the one that runs, which is cancelled once its grace has ended. Some threads take only
//! urgent work, so that a picture never waits for a dataset. Every request ends in exactly one answer, which is
//! published before its work counts as done; `on_update` is called after that.

use super::{OnUpdate, fault, locked};
use crate::monitor::{Monitor, Progress};
use crate::requests::{JobError, JobId, Running, Urgency};
use std::any::TypeId;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const PROGRESS_EVERY: Duration = Duration::from_millis(40);

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

struct WaitingJob {
    kind: u32,
    id: JobId,
    manner: Manner,
    job: Box<dyn QueuedJob>,
}

struct RunningJob {
    kind: u32,
    id: JobId,
    manner: Manner,
    monitor: Monitor,
    started: Instant,
    standing: Standing,
    progress: Arc<Mutex<Option<Progress>>>,
}

impl RunningJob {
    fn enforce_grace(&self) {
        if self.standing != Standing::Latest && self.started.elapsed() >= self.manner.grace {
            self.monitor.cancel();
        }
    }
}

#[derive(Default)]
struct State {
    /// In the order of the first request of each kind.
    waiting: Vec<WaitingJob>,
    running: Vec<RunningJob>,
    newest: u64,
    kinds: u32,
    stop: bool,
}

impl State {
    fn next_id(&mut self) -> JobId {
        self.newest += 1;
        JobId(self.newest)
    }

    fn supersede(&mut self, kind: u32, standing: Standing) {
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
    fn take(&mut self, limit: Urgency) -> Option<WaitingJob> {
        let is_free = |job: &WaitingJob| {
            let Manner { urgency, lane, .. } = job.manner;
            let is_before = |running: &RunningJob| running.manner.lane == lane || running.kind == job.kind;
            urgency <= limit && (!self.stop || urgency == Urgency::Write) && !self.running.iter().any(is_before)
        };
        let free = self.waiting.iter().enumerate().filter(|(_, job)| is_free(job));
        let index = free.min_by_key(|(index, job)| (job.manner.urgency, *index))?.0;
        Some(self.waiting.remove(index))
    }

    fn end_waiting(&mut self, kind: u32, why: &JobError) {
        while let Some(index) = self.waiting.iter().position(|job| job.kind == kind) {
            let old = self.waiting.remove(index);
            old.job.end(old.id, why.clone());
        }
    }
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
        Self { threads: THREADS.into_iter().map(start).collect(), shared }
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

/// Loop of a thread: takes the most urgent work that is free, does it, and publishes its answer.
fn work(shared: &Shared, thread: &str, limit: Urgency) {
    // Made with the first work: many threads never get any.
    let threads = std::cell::LazyCell::new(|| pool(thread));
    loop {
        let (WaitingJob { kind, id, manner, job }, monitor) = {
            let mut state = locked(&shared.state);
            loop {
                if let Some(next) = state.take(limit) {
                    let progress = Arc::new(Mutex::new(None));
                    let monitor = listening_monitor(progress.clone(), shared.on_update.clone());
                    let (kind, id, manner, standing) = (next.kind, next.id, next.manner, Standing::Latest);
                    let (its, started) = (monitor.clone(), Instant::now());
                    state.running.push(RunningJob { kind, id, manner, monitor: its, started, standing, progress });
                    break (next, monitor);
                }
                if state.stop {
                    return;
                }
                state = shared.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let publish = match &*threads {
            Some(pool) => pool.install(|| job.run(id, thread, &monitor)),
            None => job.run(id, thread, &monitor),
        };
        // One step under the lock with leaving `running`: the queue is never idle before the answer is there.
        let mut state = locked(&shared.state);
        let standing = state.running.iter().find(|job| job.id == id).map_or(Standing::Latest, |job| job.standing);
        publish(standing);
        state.running.retain(|job| job.id != id);
        let waits = state.waiting.iter().any(|job| job.manner.lane == manner.lane || job.kind == kind);
        drop(state);
        if waits {
            // Another thread may take a request of this lane that waited.
            shared.wake.notify_all();
        }
        (shared.on_update)();
    }
}

fn listening_monitor(progress: Arc<Mutex<Option<Progress>>>, on_update: OnUpdate) -> Monitor {
    let told = Mutex::new(None::<Instant>);
    Monitor::with_listener(move |now| {
        *locked(&progress) = Some(now);
        let mut told = locked(&told);
        if told.is_none_or(|at| at.elapsed() >= PROGRESS_EVERY) {
            *told = Some(Instant::now());
            on_update();
        }
    })
}

/// Name that no other thread of the program has, under which the place of a panic is recorded.
fn unique_key(limit: Urgency) -> String {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    format!("{}-{limit:?}", COUNTER.fetch_add(1, Ordering::Relaxed))
}

/// Pool of one thread's parallel loops; `None` where the system refuses it: the shared pool then has a longer queue.
fn pool(thread: &str) -> Option<rayon::ThreadPool> {
    let thread = thread.to_owned();
    rayon::ThreadPoolBuilder::new().thread_name(move |i| format!("{}{thread}.{i}", fault::THREAD_PREFIX)).build().ok()
}
