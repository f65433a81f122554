//! Tests of the engine, by subject.

mod pictures;
mod queue;
mod wanted;
mod work;

use super::{DEFAULT_CACHE_BYTES, Ended, Engine, JobQueue, OnUpdate, Wanted};
use crate::burst::Burst;
use crate::detector::{DetectorParams, Slope};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::requests::{BurstSource, JobError, OpenBurst, PictureKind, PictureRequest, Request};
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
