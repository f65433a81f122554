//! Bursts with exactly known truth: charts of discs, layered scenes, and the camera's noise.
//!
//! First the *signal* of each frame is drawn without noise: discs or textured layers, each moved by its own slope. Then
//! a [`Camera`] captures it. The drawn objects, their positions and motions are the [`Truth`]. The same seed gives the
//! same bits on every machine and with any threads: frames have own random streams, and logarithms come from `libm`.
//!
//! ```
//! use burstscope_core::synth::{ChartParams, synth_chart};
//! use burstscope_core::Monitor;
//! let params = ChartParams { width: 160, height: 120, discs: 4, frames: 3, ..ChartParams::default() };
//! let (burst, truth) = synth_chart(&params, &Monitor::default())?;
//! assert_eq!((burst.len(), truth.features.len()), (3, 4));
//! # Ok::<(), burstscope_core::Error>(())
//! ```

mod arm;
pub mod chart;
pub mod demo;
pub mod examples;
mod layer;
pub mod noise;
pub mod noise_case;
#[cfg(feature = "cli")]
pub mod options;
pub mod paint;
pub mod random;
pub mod scene;
pub mod truth;
pub mod uneven;

pub use chart::{ChartParams, RadiusLaw, synth_chart};
pub use demo::{demo_burst, demo_truth, later_demo_burst};
pub use examples::Example;
pub use noise::Camera;
pub use noise_case::{NoiseCase, NoiseKind};
pub use scene::{SceneParams, synth_scene};
pub use truth::{FeatureTruth, LayerTruth, NoiseTruth, Truth, TruthKind};
pub use uneven::Uneven;

use crate::burst::{Burst, Offset};
use crate::error::{Error, Result};
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use random::Stream;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};
use uneven::Taken;

/// Directions of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// Horizontally only, as BuFF 1D searches.
    #[default]
    OneD,
    /// In any direction, as BuFF 2D searches.
    TwoD,
}

/// Maximum number of pixels of a synthetic burst, over all its frames: 2^31, 8 GiB in memory.
pub const MAX_PIXELS: u64 = 1 << 31;

/// Whether a value is the usual one, which files leave out.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Largest displacements (u, v), pixels, at `offsets` from mid-burst, of what moves by a slope (u, v).
pub fn outermost(offsets: &[Offset], slope: (f64, f64)) -> (f64, f64) {
    offsets
        .iter()
        .map(|at| at.displacement(slope))
        .fold((0.0, 0.0), |(u, v), (du, dv)| (u.max(du.abs()), v.max(dv.abs())))
}

/// Checks the parameters that all kinds of synthetic bursts have: sizes in pixels, the largest slope in px/frame, the
/// read noise in electrons; `frames` are their number and the time from the first to the last.
pub fn check_common(
    width: usize,
    height: usize,
    (frames, span): (usize, f64),
    max_slope: f64,
    read_noise: f64,
    bits: u32,
) -> Result<()> {
    for (name, pixels) in [("width", width), ("height", height)] {
        if !(16..=32768).contains(&pixels) {
            return Err(Error::param(name, format!("{pixels} pixels"), "give 16 to 32768"));
        }
    }
    if !(1..=4096).contains(&frames) {
        return Err(Error::param("frames", format!("{frames} frames"), "give 1 to 4096"));
    }
    let pixels = width as u64 * height as u64 * frames as u64;
    if pixels > MAX_PIXELS {
        let problem =
            format!("{frames} frames of {width}×{height} are {pixels} pixels, above the limit of {MAX_PIXELS}");
        return Err(Error::param("frames", problem, "make fewer or smaller frames"));
    }
    if !(max_slope.is_finite() && max_slope >= 0.0) {
        return Err(Error::param("max-slope", format!("{max_slope}"), "give 0 or more pixels per frame"));
    }
    // Things that cross the whole image would be in few frames.
    let moved_px = span * max_slope;
    if moved_px >= width.min(height) as f64 {
        let moves =
            format!("{max_slope} px/frame over {frames} frames moves things by {moved_px:.0} px, the whole image");
        return Err(Error::param("max-slope", moves, "give a smaller slope, fewer frames or a larger image"));
    }
    check_camera(read_noise, bits)
}

/// Checks a ratio of signal to noise: 0.000001 to 1000000000, or infinite.
pub fn check_snr(snr: f64) -> Result<()> {
    if snr == f64::INFINITY || (1e-6..=1e9).contains(&snr) {
        return Ok(());
    }
    Err(Error::param("snr", format!("{snr}"), "give a ratio above 0, from 0.000001 to 1000000000, or inf for no noise"))
}

/// Checks the read noise (0 or more electrons) and the bits (4 … 16) of a camera.
pub fn check_camera(read_noise: f64, bits: u32) -> Result<()> {
    if !(read_noise.is_finite() && read_noise >= 0.0) {
        return Err(Error::param("read-noise", format!("{read_noise}"), "give 0 or more electrons"));
    }
    if !(4..=16).contains(&bits) { Err(Error::param("bits", format!("{bits} bits"), "give 4 to 16")) } else { Ok(()) }
}

/// Frame t takes its noise from stream t + 1 of the seed, whatever the threads and whichever frames are left out.
fn capture_burst(
    name: &str,
    taken: &Taken,
    seed: u64,
    camera: &Camera,
    monitor: &Monitor,
    signal_at: impl Fn(Offset) -> Result<Plane, Cancelled> + Sync,
) -> Result<Burst, Cancelled> {
    let frames = taken.frames.len();
    let done = AtomicUsize::new(0);
    monitor.report(Stage::Synth, 0.0);
    let planes: Vec<Plane> = taken
        .frames
        .par_iter()
        .map(|&(t, at)| {
            monitor.check()?;
            let frame = camera.capture(&signal_at(at)?, &mut Stream::new(seed, t as u64 + 1), monitor)?;
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            monitor.report(Stage::Synth, count as f32 / frames as f32);
            Ok(frame)
        })
        .collect::<Result<_, Cancelled>>()?;
    monitor.check()?;
    let mut burst = Burst::from_planes(name, planes);
    burst.positions = taken.positions();
    // Values are words of 16 bits, so that files hold the same bits.
    burst.full_scale = 65535.0;
    burst.quantisation_step = camera.quantisation_step() as f32;
    Ok(burst)
}
