//! One worker for many askers: each asks under a key of its own, and of one key the latest request wins.
//!
//! Requests wait in the order in which their keys first asked. A newer request of a key takes the place of the older
//! one in the queue, so that a key that asks again and again (a slider that is dragged) neither overtakes the others
//! nor is overtaken for ever. One piece of work runs at a time, with all threads.

use super::OnUpdate;
use super::fault::{self, JobError};
use super::lane::{Answer, JobId, pool, unique_key};
use crate::monitor::Monitor;
use std::collections::{HashMap, VecDeque};
use std::hash::Hash;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

struct Current<K> {
    key: K,
    monitor: Monitor,
    started: Instant,
    superseded: bool,
}

struct Queue<K, Q, A> {
    waiting: VecDeque<(K, JobId, Q)>,
    current: Option<Current<K>>,
    /// The newest answer of each key that was not taken yet, oldest first.
    answers: Vec<(K, Answer<A>)>,
    newest: u64,
    /// For each key the newest request whose answer was published.
    published: HashMap<K, u64>,
    stop: bool,
}

struct Shared<K, Q, A> {
    queue: Mutex<Queue<K, Q, A>>,
    wake: Condvar,
}

impl<K, Q, A> Shared<K, Q, A> {
    fn lock(&self) -> MutexGuard<'_, Queue<K, Q, A>> {
        // The work runs outside the lock and its panics are caught, so a poisoned lock still guards whole values.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<K: Copy + Eq + Hash, Q, A> Queue<K, Q, A> {
    fn publish(&mut self, key: K, answer: Answer<A>) {
        if self.published.get(&key).is_some_and(|newest| *newest >= answer.id.number()) {
            return;
        }
        self.published.insert(key, answer.id.number());
        self.answers.retain(|(k, _)| *k != key);
        self.answers.push((key, answer));
    }

    /// What runs for `key` is not wanted any more: it may go on until it has had `grace`.
    fn supersede(&mut self, key: K, grace: Duration) {
        if let Some(current) = self.current.as_mut().filter(|current| current.key == key) {
            current.superseded = true;
            if current.started.elapsed() >= grace {
                current.monitor.cancel();
            }
        }
    }
}

/// One worker thread for requests `Q` with answers `A`, asked for under keys `K`. Dropping it cancels what runs and
/// lets the thread end by itself.
pub struct KeyedLane<K, Q, A> {
    shared: Arc<Shared<K, Q, A>>,
    grace: Duration,
    on_update: OnUpdate,
}

impl<K: Copy + Eq + Hash + Send + 'static, Q: Send + 'static, A: Send + 'static> KeyedLane<K, Q, A> {
    /// Starts the worker called `name`. A superseded request is cancelled once it has run for `grace`; if it ends
    /// before, its answer is published all the same.
    pub fn new(
        name: &str,
        grace: Duration,
        on_update: OnUpdate,
        work: impl Fn(Q, &Monitor) -> Result<A, JobError> + Send + Sync + 'static,
    ) -> Self {
        fault::install_hook();
        let shared = Arc::new(Shared {
            queue: Mutex::new(Queue {
                waiting: VecDeque::new(),
                current: None,
                answers: Vec::new(),
                newest: 0,
                published: HashMap::new(),
                stop: false,
            }),
            wake: Condvar::new(),
        });
        let thread = unique_key(name);
        let (its, update) = (shared.clone(), on_update.clone());
        std::thread::Builder::new()
            .name(format!("{}{thread}", fault::THREAD_PREFIX))
            .spawn(move || worker(&its, &thread, &update, &work))
            .expect("the system can start a handful of threads");
        Self { shared, grace, on_update }
    }

    /// Asks under `key`, in place of what waits under it, and supersedes what runs under it.
    pub fn submit(&self, key: K, request: Q) -> JobId {
        let mut queue = self.shared.lock();
        queue.newest += 1;
        let id = JobId::new(queue.newest);
        match queue.waiting.iter_mut().find(|(k, ..)| *k == key) {
            Some(waiting) => *waiting = (key, id, request),
            None => queue.waiting.push_back((key, id, request)),
        }
        queue.supersede(key, self.grace);
        self.shared.wake.notify_one();
        id
    }

    /// Answers a request that needs no work, as if it had been submitted and had run.
    pub fn publish(&self, key: K, answer: A) -> JobId {
        let mut queue = self.shared.lock();
        queue.newest += 1;
        let id = JobId::new(queue.newest);
        queue.waiting.retain(|(k, ..)| *k != key);
        queue.supersede(key, Duration::ZERO);
        queue.publish(key, Answer { id, result: Ok(answer), elapsed: Duration::ZERO });
        drop(queue);
        (self.on_update)();
        id
    }

    /// Takes the newest answer of each key that has one since the last call.
    pub fn take_answers(&self) -> Vec<(K, Answer<A>)> {
        std::mem::take(&mut self.shared.lock().answers)
    }

    /// Nobody asks under `key` any more: what waits is dropped, what runs is cancelled, and no answer comes.
    pub fn forget(&self, key: K) {
        let mut queue = self.shared.lock();
        queue.waiting.retain(|(k, ..)| *k != key);
        queue.answers.retain(|(k, _)| *k != key);
        queue.supersede(key, Duration::ZERO);
        let newest = queue.newest;
        queue.published.insert(key, newest);
    }

    /// Cancels a superseded request that has had its grace.
    pub fn enforce_grace(&self) {
        let queue = self.shared.lock();
        if let Some(current) = &queue.current
            && current.superseded
            && current.started.elapsed() >= self.grace
        {
            current.monitor.cancel();
        }
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        let queue = self.shared.lock();
        queue.waiting.is_empty() && queue.current.is_none()
    }
}

impl<K, Q, A> Drop for KeyedLane<K, Q, A> {
    fn drop(&mut self) {
        let mut queue = self.shared.lock();
        queue.stop = true;
        queue.waiting.clear();
        if let Some(current) = &queue.current {
            current.monitor.cancel();
        }
        self.shared.wake.notify_one();
    }
}

fn worker<K: Copy + Eq + Hash, Q: Send, A: Send>(
    shared: &Shared<K, Q, A>,
    thread: &str,
    on_update: &OnUpdate,
    work: &(impl Fn(Q, &Monitor) -> Result<A, JobError> + Sync),
) {
    // Made when there is work for it.
    let threads = std::cell::LazyCell::new(|| pool(thread));
    loop {
        let (key, id, request, monitor, started) = {
            let mut queue = shared.lock();
            loop {
                if queue.stop {
                    return;
                }
                if let Some((key, id, request)) = queue.waiting.pop_front() {
                    let (monitor, started) = (Monitor::default(), Instant::now());
                    queue.current = Some(Current { key, monitor: monitor.clone(), started, superseded: false });
                    break (key, id, request, monitor, started);
                }
                queue = shared.wake.wait(queue).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let result = fault::guard(thread, || match &*threads {
            Some(pool) => pool.install(|| work(request, &monitor)),
            None => work(request, &monitor),
        });
        {
            let mut queue = shared.lock();
            let superseded = queue.current.take().is_some_and(|current| current.superseded);
            // A request that was superseded and then cancelled has nothing to say: a newer one of its key will.
            if !(superseded && matches!(result, Err(JobError::Cancelled))) {
                queue.publish(key, Answer { id, result, elapsed: started.elapsed() });
            }
        }
        on_update();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    const PATIENCE: Duration = Duration::from_secs(20);

    fn wait_for<T>(mut poll: impl FnMut() -> Option<T>) -> T {
        let end = Instant::now() + PATIENCE;
        loop {
            if let Some(found) = poll() {
                return found;
            }
            assert!(Instant::now() < end, "nothing happened in {PATIENCE:?}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// A lane whose work waits for a word and then answers its request; and the sender of the words.
    fn waiting_lane(grace: Duration) -> (KeyedLane<char, u32, u32>, mpsc::Sender<()>) {
        let (go, gone) = mpsc::channel();
        let gone = Mutex::new(gone);
        let work = move |request: u32, monitor: &Monitor| {
            loop {
                monitor.check()?;
                if gone.lock().expect("not poisoned").try_recv().is_ok() {
                    return Ok(request);
                }
                std::thread::sleep(Duration::from_millis(1));
            }
        };
        (KeyedLane::new("keyed", grace, Arc::new(|| {}), work), go)
    }

    fn wait_until_it_runs(lane: &KeyedLane<char, u32, u32>) {
        wait_for(|| lane.shared.lock().current.is_some().then_some(()));
    }

    fn answers(lane: &KeyedLane<char, u32, u32>, count: usize) -> Vec<(char, u32)> {
        let mut taken = Vec::new();
        wait_for(|| {
            taken.extend(lane.take_answers().into_iter().map(|(key, answer)| (key, answer.result.expect("done"))));
            (taken.len() >= count).then_some(())
        });
        taken
    }

    #[test]
    fn every_key_is_answered_with_its_latest_in_the_order_in_which_they_asked() {
        let (lane, go) = waiting_lane(Duration::from_secs(60));
        lane.submit('x', 0);
        wait_until_it_runs(&lane);
        for (key, request) in [('a', 1), ('b', 2), ('a', 3), ('c', 4), ('a', 5)] {
            lane.submit(key, request);
        }
        for _ in 0..4 {
            go.send(()).expect("the lane listens");
        }
        assert_eq!(answers(&lane, 4), [('x', 0), ('a', 5), ('b', 2), ('c', 4)]);
        wait_for(|| lane.is_idle().then_some(()));
    }

    #[test]
    fn a_key_supersedes_its_own_work_and_no_others() {
        let (lane, go) = waiting_lane(Duration::from_millis(20));
        lane.submit('a', 1);
        wait_until_it_runs(&lane);
        lane.submit('b', 2);
        std::thread::sleep(Duration::from_millis(30));
        lane.enforce_grace();
        assert!(!lane.shared.lock().current.as_ref().expect("it runs").monitor.is_cancelled(), "b is not a");
        lane.submit('a', 3);
        go.send(()).expect("the lane listens");
        go.send(()).expect("the lane listens");
        assert_eq!(answers(&lane, 2), [('b', 2), ('a', 3)]);
    }

    #[test]
    fn what_is_there_already_comes_at_once_and_what_is_forgotten_never() {
        let (lane, go) = waiting_lane(Duration::from_secs(60));
        lane.submit('a', 1);
        wait_until_it_runs(&lane);
        lane.submit('b', 2);
        lane.publish('a', 7);
        lane.forget('b');
        go.send(()).expect("the lane listens");
        wait_for(|| lane.is_idle().then_some(()));
        let taken: Vec<_> = lane.take_answers().into_iter().map(|(key, answer)| (key, answer.result)).collect();
        assert_eq!(taken, [('a', Ok(7))], "the older answer of a came too late, b is not wanted");
        lane.submit('b', 3);
        go.send(()).expect("the lane listens");
        assert_eq!(answers(&lane, 1), [('b', 3)], "a forgotten key may ask again");
    }
}
