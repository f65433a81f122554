//! Orientations: the main directions of the gradient around a feature.
//!
//! As in VLFeat: a histogram of 36 gradient directions within 4.5σ, weighted by a Gaussian of 1.5σ, smoothed six times,
//! whose peaks of at least 0.8 of the highest give the orientations, interpolated by a parabola.

use crate::kernel::gradient::{GradientRow, reach, vector_of, whole, window};
use crate::kernel::patch::{LANES, Patch};
use multiversion::multiversion;
use std::f32::consts::TAU;

const BINS: usize = 36;
/// Number of independent histograms, so that an addition need not wait for the one before it.
const TURNS: usize = 4;

#[derive(Debug, Default)]
pub struct OrientationScratch {
    along_u: Vec<f32>,
    along_v: Vec<f32>,
}

/// Computes the orientations of a feature at (x, y), scale `sigma`, in octave pixels: radians in [0, 2π), strongest
/// first, at most `max` (1 … 4). `level` is the Gaussian level around it, a pixel farther than 4.5σ, of an octave of
/// `size`. Without any gradient the only orientation is 0.
pub fn orientations(
    level: &Patch,
    size: (usize, usize),
    (x, y): (f32, f32),
    sigma: f32,
    max: usize,
    scratch: &mut OrientationScratch,
) -> Vec<f32> {
    let mut histogram = histogram(level, size, (x, y), sigma, scratch);
    let around = |histogram: &[f32; BINS], i: usize| [BINS - 1, 0, 1].map(|step| histogram[(i + step) % BINS]);
    // Six box filters of three bins, as in VLFeat, are nearly a Gaussian.
    for _ in 0..6 {
        histogram = std::array::from_fn(|i| {
            let [before, here, after] = around(&histogram, i);
            (before + here + after) / 3.0
        });
    }
    let highest = histogram.iter().copied().fold(0.0, f32::max);
    let mut peaks: Vec<(f32, f32)> = Vec::with_capacity(BINS / 2);
    for i in 0..BINS {
        let [before, here, after] = around(&histogram, i);
        if here > 0.8 * highest && here > before && here > after {
            let offset = -0.5 * (after - before) / (after + before - 2.0 * here);
            peaks.push((here, TAU * (i as f32 + offset + 0.5) / BINS as f32));
        }
    }
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    peaks.truncate(max);
    if peaks.is_empty() { vec![0.0] } else { peaks.into_iter().map(|(_, angle)| angle.rem_euclid(TAU)).collect() }
}

/// Weighted histogram of directions; bin `i` is centred on (i + ½)·10°.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn histogram(
    level: &Patch,
    size: (usize, usize),
    (x, y): (f32, f32),
    sigma: f32,
    scratch: &mut OrientationScratch,
) -> [f32; BINS] {
    let (spread, radius) = (1.5 * sigma, (4.5 * sigma).floor().max(1.0) as i64);
    let (columns, rows) = (reach(x, radius, size.0), reach(y, radius, size.1));
    let limit = (radius * radius) as f32 + 0.6;
    let OrientationScratch { along_u, along_v } = scratch;
    window(columns.clone(), x, spread, along_u);
    window(rows.clone(), y, spread, along_v);
    // Entry i + 1 is bin i; entries beyond each end belong to the bins at the other end.
    let mut entries = [[0.0f32; BINS + 4]; TURNS];
    for (v, &weight_v) in rows.zip(along_v.iter()) {
        let dv = v as f32 - y;
        let half = (limit - dv * dv).max(0.0).sqrt();
        // A column more on each side: the test of the disc decides per pixel, so rounding here loses none.
        let start = columns.start.max((x - half).floor() as i64);
        let end = columns.end.min((x + half).ceil() as i64 + 1);
        if start >= end {
            continue;
        }
        let (row, length) = (GradientRow::new(level, start, v), (end - start) as usize);
        let weights_u = &along_u[(start - columns.start) as usize..];
        for at in (0..length).step_by(LANES) {
            let count = LANES.min(length - at);
            let (magnitude, eighths) = row.vector(at);
            let weights = vector_of(weights_u, at);
            let (mut bin, mut lower, mut upper) = ([0u32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
            let first = start as f32 + at as f32 - x;
            for i in 0..LANES {
                let du = first + i as f32;
                let inside = du * du + dv * dv < limit;
                let weight = if inside { weights[i] * weight_v * magnitude[i] } else { 0.0 };
                let place = eighths[i] * (BINS as f32 / 8.0) + 0.5;
                let below = place.floor();
                bin[i] = whole(below);
                upper[i] = (place - below) * weight;
                lower[i] = weight - upper[i];
            }
            // Sample by sample, since several lanes may add to one bin; turns keep neighbours in different histograms.
            for i in 0..count {
                let entries = &mut entries[i % TURNS];
                let at = (bin[i] as usize).min(BINS);
                entries[at] += lower[i];
                entries[at + 1] += upper[i];
            }
        }
    }
    // The circle is closed only here: inside the loop no bin needs a test for its ends.
    let sum = |i: usize| entries.iter().map(|entries| entries[i]).sum::<f32>();
    let mut out: [f32; BINS] = std::array::from_fn(|i| sum(i + 1));
    out[BINS - 1] += sum(0);
    out[0] += sum(BINS + 1);
    out
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::detector::scale_space::Base;
    use crate::kernel::patch::PatchScratch;
    use crate::plane::Plane;

    pub const SIZE: (usize, usize) = (101, 101);

    /// An image with the values of `f`, whose place (0, 0) is the image's middle.
    pub fn level_of(f: impl Fn(f32, f32) -> f32) -> Patch {
        let plane = Plane::from_fn(SIZE.0, SIZE.1, |u, v| f(u as f32 - 50.0, v as f32 - 50.0));
        let mut level = Patch::default();
        Base::Level(&plane).patch(SIZE, 0..101, 0..101, &mut PatchScratch::default(), &mut level);
        level
    }

    fn found(f: impl Fn(f32, f32) -> f32) -> Vec<f32> {
        orientations(&level_of(f), SIZE, (50.0, 50.0), 2.0, 4, &mut OrientationScratch::default())
    }

    #[test]
    fn a_ramp_has_the_direction_in_which_it_rises() {
        for degrees in [3.0f32, 47.0, 95.0, 181.0, 275.0, 344.0, 359.5] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let found = found(|u, v| 0.01 * (cos * u + sin * v));
            assert_eq!(found.len(), 1);
            assert!((found[0].to_degrees() - degrees).abs() < 0.5, "{degrees}: {}", found[0].to_degrees());
        }
    }

    #[test]
    fn a_saddle_has_several_and_nothing_has_none() {
        assert_eq!(found(|u, v| 1e-3 * (u * u - v * v)).len(), 4);
        assert_eq!(found(|_, _| 0.4), vec![0.0]);
    }
}
