//! The response along a motion: D at single places, at any slope, and the pixels around a place from which it follows.
//!
//! A feature lies at a slope of its own, between the grid's slopes, whose stacks smear it. So the frames are shifted
//! again, in octaves above 0 frames of that octave's resolution ([`OctaveFrames`]): means of 2^o × 2^o pixels. D at a
//! place is the mean of the shifted frames in a small patch, weighted by two Gaussians. Stacking and filtering commute,
//! so the values are those of a search at that slope, up to interpolation (and, in coarser octaves, the reduction).

use crate::detector::params::Slope;
use crate::detector::scale_space::{Base, SIGMA_INPUT, Scale, octave_pixel, octave_size};
use crate::detector::search::setup::Inputs;
use crate::detector::stack::{interpolation_blur, shifted_offsets};
use crate::kernel::patch::{Patch, PatchScratch, inside, stack_patch};
use crate::kernel::stack::FrameOffset;
use crate::plane::Plane;
use crate::plane::blur::GaussianKernel;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::OnceLock;

/// Pixels within `radius` of the pixel in which `place` lies.
pub fn around(place: f32, radius: usize) -> Range<i64> {
    let (middle, radius) = ((place + 0.5).floor() as i64, radius as i64);
    middle - radius..middle + radius + 1
}

/// Pixel in whose columns and rows `place` lies, inside an image of `size`.
pub(super) fn floor_pixel(place: (f32, f32), size: (usize, usize)) -> (usize, usize) {
    let pixel = |x: f32, n: usize| (x.max(0.0) as usize).min(n - 1);
    (pixel(place.0, size.0), pixel(place.1, size.1))
}

impl Base<'_> {
    /// Reads columns `columns` and rows `rows` of the octave of `size`, before any blur of this octave and less the
    /// value in the middle, into `patch`. The rectangle must touch the octave.
    pub fn patch(
        &self,
        size: (usize, usize),
        columns: Range<i64>,
        rows: Range<i64>,
        scratch: &mut PatchScratch,
        patch: &mut Patch,
    ) {
        match self {
            Self::Level(level) => {
                patch.reset(columns.clone(), rows.clone());
                let columns = inside(&columns, size.0);
                for v in inside(&rows, size.1) {
                    let from = &level.row(v)[columns.clone()];
                    patch.values_mut(columns.start as i64, v as i64)[..from.len()].copy_from_slice(from);
                }
                patch.repeat_border(size);
            }
            Self::Frames { frames, offsets, octave: 0 } => {
                patch.reset(columns, rows);
                stack_patch(frames, offsets, patch, &mut scratch.sums);
                patch.repeat_border(size);
            }
            Self::Frames { frames, offsets, octave: -1 } => {
                // Pixels between which the doubled ones lie. Repeated border pixels double to repeated ones.
                let narrow = |range: &Range<i64>| range.start.div_euclid(2)..(range.end - 1).div_euclid(2) + 2;
                scratch.narrow.reset(narrow(&columns), narrow(&rows));
                stack_patch(frames, offsets, &mut scratch.narrow, &mut scratch.sums);
                scratch.narrow.repeat_border(frames[0].size());
                patch.reset(columns, rows);
                patch.double(&scratch.narrow, &mut scratch.row);
            }
            Self::Frames { .. } => {
                patch.reset(columns.clone(), rows.clone());
                let columns = inside(&columns, size.0);
                self.raw_rows(inside(&rows, size.1), columns.clone(), &mut scratch.row, |v, row| {
                    patch.values_mut(columns.start as i64, v as i64)[..row.len()].copy_from_slice(row);
                });
                patch.repeat_border(size);
            }
        }
        // Smaller numbers have smaller rounding errors in the sums that follow.
        patch.centre();
    }
}

/// For each octave from 0 on, means of 2^octave × 2^octave pixels of each frame, on first use; octave 0 stays empty.
pub type Means = Vec<OnceLock<Vec<Plane>>>;

pub struct Along<'a> {
    pub inputs: &'a Inputs,
    planes: Vec<&'a Plane>,
    means: Cow<'a, Means>,
}

impl<'a> Along<'a> {
    pub fn new(inputs: &'a Inputs) -> Self {
        Self { inputs, planes: inputs.planes(), means: Cow::Owned(Self::no_means(inputs)) }
    }

    /// Keeps the means in `means`, which others may share: see [`Self::no_means`].
    pub fn with_means(inputs: &'a Inputs, means: &'a Means) -> Self {
        Self { inputs, planes: inputs.planes(), means: Cow::Borrowed(means) }
    }

    pub fn no_means(inputs: &Inputs) -> Means {
        vec![OnceLock::new(); inputs.octaves().end.max(0) as usize]
    }

    /// Computes the frames up to `octave` now, on all threads unless the means are shared.
    pub fn make(&self, octave: i32) {
        self.made(octave, matches!(self.means, Cow::Owned(_)));
    }

    pub fn of(&self, octave: i32) -> OctaveFrames<'_> {
        // Many threads may call this at once. The thread that computes must work alone: waiting for others, it would
        // run jobs that may need the same frames, and so wait for itself.
        OctaveFrames { octave, inputs: self.inputs, planes: self.made(octave, false) }
    }

    fn made(&self, octave: i32, in_parallel: bool) -> Vec<&Plane> {
        if octave <= 0 {
            return self.planes.clone();
        }
        let make = || match self.made(octave - 1, in_parallel) {
            finer if in_parallel => finer.into_par_iter().map(Plane::halved).collect(),
            finer => finer.into_iter().map(Plane::halved).collect(),
        };
        self.means[octave as usize].get_or_init(make).iter().collect()
    }

    /// D of the mean of `some` frames (indices among the kept frames) at each of the DoG `levels` of `octave`, on
    /// the path through `at` (input pixels, at mid-burst) at any `slope`, at the octave's nearest pixel: as the search,
    /// up to interpolation. The octave must be one that was searched.
    pub fn response(&self, octave: i32, levels: Range<i32>, at: (f32, f32), slope: Slope, some: &[usize]) -> Vec<f32> {
        let frames = self.of(octave);
        let (planes, offsets) = frames.chosen(slope, some);
        frames.response(&planes, &offsets, levels, at)
    }

    /// σ of that D at any slope: the noise of the mean over the `chosen` frames that see the place.
    pub fn sigma_d_at(&self, scale: Scale, (place, slope): ((f32, f32), Slope), chosen: &[usize]) -> f32 {
        let Scale { octave, level } = scale;
        let (all, size) = (self.inputs.offsets(slope), self.inputs.size_image);
        let chosen = chosen.iter().map(|&index| (&*self.inputs.frames[index], all[index]));
        let (frames, offsets): (Vec<&Plane>, Vec<_>) = chosen.unzip();
        let at = floor_pixel(place, size);
        let min = self.inputs.sigma_d(octave, level, slope, &offsets);
        // The place factor samples all frames that took part.
        let seeing = self.inputs.seeing(&frames, octave, &offsets, at);
        min * ((offsets.len() as f32 / seeing).sqrt() * self.inputs.noise.place_factor(octave, &all, at, size))
    }
}

pub struct OctaveFrames<'a> {
    octave: i32,
    inputs: &'a Inputs,
    /// Kept frames, in time order.
    pub planes: Vec<&'a Plane>,
}

impl OctaveFrames<'_> {
    /// Offsets at which the frames are read at `slope` (input px per frame).
    pub fn offsets(&self, slope: Slope) -> Vec<FrameOffset> {
        let pixel = 2f64.powi(self.octave.max(0));
        // The mean of 2^o pixels is at their centre, the octave's pixel at the first of them.
        let shift_px = -0.5 * (1.0 - 1.0 / pixel);
        let in_octave = (f64::from(slope.u) / pixel, f64::from(slope.v) / pixel);
        let Inputs { times, params, .. } = self.inputs;
        times.of(shifted_offsets(&times.positions, in_octave, shift_px, params.rules.interpolation))
    }

    pub fn chosen(&self, slope: Slope, chosen: &[usize]) -> (Vec<&Plane>, Vec<FrameOffset>) {
        let offsets = self.offsets(slope);
        chosen.iter().map(|&index| (self.planes[index], offsets[index])).unzip()
    }

    /// Source of the octave's pixels: `planes` read at `offsets`.
    pub fn base<'b>(&self, planes: &'b [&'b Plane], offsets: &'b [FrameOffset]) -> Base<'b> {
        Base::Frames { frames: planes, offsets, octave: self.octave.min(0) }
    }

    /// σ of that source, in octave pixels: of the input, the averages, and the reading between pixels.
    pub fn sigma_octave(&self, offsets: &[FrameOffset]) -> f64 {
        let pixel = 2f64.powi(self.octave);
        let average = if self.octave > 0 { (1.0 - 1.0 / (pixel * pixel)) / 12.0 } else { 0.0 };
        let (u, v) = interpolation_blur(offsets);
        // A doubled image is read between the frames' pixels, two of its own apart.
        let reading = 0.5 * (u + v) * if self.octave < 0 { 4.0 } else { 1.0 };
        ((SIGMA_INPUT / pixel).powi(2) + average + reading).sqrt()
    }

    /// As [`Along::response`], for the mean of `planes`, which are some of these frames, read at `offsets`.
    pub fn response(&self, planes: &[&Plane], offsets: &[FrameOffset], levels: Range<i32>, at: (f32, f32)) -> Vec<f32> {
        self.responses(planes, offsets, levels, at, (0, 0)).into_iter().flatten().collect()
    }

    /// As [`Self::response`], for each level at all places of a lattice around `at`, row by row: so many to each side
    /// along both axes, and so many octave pixels apart.
    pub fn responses(
        &self,
        planes: &[&Plane],
        offsets: &[FrameOffset],
        levels: Range<i32>,
        at: (f32, f32),
        lattice: (usize, usize),
    ) -> Vec<Vec<f32>> {
        let from = self.sigma_octave(offsets);
        // The frames are blurred already: each kernel adds what its level lacks.
        let kernel = |s: i32| {
            let sigma = self.inputs.space.sigma_octave(f64::from(s));
            GaussianKernel::new((sigma * sigma - from * from).max(0.0).sqrt())
        };
        let kernels: Vec<GaussianKernel> = (levels.start..levels.end + 1).map(kernel).collect();
        let size = octave_size(self.inputs.size_image, self.octave);
        let pixel = octave_pixel(self.octave);
        let inside = |x: f32, n: usize| (x / pixel).clamp(0.0, n as f32 - 1.0);
        let (x, y) = (inside(at.0, size.0), inside(at.1, size.1));
        let reach = kernels.last().map_or(0, GaussianKernel::radius) + lattice.0 * lattice.1;
        let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
        self.base(planes, offsets).patch(size, around(x, reach), around(y, reach), &mut scratch, &mut patch);
        let weighted: Vec<Vec<f32>> = kernels.iter().map(|kernel| weighted(&patch, kernel, reach, lattice)).collect();
        weighted
            .windows(2)
            .map(|two| two[1].iter().zip(&two[0]).map(|(large, small)| large - small).collect())
            .collect()
    }
}

/// Values of `kernel` applied on a lattice around the middle of `patch`, which reaches `reach` pixels from it.
fn weighted(patch: &Patch, kernel: &GaussianKernel, reach: usize, (half, step): (usize, usize)) -> Vec<f32> {
    let taps: Vec<f32> = kernel.half()[1..].iter().rev().chain(kernel.half()).copied().collect();
    let first = |i: usize| reach + i * step - half * step - kernel.radius();
    let sum = |values: &[f32]| -> f32 { values.iter().zip(&taps).map(|(x, w)| x * w).sum() };
    let along_rows = |i: usize| patch.rows().map(|v| sum(&patch.row(v)[first(i)..first(i) + taps.len()])).collect();
    let columns: Vec<Vec<f32>> = (0..=2 * half).map(along_rows).collect();
    let at = |j: usize, column: &[f32]| sum(&column[first(j)..first(j) + taps.len()]);
    (0..=2 * half)
        .flat_map(|j| columns.iter().map(move |column| (j, column)))
        .map(|(j, column)| at(j, column))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Burst;
    use crate::detector::{DetectorParams, NoiseModelKind, SlopeGrid};
    use crate::monitor::Monitor;

    fn inputs(frames: Vec<Plane>, first_octave: i32) -> Inputs {
        let (slopes, noise_model) = (SlopeGrid::line(-2.0..=2.0, 3), NoiseModelKind::White);
        let params = DetectorParams { first_octave, slopes, noise_model, ..DetectorParams::default() };
        Inputs::new(&Burst::from_planes("made", frames), &params, &Monitor::default()).expect("valid parameters")
    }

    #[test]
    fn frames_are_the_same_whoever_makes_them() {
        let inputs = inputs((0..9).map(|t| Plane::from_fn(128, 96, |u, v| (u * v + t) as f32)).collect(), 0);
        let alone = Along::new(&inputs);
        let expected = alone.of(2).planes;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().expect("a pool");
        for _ in 0..20 {
            let means = Along::no_means(&inputs);
            let are_those = |_| Along::with_means(&inputs, &means).of(2).planes == expected;
            assert!(pool.install(|| (0..100).into_par_iter().with_max_len(1).all(are_those)));
        }
        let together = Along::new(&inputs);
        pool.install(|| together.make(2));
        assert!(together.of(2).planes == expected);
    }
}
