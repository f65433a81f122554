//! A lane: a named thread with a single-slot mailbox. The latest request wins.

use super::fault::{self, JobError};
use super::{OnUpdate, Running};
use crate::monitor::{Monitor, Progress};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Identifies one request of one lane; later requests have larger ids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct JobId(u64);

impl JobId {
    pub(super) fn new(number: u64) -> Self {
        Self(number)
    }

    pub(super) fn number(self) -> u64 {
        self.0
    }
}

/// What became of a request.
#[derive(Debug, Clone)]
pub struct Answer<A> {
    /// The request it answers.
    pub id: JobId,
    /// The result, or why there is none.
    pub result: Result<A, JobError>,
    /// How long it took, by the wall clock; zero for an answer that was there already.
    pub elapsed: Duration,
}

/// Progress wakes the listener at most this often.
const PROGRESS_EVERY: Duration = Duration::from_millis(40);

struct Current {
    id: JobId,
    monitor: Monitor,
    started: Instant,
    superseded: bool,
    progress: Arc<Mutex<Option<Progress>>>,
}

struct Slots<Q, A> {
    waiting: Option<(JobId, Q)>,
    current: Option<Current>,
    answer: Option<Answer<A>>,
    /// The newest id given out, and the newest whose answer was published.
    newest: u64,
    published: u64,
    stop: bool,
}

struct Shared<Q, A> {
    slots: Mutex<Slots<Q, A>>,
    wake: Condvar,
}

impl<Q, A> Shared<Q, A> {
    fn lock(&self) -> MutexGuard<'_, Slots<Q, A>> {
        // The work runs outside the lock and its panics are caught, so a poisoned lock still guards whole values.
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One worker thread for requests `Q` with answers `A`. Dropping it cancels what runs and lets the thread end by
/// itself.
pub struct Lane<Q, A> {
    shared: Arc<Shared<Q, A>>,
    grace: Duration,
    on_update: OnUpdate,
}

impl<Q: Send + 'static, A: Send + 'static> Lane<Q, A> {
    /// Starts the worker called `name`, with a thread pool of its own for its parallel loops. A superseded request is
    /// cancelled once it has run for `grace`; if it ends before, its answer is published all the same. With zero
    /// `grace` it is cancelled at once and its answer is dropped.
    pub fn new(
        name: &str,
        grace: Duration,
        on_update: OnUpdate,
        work: impl Fn(Q, &Monitor) -> Result<A, JobError> + Send + Sync + 'static,
    ) -> Self {
        fault::install_hook();
        let shared = Arc::new(Shared {
            slots: Mutex::new(Slots {
                waiting: None,
                current: None,
                answer: None,
                newest: 0,
                published: 0,
                stop: false,
            }),
            wake: Condvar::new(),
        });
        let key = unique_key(name);
        let (its, update) = (shared.clone(), on_update.clone());
        std::thread::Builder::new()
            .name(format!("{}{key}", fault::THREAD_PREFIX))
            .spawn(move || worker(&its, &key, grace, &update, &work))
            .expect("the system can start a handful of threads");
        Self { shared, grace, on_update }
    }

    /// Puts a request into the mailbox in place of the one that waits there, and supersedes the one that runs.
    pub fn submit(&self, request: Q) -> JobId {
        let mut slots = self.shared.lock();
        slots.newest += 1;
        let id = JobId(slots.newest);
        slots.waiting = Some((id, request));
        if self.grace.is_zero() {
            slots.answer = None;
        }
        supersede(&mut slots, self.grace);
        self.shared.wake.notify_one();
        id
    }

    /// Answers a request that needs no work, as if it had been submitted and had run.
    pub fn publish(&self, answer: A) -> JobId {
        let mut slots = self.shared.lock();
        slots.newest += 1;
        let id = JobId(slots.newest);
        slots.waiting = None;
        supersede(&mut slots, Duration::ZERO);
        slots.published = id.0;
        slots.answer = Some(Answer { id, result: Ok(answer), elapsed: Duration::ZERO });
        drop(slots);
        (self.on_update)();
        id
    }

    /// Takes the newest answer, if one was published since the last call.
    pub fn take_answer(&self) -> Option<Answer<A>> {
        self.shared.lock().answer.take()
    }

    /// Forgets the request that waits and cancels the one that runs.
    pub fn cancel(&self) {
        let mut slots = self.shared.lock();
        if let Some(current) = &slots.current {
            current.monitor.cancel();
        } else if let Some((id, _)) = slots.waiting {
            slots.published = id.0;
            slots.answer = Some(Answer { id, result: Err(JobError::Cancelled), elapsed: Duration::ZERO });
        }
        slots.waiting = None;
    }

    /// Cancels a superseded request that has had its grace.
    pub fn enforce_grace(&self) {
        let slots = self.shared.lock();
        if let Some(current) = &slots.current
            && current.superseded
            && current.started.elapsed() >= self.grace
        {
            current.monitor.cancel();
        }
    }

    /// The request that runs, or the one that waits to.
    pub fn running(&self) -> Option<Running> {
        let slots = self.shared.lock();
        let waiting =
            slots.waiting.as_ref().map(|(id, _)| Running { id: *id, started: Instant::now(), progress: None });
        slots
            .current
            .as_ref()
            .map(|current| Running {
                id: current.id,
                started: current.started,
                progress: *current.progress.lock().unwrap_or_else(PoisonError::into_inner),
            })
            .or(waiting)
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        let slots = self.shared.lock();
        slots.waiting.is_none() && slots.current.is_none()
    }
}

impl<Q, A> Drop for Lane<Q, A> {
    fn drop(&mut self) {
        let mut slots = self.shared.lock();
        slots.stop = true;
        slots.waiting = None;
        if let Some(current) = &slots.current {
            current.monitor.cancel();
        }
        self.shared.wake.notify_one();
    }
}

fn supersede<Q, A>(slots: &mut Slots<Q, A>, grace: Duration) {
    if let Some(current) = &mut slots.current {
        current.superseded = true;
        if current.started.elapsed() >= grace {
            current.monitor.cancel();
        }
    }
}

fn worker<Q: Send, A: Send>(
    shared: &Shared<Q, A>,
    key: &str,
    grace: Duration,
    on_update: &OnUpdate,
    work: &(impl Fn(Q, &Monitor) -> Result<A, JobError> + Sync),
) {
    // Made when there is work for it: many a lane never gets any.
    let threads = std::cell::LazyCell::new(|| pool(key));
    loop {
        let (id, request, monitor, started) = {
            let mut slots = shared.lock();
            loop {
                if slots.stop {
                    return;
                }
                if let Some((id, request)) = slots.waiting.take() {
                    let progress = Arc::new(Mutex::new(None));
                    let monitor = listening_monitor(progress.clone(), on_update.clone());
                    let started = Instant::now();
                    slots.current =
                        Some(Current { id, monitor: monitor.clone(), started, superseded: false, progress });
                    break (id, request, monitor, started);
                }
                slots = shared.wake.wait(slots).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let result = fault::guard(key, || match &*threads {
            Some(pool) => pool.install(|| work(request, &monitor)),
            None => work(request, &monitor),
        });
        let elapsed = started.elapsed();
        {
            let mut slots = shared.lock();
            let superseded = slots.current.take().is_some_and(|c| c.superseded);
            let unwanted = superseded && (grace.is_zero() || matches!(result, Err(JobError::Cancelled)));
            if !unwanted && id.0 > slots.published {
                slots.published = id.0;
                slots.answer = Some(Answer { id, result, elapsed });
            }
        }
        on_update();
    }
}

fn listening_monitor(progress: Arc<Mutex<Option<Progress>>>, on_update: OnUpdate) -> Monitor {
    let told = Mutex::new(None::<Instant>);
    Monitor::with_listener(move |now| {
        *progress.lock().unwrap_or_else(PoisonError::into_inner) = Some(now);
        let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.is_none_or(|at| at.elapsed() >= PROGRESS_EVERY) {
            *told = Some(Instant::now());
            on_update();
        }
    })
}

pub(super) fn unique_key(name: &str) -> String {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    format!("{}-{name}", COUNTER.fetch_add(1, Ordering::Relaxed))
}

/// Threads for the parallel loops of one lane's work, named so that their panics are found; or `None` where the system
/// has none to give: then the shared pool serves. Work given to the shared pool would wait behind all that a detection
/// has queued there.
pub(super) fn pool(key: &str) -> Option<rayon::ThreadPool> {
    let key = key.to_owned();
    rayon::ThreadPoolBuilder::new().thread_name(move |i| format!("{}{key}.{i}", fault::THREAD_PREFIX)).build().ok()
}
