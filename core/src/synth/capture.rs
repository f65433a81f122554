//! Captures a burst from a function that draws the signal of frame t, frames in parallel.

use super::noise::Camera;
use super::random::Stream;
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Draws and captures `frames` frames. Frame t takes its noise from stream t + 1 of the seed (stream 0 lays out the
/// scene), so the result does not depend on the threads.
pub(super) fn capture_burst(
    name: &str,
    frames: usize,
    seed: u64,
    camera: &Camera,
    monitor: &Monitor,
    signal_at: impl Fn(f64) -> Result<Plane, Cancelled> + Sync,
) -> Result<Burst, Cancelled> {
    let t0 = (frames as f64 - 1.0) / 2.0;
    let done = AtomicUsize::new(0);
    monitor.report(Stage::Synth, 0.0);
    let planes: Vec<Plane> = (0..frames)
        .into_par_iter()
        .map(|t| {
            monitor.check()?;
            let signal = signal_at(t as f64 - t0)?;
            let frame = camera.capture(&signal, &mut Stream::new(seed, t as u64 + 1), monitor)?;
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            monitor.report(Stage::Synth, count as f32 / frames as f32);
            Ok(frame)
        })
        .collect::<Result<_, Cancelled>>()?;
    monitor.check()?;
    let mut burst = Burst::from_planes(name, planes);
    burst.full_scale = 65535.0;
    burst.quantisation_step = camera.quantisation_step() as f32;
    Ok(burst)
}
