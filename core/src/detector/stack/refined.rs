//! Stacks at a feature's own slope, between those of the grid, in any octave.
//!
//! Neighbouring slopes of a grid misalign the outermost frames by their step times (N − 1)/2 pixels, so a feature
//! half-way between two of them is smeared in both, and a descriptor computed there matches less. The grid's stacks are
//! no help: the frames have to be shifted again. For octaves above 0 that is done on frames of that octave's
//! resolution: each pixel the mean of 2^o × 2^o of a frame's. Averaging before shifting equals averaging after it,
//! except for detail finer than the averages, which no level of that octave shows.

use crate::detector::params::Interpolation;
use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::levels::{SIGMA_INPUT, octave_size};
use crate::detector::scale_space::octave::Base;
use crate::detector::stack::offsets::{FrameTimes, interpolation_blur, shifted_offsets};
use crate::kernel::stack::FrameOffset;
use crate::plane::Plane;
use rayon::prelude::*;
use std::borrow::Cow;

/// Frames at the resolution of one octave.
pub(in crate::detector) struct OctaveFrames<'a> {
    octave: i32,
    /// Means of 2^octave × 2^octave pixels of each frame; empty where the frames are used unchanged.
    means: Cow<'a, [Plane]>,
    frames: &'a [&'a Plane],
    times: &'a FrameTimes,
}

impl<'a> OctaveFrames<'a> {
    /// Makes the frames for `octave`, −1 or more, from `frames` of one size, taken at `times`. Octaves 0 and −1 use the
    /// frames unchanged.
    pub(in crate::detector) fn new(
        frames: &'a [&'a Plane],
        times: &'a FrameTimes,
        octave: i32,
        in_parallel: bool,
    ) -> Self {
        let finest = Self { octave: octave.min(0), means: Cow::Borrowed(&[]), frames, times };
        (0..octave).fold(finest, |finer, _| finer.coarser(in_parallel))
    }

    /// Makes the frames for the next octave from these: on all threads, or on the calling one.
    pub(in crate::detector) fn coarser(&self, in_parallel: bool) -> Self {
        let octave = self.octave + 1;
        let means = match octave > 0 {
            true if in_parallel => self.planes().into_par_iter().map(halved).collect(),
            true => self.planes().into_iter().map(halved).collect(),
            false => Vec::new(),
        };
        Self { octave, means: Cow::Owned(means), frames: self.frames, times: self.times }
    }

    /// Frames for `octave` whose means were computed before: see [`Self::into_means`].
    pub(in crate::detector) fn with_means(
        frames: &'a [&'a Plane],
        times: &'a FrameTimes,
        octave: i32,
        means: &'a [Plane],
    ) -> Self {
        Self { octave, means: Cow::Borrowed(means), frames, times }
    }

    /// Means of 2^octave × 2^octave pixels of each frame; empty where the frames are used unchanged.
    pub(in crate::detector) fn into_means(self) -> Vec<Plane> {
        self.means.into_owned()
    }

    /// The frames by reference, as [`Self::base`] borrows them.
    pub(in crate::detector) fn planes(&self) -> Vec<&Plane> {
        if self.means.is_empty() { self.frames.to_vec() } else { self.means.iter().collect() }
    }

    /// Offsets at which [`Self::planes`] are read at `slope` (input px per frame).
    pub(in crate::detector) fn offsets(&self, slope: Slope, interpolation: Interpolation) -> Vec<FrameOffset> {
        let pixel = 2f64.powi(self.octave.max(0));
        // The mean of 2^o pixels is at their centre, the octave's pixel at the first of them.
        let shift_px = -0.5 * (1.0 - 1.0 / pixel);
        let in_octave = (f64::from(slope.u) / pixel, f64::from(slope.v) / pixel);
        self.times.of(shifted_offsets(self.times.frame_count, in_octave, shift_px, interpolation))
    }

    /// Source of the octave's pixels: `planes` read at `offsets`.
    pub(in crate::detector) fn base<'b>(&self, planes: &'b [&'b Plane], offsets: &'b [FrameOffset]) -> Base<'b> {
        Base::Frames { frames: planes, offsets, octave: self.octave.min(0) }
    }

    /// σ of that source, in octave pixels: of the input, the averages, and the reading between pixels.
    pub(in crate::detector) fn sigma_octave(&self, offsets: &[FrameOffset]) -> f64 {
        let pixel = 2f64.powi(self.octave);
        let average = if self.octave > 0 { (1.0 - 1.0 / (pixel * pixel)) / 12.0 } else { 0.0 };
        let (u, v) = interpolation_blur(offsets);
        // A doubled image is read between the frames' pixels, which are two of its own apart.
        let reading = 0.5 * (u + v) * if self.octave < 0 { 4.0 } else { 1.0 };
        ((SIGMA_INPUT / pixel).powi(2) + average + reading).sqrt()
    }
}

/// Means of 2 × 2 pixels; of the size of the next octave.
fn halved(plane: &Plane) -> Plane {
    let (width, height) = octave_size(plane.size(), 1);
    let mut out = Plane::zeros(width, height);
    for v in 0..height {
        let (upper, lower) = (plane.row(2 * v), plane.row(2 * v + 1));
        for ((out, a), b) in out.row_mut(v).iter_mut().zip(upper.chunks_exact(2)).zip(lower.chunks_exact(2)) {
            *out = 0.25 * ((a[0] + a[1]) + (b[0] + b[1]));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::patch::{Patch, PatchScratch};

    /// Frames with a Gaussian blob of σ 6 px that moves by `slope`, at (70, 50) in the middle of the burst.
    fn moving(slope: Slope) -> Vec<Plane> {
        (0..7)
            .map(|t| {
                let dt = t as f32 - 3.0;
                Plane::from_fn(160, 120, |u, v| {
                    let (du, dv) = (u as f32 - 70.0 - dt * slope.u, v as f32 - 50.0 - dt * slope.v);
                    (-(du * du + dv * dv) / 72.0).exp()
                })
            })
            .collect()
    }

    #[test]
    fn every_octave_shows_a_moving_blob_sharp_and_in_its_place() {
        let slope = Slope::new(1.37, -0.61);
        let frames = moving(slope);
        let frames: Vec<&Plane> = frames.iter().collect();
        for octave in [-1, 0, 1, 2] {
            let times = FrameTimes::all(frames.len());
            let of_octave = OctaveFrames::new(&frames, &times, octave, octave % 2 == 0);
            let (planes, offsets) = (of_octave.planes(), of_octave.offsets(slope, Interpolation::Linear));
            let base = of_octave.base(&planes, &offsets);
            let pixel = 2f32.powi(octave);
            let (size, at) = (octave_size((160, 120), octave), |x: f32| (x / pixel) as i64);
            let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
            let (columns, rows) = (at(40.0)..at(100.0), at(20.0)..at(80.0));
            base.patch(size, columns.clone(), rows.clone(), &mut scratch, &mut patch);
            let middle = patch.row((rows.start + rows.end) / 2)[columns.clone().count() / 2];
            for y in rows {
                for (x, value) in columns.clone().zip(patch.row(y)) {
                    let (du, dv) = (x as f32 * pixel - 70.0, y as f32 * pixel - 50.0);
                    // Increase of σ² by averages and interpolation.
                    let added = (of_octave.sigma_octave(&offsets).powi(2) as f32
                        - (SIGMA_INPUT as f32 / pixel).powi(2))
                        * pixel
                        * pixel;
                    let variance = 36.0 + added;
                    let truth = |du: f32, dv: f32| 36.0 / variance * (-(du * du + dv * dv) / (2.0 * variance)).exp();
                    let (cu, cv) = ((columns.start + columns.end) / 2, (at(20.0) + at(80.0)) / 2);
                    let centre = truth(cu as f32 * pixel - 70.0, cv as f32 * pixel - 50.0);
                    let expected = truth(du, dv) - centre + middle;
                    assert!((value - expected).abs() < 8e-3, "octave {octave} ({x}, {y}): {value} {expected}");
                }
            }
        }
    }
}
