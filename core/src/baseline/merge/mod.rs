//! Burst merge: the frames of a burst, aligned to its middle frame and averaged into one image of less noise.
//!
//! After Hasinoff et al., "Burst photography for high dynamic range and low-light imaging on mobile cameras" (2016),
//! which Ravendran, Bryson and Dansereau, "Burst imaging for light-constrained structure-from-motion" (2022) use for
//! reconstruction. Two differences: the search weighs a tile's pixels against the coarser level's shift by the share of
//! signal in the tile, and the shrinkage works on real cosines. Frames → [`align`] (a shift for each tile of the middle
//! frame, over a pyramid; each frame by itself) → [`temporal`] (robust mean over time, tile by tile) → one image.

mod align;
mod temporal;
mod tiles;

use crate::monitor::{Cancelled, Monitor, Stage};
use crate::{burst::Burst, detector::noise::frame_noise, plane::Plane};
use std::ops::Range;

/// Minimum noise assumed of a frame, fraction of full scale: the quantisation noise of 16 bits.
const MIN_NOISE: f32 = 1.0 / 65535.0 / 3.464_101_6;

/// Merges the frames `used` of `burst` into a burst of one frame, aligned to the frame N/2 of N, as SIFT uses.
///
/// # Panics
/// When `used` holds no frame or reaches past the burst: a mistake of the caller.
pub fn merge_burst(burst: &Burst, used: Range<usize>, monitor: &Monitor) -> Result<Burst, Cancelled> {
    assert!(!used.is_empty() && used.end <= burst.len(), "the frames that are merged must be in the burst");
    let middle = used.start + used.len() / 2;
    monitor.report(Stage::Merge, 0.0);
    let noise = frame_noise(burst, used.clone(), monitor)?.max(MIN_NOISE);
    let image = merge_frames(&burst.frames[used.clone()].iter().map(|f| &**f).collect::<Vec<_>>(), noise, monitor)?;
    let mut merged = super::of_one_image(burst, "merge", image, used.len());
    merged.frame_names = vec![burst.frame_names[middle].clone()];
    Ok(merged)
}

/// Frames merged in the geometry of the middle one; `noise` is the standard deviation in one frame, above 0.
fn merge_frames(frames: &[&Plane], noise: f32, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let middle = frames.len() / 2;
    let reference = frames[middle];
    if frames.len() == 1 || reference.data().is_empty() {
        return Ok(reference.clone());
    }
    let variance = noise * noise;
    let levels = align::pyramid(reference);
    let mut others = Vec::with_capacity(frames.len() - 1);
    for (t, frame) in frames.iter().enumerate().filter(|(t, _)| *t != middle) {
        monitor.check()?;
        let shifts = align::align(&levels, &align::pyramid(frame), variance, monitor)?;
        others.push(temporal::Aligned { frame, shifts });
        monitor.report(Stage::Merge, 0.8 * (t + 1) as f32 / frames.len() as f32);
    }
    let merged = temporal::merge_tiles(reference, &others, variance, monitor)?;
    monitor.report(Stage::Merge, 1.0);
    // The result has the geometry of the middle frame, and so its mask.
    Ok(merged.with_mask(reference.mask().cloned()))
}
