//! Memory limit of a search: its need is estimated before it starts, and a search that would take more is done in
//! groups of slopes, or refused where even that takes too much.
//!
//! The part that grows with the search is held for every slope: the first level of each octave after the first, from
//! which the next one is made and keypoints are described. Besides, there are the frames, cleaned by the noise model
//! and at each octave's resolution, and the threads' windows of slopes, which have a bound of their own.

mod account;
mod plan;

pub use crate::plane::memory::machine_bytes;
pub(crate) use account::{Account, OF_PROCESS};
pub(crate) use plan::Plan;

use super::params::slope_grid::{Slope, SlopeGrid};
use super::params::{DetectorParams, Method, ParamError, SearchParams};
use super::scale_space::levels::{octave_size, searched_octaves};
use crate::kernel::machine::{WINDOW_BYTES, WINDOWS_BYTES};
use std::sync::atomic::{AtomicU64, Ordering};

/// Part of the machine's memory that searches may take by default.
pub const DEFAULT_PART: f64 = 0.75;

/// Name of the budget on the command line.
pub const OPTION: &str = "memory";

/// Budget in bytes; 0 for the default.
static BUDGET: AtomicU64 = AtomicU64::new(0);

/// Sets the memory that all searches of this process may take together, bytes; `None` is [`DEFAULT_PART`] of the
/// machine's memory. Results do not depend on it: a search that would take more is done in groups of slopes, one after
/// the other, or refused where even that takes more.
pub fn set_budget(bytes: Option<u64>) {
    BUDGET.store(bytes.map_or(0, |bytes| bytes.max(1)), Ordering::Relaxed);
}

/// Memory that searches may take, bytes; `None` where none was set and the machine's memory is not known.
pub fn budget() -> Option<u64> {
    match BUDGET.load(Ordering::Relaxed) {
        0 => machine_bytes().map(|bytes| (bytes as f64 * DEFAULT_PART) as u64),
        bytes => Some(bytes),
    }
}

/// Part of the budget for data that detections keep to explain their results, at most [`KEPT_BYTES`].
const KEPT_PART: f64 = 0.125;
/// Maximum of that data, whatever the budget, bytes.
const KEPT_BYTES: u64 = 512 << 20;

/// Memory for data that detections keep to explain their results, bytes. A search that keeps such data has the rest of
/// the budget.
pub fn kept_bytes() -> u64 {
    budget().map_or(KEPT_BYTES, |budget| ((budget as f64 * KEPT_PART) as u64).min(KEPT_BYTES))
}

/// Checks, before a burst is opened, that its search will be possible: `frames` frames of `size` (columns, rows), of
/// which `params` may leave some out, searched within [`budget`]. Where the slopes are to be found from the burst, a
/// single slope is assumed, the fewest that a search holds.
///
/// # Errors
/// As the search itself: the error gives the memory that it needs at least, and settings that need less.
pub fn check_before_opening(params: &SearchParams, frames: usize, size: (usize, usize)) -> Result<(), ParamError> {
    let mut detector = params.detector.clone();
    if params.slopes.is_auto() {
        detector.slopes = SlopeGrid::single(Slope::default());
    }
    // A merge is a single image when it is searched.
    let frames = if detector.method == Method::Merge { 1 } else { detector.used_frames(frames).len() };
    Plan::new(&detector, frames, size, budget()).map(|_| ())
}

/// Estimates the memory that a search with `params` needs besides the burst if all slopes are searched at once, bytes;
/// `frames` frames of `size` (columns, rows) take part.
pub fn estimate(params: &DetectorParams, frames: usize, size: (usize, usize)) -> u64 {
    estimate_on(rayon::current_num_threads(), params, frames, size)
}

/// As [`estimate`], for a search on `threads` threads.
fn estimate_on(threads: usize, params: &DetectorParams, frames: usize, size: (usize, usize)) -> u64 {
    let slopes = params.used_slopes().len() as u64;
    slopes.saturating_mul(bytes_of_slope(params, size)).saturating_add(bytes_beside_slopes(threads, frames, size))
}

/// Memory that a search on `threads` threads needs, whatever the number of slopes; bytes.
fn bytes_beside_slopes(threads: usize, frames: usize, size: (usize, usize)) -> u64 {
    let windows = threads.saturating_mul(WINDOW_BYTES).min(WINDOWS_BYTES);
    // The cleaned frames, and their octaves together.
    let of_frames = (frames as u64).saturating_mul(plane_bytes(size)).saturating_mul(7) / 3;
    of_frames.saturating_add(windows as u64)
}

/// Memory held for one slope, bytes.
fn bytes_of_slope(params: &DetectorParams, size: (usize, usize)) -> u64 {
    searched_octaves(params, size).skip(1).map(|octave| plane_bytes(octave_size(size, octave))).sum()
}

fn plane_bytes((width, height): (usize, usize)) -> u64 {
    (width as u64).saturating_mul(height as u64).saturating_mul(size_of::<f32>() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::SlopeGrid;

    #[test]
    fn the_estimate_grows_with_slopes_and_the_first_octave() {
        let size = (1600, 1200);
        let plane =
            DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 64, -3.0..=3.0, 64), ..DetectorParams::default() };
        let fine = DetectorParams { first_octave: -1, ..plane.clone() };
        let of = |params: &DetectorParams| estimate(params, 10, size) as f64 / 1e9;
        assert!((8.0..13.0).contains(&of(&plane)), "{}", of(&plane));
        assert!((32.0..45.0).contains(&of(&fine)), "{}", of(&fine));
        assert!(of(&DetectorParams::default()) < 0.5);
        assert!(estimate(&plane, usize::MAX >> 8, (1 << 30, 1 << 30)) > 1 << 60, "huge, and no overflow");
    }
}
