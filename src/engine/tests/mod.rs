//! Tests of the engine, by subject.

mod queue;
mod trails;
mod wanted;
mod work;

use super::{DEFAULT_CACHE_BYTES, Ended, Engine, JobQueue, OnUpdate, Wanted};
use crate::burst::Burst;
use crate::detector::{DetectorParams, Slope};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::requests::{BurstSource, JobError, OpenBurst, PictureCache, PictureKind, PictureRequest, Request, Work};
use std::sync::Arc;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(60);

fn nobody() -> OnUpdate {
    Arc::new(|| {})
}

fn queue() -> Arc<JobQueue> {
    Arc::new(JobQueue::new(nobody()))
}

fn until_cancelled(monitor: &Monitor) -> Result<(), JobError> {
    loop {
        monitor.check()?;
        std::thread::sleep(Duration::from_millis(1));
    }
}

pub(super) fn wait_for<T>(mut poll: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + PATIENCE;
    loop {
        if let Some(found) = poll() {
            return found;
        }
        assert!(Instant::now() < end, "nothing happened in {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn engine() -> Engine {
    Engine::new(nobody(), DEFAULT_CACHE_BYTES)
}

pub(super) fn end_of<R: Request>(wanted: &mut Wanted<R>) -> Ended<R> {
    wait_for(|| wanted.take().into_iter().next())
}

pub(super) fn answer_of<R: Request>(engine: &Engine, request: R) -> R::Answer {
    let mut wanted = Wanted::default();
    wanted.ask(engine, request);
    end_of(&mut wanted).result.expect("there is an answer")
}

fn small_burst() -> OpenBurst {
    let frame = |t: usize| Plane::from_fn(40, 32, |u, v| ((u * 7 + v * 3 + t) % 11) as f32 / 11.0);
    OpenBurst::new(Burst::from_planes("test", (0..3).map(frame).collect()), BurstSource::Demo)
}

fn stack_request(burst: &OpenBurst, slope_u: f32) -> PictureRequest {
    let kind = PictureKind::Stack { slope: Slope::new(slope_u, 0.0) };
    PictureRequest::new(burst.clone(), kind, DetectorParams::default())
}

#[test]
fn the_cache_keeps_its_budget_and_drops_the_least_recently_used() {
    let burst = small_burst();
    let one = 40 * 32 * 4;
    let mut cache = PictureCache::new(3 * one);
    let requests: Vec<_> = (0..4).map(|i| stack_request(&burst, i as f32)).collect();
    let monitor = Monitor::default();
    for request in &requests[..3] {
        cache.insert(&request.clone().compute(&Work::alone(&monitor)).expect("not cancelled"));
    }
    assert_eq!(cache.bytes(), 3 * one);
    assert!(cache.get(&requests[0]).is_some());
    cache.insert(&requests[3].clone().compute(&Work::alone(&monitor)).expect("not cancelled"));
    assert_eq!(cache.bytes(), 3 * one);
    assert!(cache.get(&requests[1]).is_none(), "the one not used for longest went");
    assert!(cache.get(&requests[0]).is_some() && cache.get(&requests[3]).is_some());
    cache.set_budget(one);
    assert!(cache.bytes() == one && cache.get(&requests[3]).is_some(), "a smaller budget holds at once");
    let mut tiny = PictureCache::new(one - 1);
    tiny.insert(&requests[0].clone().compute(&Work::alone(&monitor)).expect("not cancelled"));
    assert_eq!(tiny.bytes(), 0);
}

#[test]
fn a_picture_asked_for_again_comes_from_the_cache() {
    let (engine, burst, mut wanted) = (engine(), small_burst(), Wanted::default());
    wanted.ask(&engine, stack_request(&burst, 0.5));
    let first = end_of(&mut wanted).result.expect("valid");
    // Whoever asks for it.
    let mut other = Wanted::default();
    other.ask(&engine, stack_request(&burst, 0.5));
    let second = end_of(&mut other);
    assert_eq!(second.elapsed, Duration::ZERO);
    assert!(Arc::ptr_eq(&first.plane, &second.result.expect("valid").plane));
    wait_for(|| engine.is_idle().then_some(()));
}
