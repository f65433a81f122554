//! The engine's promises, by subject.

mod burst;
mod pair;
mod pictures;
mod queue;
mod work;

use super::{JobQueue, OnUpdate};
use crate::burst::Burst;
use crate::detector::{DetectorParams, Slope};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::requests::{BurstSource, JobError, OpenBurst, PictureKind, PictureRequest};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// After this something that is awaited does not come any more.
const PATIENCE: Duration = Duration::from_secs(60);

fn nobody() -> OnUpdate {
    Arc::new(|| {})
}

fn queue() -> Arc<JobQueue> {
    Arc::new(JobQueue::new(nobody()))
}

/// Work that ends only when it is cancelled.
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

fn small_burst() -> OpenBurst {
    let frame = |t: usize| Plane::from_fn(40, 32, |u, v| ((u * 7 + v * 3 + t) % 11) as f32 / 11.0);
    OpenBurst::new(Burst::from_planes("test", (0..3).map(frame).collect()), BurstSource::Demo)
}

fn stack_request(burst: &OpenBurst, slope_u: f32) -> PictureRequest {
    let kind = PictureKind::Stack { slope: Slope::new(slope_u, 0.0) };
    PictureRequest::new(burst.clone(), kind, DetectorParams::default())
}
