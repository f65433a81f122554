//! Loop of a thread of the queue: takes the most urgent work that is free, does it, and publishes its answer.

use super::state::{RunningJob, WaitingJob};
use super::{Shared, Standing};
use crate::engine::{OnUpdate, fault, locked};
use crate::monitor::{Monitor, Progress};
use crate::requests::Urgency;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

const PROGRESS_EVERY: Duration = Duration::from_millis(40);

pub(super) fn work(shared: &Shared, thread: &str, limit: Urgency) {
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
pub(super) fn unique_key(limit: Urgency) -> String {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    format!("{}-{limit:?}", COUNTER.fetch_add(1, Ordering::Relaxed))
}

/// Pool of one thread's parallel loops; `None` where the system refuses it: the shared pool then has a longer queue.
fn pool(thread: &str) -> Option<rayon::ThreadPool> {
    let thread = thread.to_owned();
    rayon::ThreadPoolBuilder::new().thread_name(move |i| format!("{}{thread}.{i}", fault::THREAD_PREFIX)).build().ok()
}
