//! The picture of a place: the frames of a burst averaged along its motion, for matching to a fraction of its scale.
//!
//! A chip has samples `STEP` σ apart, `REACH` of them to each side, in the image's own orientation. Each is a mean with
//! Gaussian weights of `BLUR` σ, so that the lattice resolves all detail. Large chips come from reduced frames.

use crate::detector::params::{Interpolation, Slope};
use crate::detector::stack::{FrameTimes, frame_offsets, interpolation_blur};
use crate::kernel::patch::{Patch, PatchScratch, stack_patch};
use crate::plane::Plane;
use rayon::prelude::*;
use std::{borrow::Cow, ops::Range};

/// Samples from the middle of a chip to each side: 15.75 σ.
pub(super) const REACH: usize = 21;
/// Samples on a side.
pub const SIDE: usize = 2 * REACH + 1;
/// Distance of samples, σ.
pub(super) const STEP: f32 = 0.75;
/// Standard deviation of the Gaussian that weights the pixels of a sample, σ.
const BLUR: f64 = 0.55;
/// Reach of the Gaussian window, standard deviations.
const CUT: f64 = 3.0;
/// Least variance of that Gaussian, squared pixels of the frames that are read: less would skip pixels.
const LEAST_VARIANCE: f64 = 0.15;

/// Picture of a place at mid-burst, averaged along its motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Chip {
    /// Column of its middle, input pixels; the centre of the first pixel is 0.
    pub u: f32,
    /// Row of its middle, input pixels.
    pub v: f32,
    /// Scale σ of its place, input pixels; greater than 0.
    pub sigma: f32,
    /// Value of level 0, fraction of full scale.
    lowest: f32,
    /// Difference of two levels.
    unit: f32,
    /// Columns and rows of samples that lie in the image.
    seen: [Range<u8>; 2],
    levels: Vec<u16>,
}

impl Chip {
    /// Chip with the values `sample(i, j)`, which exist in the columns `seen[0]` and rows `seen[1]`.
    fn new(place: (f32, f32), sigma: f32, seen: [Range<u8>; 2], sample: impl Fn(usize, usize) -> f32) -> Self {
        let indices = |range: &Range<u8>| usize::from(range.start)..usize::from(range.end);
        let places = || indices(&seen[1]).flat_map(|j| indices(&seen[0]).map(move |i| (i, j)));
        let values = || places().map(|(i, j)| sample(i, j)).filter(|x| x.is_finite());
        // Levels of 16 bits over the chip's own range take half the memory of floats.
        let lowest = values().reduce(f32::min).unwrap_or(0.0);
        let highest = values().reduce(f32::max).unwrap_or(0.0);
        let unit = (highest - lowest) / f32::from(u16::MAX);
        let mut levels = vec![0; SIDE * SIDE];
        for (i, j) in places() {
            // The cast of what is not finite is a level too.
            levels[j * SIDE + i] = if unit > 0.0 { ((sample(i, j) - lowest) / unit).round() as u16 } else { 0 };
        }
        Self { u: place.0, v: place.1, sigma, lowest, unit, seen, levels }
    }

    /// Columns and rows of samples that lie in the image, of 0 … [`SIDE`].
    pub(super) fn seen(&self) -> [Range<usize>; 2] {
        self.seen.clone().map(|range| usize::from(range.start)..usize::from(range.end))
    }

    /// Level of the sample in column `i` and row `j`, which lies in the image.
    pub(super) fn level(&self, i: usize, j: usize) -> f32 {
        f32::from(self.levels[j * SIDE + i])
    }

    /// Value of the sample in column `i` and row `j`, fraction of full scale; `None` beyond the image.
    pub fn sample(&self, i: usize, j: usize) -> Option<f32> {
        let [columns, rows] = self.seen();
        let inside = columns.contains(&i) && rows.contains(&j);
        inside.then(|| self.lowest + self.unit * self.level(i, j))
    }
}

/// Frames of a burst from which chips are made.
#[derive(Debug)]
pub struct ChipSource<'a> {
    /// Frames that take part, at the resolution of the input and of each octave above.
    octaves: Vec<Vec<Cow<'a, Plane>>>,
    times: FrameTimes,
}

impl<'a> ChipSource<'a> {
    /// Source of chips of scales up to `largest_sigma`, input pixels, from `frames` of one size taken at `times`.
    pub fn new(frames: &[&'a Plane], times: &FrameTimes, largest_sigma: f32) -> Self {
        let mut octaves: Vec<Vec<Cow<'a, Plane>>> = vec![frames.iter().map(|frame| Cow::Borrowed(*frame)).collect()];
        let halvable = |plane: &Plane| plane.width().min(plane.height()) >= 4;
        for octave in 1..=octave_of(largest_sigma) {
            if !octaves[octave - 1].iter().all(|frame| halvable(frame)) {
                break;
            }
            octaves.push(octaves[octave - 1].par_iter().map(|frame| Cow::Owned(frame.halved())).collect());
        }
        Self { octaves, times: times.clone() }
    }

    /// Chip of the place (`u`, `v`) at mid-burst, of scale `sigma` (both input pixels), that moves by `slope`, pixels
    /// per frame. `None` for a place outside the image, for what is not finite, and for frames without a pixel.
    pub fn chip(&self, (u, v): (f32, f32), sigma: f32, slope: Slope) -> Option<Chip> {
        let (width, height) = self.octaves.first()?.first()?.size();
        let inside = |x: f32, size: usize| x >= -0.5 && x <= size as f32 - 0.5;
        let known = sigma > 0.0 && [sigma, slope.u, slope.v].iter().all(|x| x.is_finite());
        if !known || !inside(u, width) || !inside(v, height) {
            return None;
        }
        // At reduced resolution a large chip costs as much as a small one.
        let octave = octave_of(sigma).min(self.octaves.len() - 1);
        let pixel = f64::from(1u32 << octave);
        let frames: Vec<&Plane> = self.octaves[octave].iter().map(AsRef::as_ref).collect();
        let in_octave = Slope::new(slope.u / pixel as f32, slope.v / pixel as f32);
        let offsets = self.times.of(frame_offsets(&self.times.positions, in_octave, Interpolation::Linear));
        // Linear reading blurs between pixels; the samples' own Gaussian is made narrower by as much.
        let (read_u, read_v) = interpolation_blur(&offsets);
        let axis = |place: f32, size: usize, reduced: usize, read: f64| {
            Axis::new(f64::from(place), f64::from(sigma), pixel, (size, reduced), read)
        };
        let reduced = frames[0].size();
        let (across, down) = (axis(u, width, reduced.0, read_u), axis(v, height, reduced.1, read_v));
        let (mut patch, mut scratch) = (Patch::default(), PatchScratch::default());
        patch.reset(across.pixels(), down.pixels());
        stack_patch(&frames, &offsets, &mut patch, &mut scratch.sums);
        let samples = samples(&patch, &across, &down);
        Some(Chip::new((u, v), sigma, [across.seen(), down.seen()], |i, j| samples[j * SIDE + i]))
    }
}

/// Octave from whose frames a chip of scale `sigma` is made: its pixels are smaller than the blur.
fn octave_of(sigma: f32) -> usize {
    (BLUR * f64::from(sigma)).log2().floor().clamp(0.0, 16.0) as usize
}

struct Axis {
    /// First pixel of each sample, and the weights from there on; none beyond the image.
    taps: Vec<(usize, Vec<f32>)>,
}

impl Axis {
    /// Axis through `place` for the scale `sigma`, both input pixels, on an octave with pixels `pixel` of these wide,
    /// of an image of `size` of either; `read` is the variance of reading between the octave's pixels.
    fn new(place: f64, sigma: f64, pixel: f64, (size, reduced): (usize, usize), read: f64) -> Self {
        // The mean over a pixel of the octave is a blur as well.
        let average = (1.0 - 1.0 / (pixel * pixel)) / 12.0;
        let variance = ((BLUR * sigma / pixel).powi(2) - average - read).max(LEAST_VARIANCE);
        let reach = CUT * variance.sqrt();
        let of_sample = |index: usize| {
            let at = place + (index as f64 - REACH as f64) * f64::from(STEP) * sigma;
            if at < -0.5 || at > size as f64 - 0.5 {
                return (0, Vec::new());
            }
            let centre = ((at + 0.5) / pixel - 0.5).clamp(0.0, reduced as f64 - 1.0);
            let first = (centre - reach).ceil().max(0.0) as usize;
            let last = ((centre + reach) as usize).min(reduced - 1);
            let weight = |k: usize| (-0.5 * (k as f64 - centre).powi(2) / variance).exp();
            let sum: f64 = (first..=last).map(weight).sum();
            (first, (first..=last).map(|k| (weight(k) / sum) as f32).collect())
        };
        Self { taps: (0..SIDE).map(of_sample).collect() }
    }

    fn seen(&self) -> Range<u8> {
        let inside = |(_, weights): &(usize, Vec<f32>)| !weights.is_empty();
        let start = self.taps.iter().position(inside).unwrap_or(0);
        let end = self.taps.iter().rposition(inside).map_or(start, |last| last + 1);
        start as u8..end as u8
    }

    fn pixels(&self) -> Range<i64> {
        let used = || self.taps.iter().filter(|(_, weights)| !weights.is_empty());
        let first = used().map(|(first, _)| *first).min().unwrap_or(0);
        let end = used().map(|(first, weights)| first + weights.len()).max().unwrap_or(first);
        first as i64..end as i64
    }
}

/// All samples of a stacked `patch`, row by row; 0 beyond the image.
fn samples(patch: &Patch, across: &Axis, down: &Axis) -> Vec<f32> {
    let columns = patch.columns();
    let mut line = vec![0.0f32; columns.clone().count()];
    let mut samples = vec![0.0; SIDE * SIDE];
    // Separable: rows are summed once for all samples across.
    for ((top, down), out) in down.taps.iter().zip(samples.chunks_exact_mut(SIDE)) {
        if down.is_empty() {
            continue;
        }
        line.fill(0.0);
        for (weight, v) in down.iter().zip(*top as i64..) {
            line.iter_mut().zip(patch.row(v)).for_each(|(sum, x)| *sum += weight * x);
        }
        for ((left, across), out) in across.taps.iter().zip(out) {
            let from = if across.is_empty() { 0 } else { left - columns.start as usize };
            *out = across.iter().zip(&line[from..]).map(|(weight, x)| weight * x).sum();
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames with a Gaussian blob of standard deviation `blob` px that moves by `slope`, at (90.3, 70.6) at mid-burst.
    fn moving(slope: Slope, blob: f32) -> Vec<Plane> {
        let value = |dt: f32, u: usize, v: usize| {
            let (du, dv) = (u as f32 - 90.3 - dt * slope.u, v as f32 - 70.6 - dt * slope.v);
            (-(du * du + dv * dv) / (2.0 * blob * blob)).exp()
        };
        (0..5).map(|t| Plane::from_fn(181, 139, |u, v| value(t as f32 - 2.0, u, v))).collect()
    }

    fn chip(frames: &[Plane], at: (f32, f32), sigma: f32, slope: Slope) -> Chip {
        let planes: Vec<&Plane> = frames.iter().collect();
        ChipSource::new(&planes, &FrameTimes::all(crate::burst::Positions::even(frames.len())), 20.0)
            .chip(at, sigma, slope)
            .expect("inside")
    }

    #[test]
    fn samples_are_the_moving_thing_blurred_at_every_scale() {
        let slope = Slope::new(1.37, -0.61);
        for (sigma, blob) in [(1.7f32, 2.5f32), (3.0, 4.0), (5.0, 5.0), (12.0, 14.0)] {
            let chip = chip(&moving(slope, blob), (88.0, 72.5), sigma, slope);
            let variance = blob * blob + (BLUR as f32 * sigma).powi(2);
            let peak = blob * blob / variance;
            for (i, j) in (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j))) {
                let at = |k: usize, middle: f32| middle + (k as f32 - REACH as f32) * STEP * sigma;
                let (u, v) = (at(i, 88.0), at(j, 72.5));
                let inside = (-0.5..=180.5).contains(&u) && (-0.5..=138.5).contains(&v);
                assert_eq!(chip.sample(i, j).is_some(), inside, "σ {sigma} ({u}, {v})");
                // Nearer to the border the blur ends there.
                let reach = 3.0 * sigma;
                if let Some(value) = chip.sample(i, j).filter(|_| u > reach && v > reach && u < 180.0 - reach) {
                    let squared = (u - 90.3).powi(2) + (v - 70.6).powi(2);
                    let truth = peak * (-squared / (2.0 * variance)).exp();
                    assert!((value - truth).abs() < 0.02, "σ {sigma} ({u}, {v}): {value} {truth}");
                }
            }
        }
    }
}
