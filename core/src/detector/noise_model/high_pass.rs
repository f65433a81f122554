//! High-pass filter of frames at places spread over the image: its output is mostly noise.
//!
//! Frames are halved, since files and demosaicing change the finest frequencies most, and filtered by the second
//! difference in u and in v (mask `[1 −2 1]ᵀ[1 −2 1]`), in squares of 16×16 image pixels, the same in every frame: a
//! combination of frames is filtered as the same combination of filtered frames.

use super::contrast::{Contrast, shifts};
use crate::burst::Offset;
use crate::detector::params::Slope;
use crate::plane::{Plane, statistics::upper_median, tile::Region};
use multiversion::multiversion;
use rayon::prelude::*;

/// Side of a square, halved pixels.
const SIDE: usize = 8;
const AREA: usize = SIDE * SIDE;
pub const SQUARE_PIXELS: usize = 4 * AREA;
/// Enough for an accuracy of one percent overall.
const MAX_SQUARES: usize = 512;
/// Maximum number of squares of a lattice, about: those of a million pixels.
const MAX_DENSE: usize = 4096;
/// Variance of the filtered values of white noise of variance 1: the mask's squares sum to 36, over four pixels.
const GAIN: f32 = 9.0;
/// Effective number of independent values of a square: Σρ² of the filter's values over it is 3.31.
pub const FREE_VALUES: f32 = AREA as f32 / 3.31;

#[derive(Debug, Clone)]
pub struct HighPass {
    /// Centre of each square, image pixels.
    pub places: Vec<(f32, f32)>,
    /// First column and row of each square in the image, with the border that the filter needs.
    corners: Vec<(usize, usize)>,
    values: Vec<Vec<f32>>,
    /// Mean of each square by frame, fraction of full scale.
    pub brightness: Vec<Vec<f32>>,
    /// Whether quiet squares are no evidence of low noise, because a codec flattened them.
    pub are_flattened: bool,
    /// Square of the smallest step of the files: less variance in a flattened file is no scene.
    pub least_scene: f32,
    /// Whether each pixel is 0 or one value: squares in the dark hold few photons, and quiet ones none.
    pub are_bits: bool,
}

impl HighPass {
    /// Filters the squares of frames of one size that no mask hides; none where a side is under 20 pixels.
    pub fn new(frames: &[&Plane]) -> Self {
        let mut corners = frames.first().map_or_else(Vec::new, |frame| corners(frame.size()));
        corners.retain(|&corner| !frames.iter().any(|frame| frame.hides(&around_square(corner))));
        Self::at(frames, corners)
    }

    pub fn on_lattice(frames: &[&Plane], lattice: Lattice) -> Self {
        let Lattice { columns, rows, pitch } = lattice;
        Self::at(frames, (0..columns * rows).map(|i| (i % columns * pitch, i / columns * pitch)).collect())
    }

    fn at(frames: &[&Plane], corners: Vec<(usize, usize)>) -> Self {
        let of_frame = |frame: &&Plane| {
            let (mut values, mut brightness) = (vec![0.0; corners.len() * AREA], vec![0.0; corners.len()]);
            filter_squares(frame, &corners, values.as_chunks_mut().0, &mut brightness);
            (values, brightness)
        };
        let (values, brightness) = frames.par_iter().map(of_frame).unzip();
        let middle = |at: usize| at as f32 + PATCH as f32 - 0.5;
        let places = corners.iter().map(|&(u, v)| (middle(u), middle(v))).collect();
        Self { places, values, brightness, corners, are_flattened: false, least_scene: 0.0, are_bits: false }
    }

    pub fn only(&self, frames: &[usize]) -> Self {
        let (places, corners) = (self.places.clone(), self.corners.clone());
        let values = frames.iter().map(|&t| self.values[t].clone()).collect();
        let brightness = frames.iter().map(|&t| self.brightness[t].clone()).collect();
        Self { places, corners, values, brightness, ..*self }
    }

    /// Variance of the noise from the quiet squares, or from all where a codec or bits make quiet squares mean nothing.
    pub fn noise_in(&self, variances: Vec<f32>) -> f32 {
        if self.are_flattened || self.are_bits {
            variances.iter().sum::<f32>() / variances.len().max(1) as f32
        } else {
            quiet_variance(variances, FREE_VALUES)
        }
    }

    pub fn frames(&self) -> usize {
        self.values.len()
    }

    /// Variance of white noise in one frame that would explain each square of the combination Σ `weights`·frame.
    pub fn variances(&self, weights: &[(usize, f32)]) -> Vec<f32> {
        let scale = 1.0 / (GAIN * AREA as f32 * weights.iter().map(|(_, w)| w * w).sum::<f32>());
        (0..self.places.len()).map(|square| self.power(weights, square) * scale).collect()
    }

    /// Variance in each square, the mean over `contrasts`, with the frames compared at the same pixels.
    pub fn mean_variances(&self, contrasts: &[Contrast]) -> Vec<f32> {
        let scale = 1.0 / (contrasts.len() as f32 * GAIN * AREA as f32);
        let of_square = |square| contrasts.iter().map(|contrast| self.power(contrast, square)).sum::<f32>() * scale;
        (0..self.places.len()).map(of_square).collect()
    }

    /// Variance of one frame's noise in each square: the mean over `contrasts` of `frames`, read where the scene has
    /// moved unless a mask hides it there. NaN in hidden squares.
    pub fn still_variances(
        &self,
        frames: &[&Plane],
        contrasts: &[Contrast],
        offsets: &[Offset<f32>],
        slopes: &[Slope],
    ) -> Vec<f32> {
        let of_square = |square: usize| {
            let (u, v) = self.corners[square];
            let of_contrast = |contrast: &Contrast| {
                let read = (&(u..u + 2 * PATCH), &(v..v + 2 * PATCH));
                let shifts = shifts(contrast, offsets, slopes[square], read, frames[0].size());
                let moved = |u: usize, by: i64| u.saturating_add_signed(by as isize);
                let places = || shifts.iter().map(|&(du, dv)| (moved(u, du), moved(v, dv)));
                let hides = |(t, at): (usize, (usize, usize))| frames[t].hides(&around_square(at));
                if contrast.iter().any(|&(t, _)| hides((t, (u, v)))) {
                    return f32::NAN;
                }
                // In place, the filtered values are known already.
                if shifts.iter().all(|&by| by == (0, 0))
                    || contrast.iter().zip(places()).any(|(&(t, _), at)| hides((t, at)))
                {
                    return self.power(contrast, square);
                }
                // Elsewhere the patches are combined before the filter, which is linear: once instead of three times.
                let places: Vec<(usize, usize)> = places().collect();
                power_of(frames, contrast, &places)
            };
            contrasts.iter().map(of_contrast).sum::<f32>() / (contrasts.len() as f32 * GAIN * AREA as f32)
        };
        (0..self.places.len()).into_par_iter().map(of_square).collect()
    }

    fn power(&self, weights: &[(usize, f32)], square: usize) -> f32 {
        let range = square * AREA..(square + 1) * AREA;
        let mut sums = [0.0f32; AREA];
        for &(frame, weight) in weights {
            sums.iter_mut().zip(&self.values[frame][range.clone()]).for_each(|(sum, x)| *sum += weight * x);
        }
        sums.iter().map(|x| x * x).sum::<f32>()
    }

    pub fn same(&self, a: usize, b: usize) -> bool {
        self.values[a] == self.values[b] && self.brightness[a] == self.brightness[b]
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lattice {
    pub columns: usize,
    pub rows: usize,
    /// Distance of neighbours, image pixels.
    pub pitch: usize,
}

impl Lattice {
    /// As many squares as an image of `size` holds side by side, or `MAX_DENSE`, about.
    pub fn dense((width, height): (usize, usize)) -> Self {
        let count = |n: usize, pitch: usize| if n < 2 * PATCH { 0 } else { (n - 2 * PATCH) / pitch + 1 };
        let even = ((width * height) as f32 / MAX_DENSE as f32).sqrt().ceil() as usize;
        let pitch = even.max(2 * SIDE).next_multiple_of(2);
        Self { columns: count(width, pitch), rows: count(height, pitch), pitch }
    }

    /// First pixel, along both axes, of cells as wide as the pitch that have the squares in their middle.
    pub fn first_px(&self) -> f32 {
        PATCH as f32 - 0.5 * self.pitch as f32
    }
}

/// First columns and rows of the squares of an image of `size`, with two pixels more on each side; spread evenly.
fn corners((width, height): (usize, usize)) -> Vec<(usize, usize)> {
    let inner = |n: usize| (n / 2).saturating_sub(2) / SIDE;
    let (columns, rows) = (inner(width), inner(height));
    let total = columns * rows;
    let count = total.min(MAX_SQUARES);
    // Evenly spaced among all squares; columns are shifted from row to row, so that no column is preferred.
    (0..count)
        .map(|i| {
            let index = (i as u64 * total as u64 / count as u64) as usize;
            let (column, row) = (index % columns, index / columns);
            let shifted = if count < total { (column + row * 7) % columns } else { column };
            (2 * shifted * SIDE, 2 * row * SIDE)
        })
        .collect()
}

/// Side of a square with the border that its filter needs, halved pixels.
const PATCH: usize = SIDE + 2;
type Patch = [[f32; PATCH]; PATCH];

fn around_square((u, v): (usize, usize)) -> Region {
    Region { columns: u..u + 2 * PATCH, rows: v..v + 2 * PATCH }
}

#[inline(always)]
fn halved_patch(frame: &Plane, (u, v): (usize, usize)) -> Patch {
    let mut patch = Patch::default();
    for (y, out) in patch.iter_mut().enumerate() {
        let row = |v: usize| frame.row(v)[u..u + 2 * PATCH].as_chunks::<2>().0;
        let pairs = row(v + 2 * y).iter().zip(row(v + 2 * y + 1));
        // As in `halve_pair`, which is too much for so few pixels.
        out.iter_mut().zip(pairs).for_each(|(out, (a, b))| *out = 0.25 * ((a[0] + a[1]) + (b[0] + b[1])));
    }
    patch
}

#[inline(always)]
fn filter(patch: &Patch) -> [f32; AREA] {
    let mut values = [0.0; AREA];
    for (rows, out) in patch.windows(3).zip(values.as_chunks_mut::<SIDE>().0) {
        let second: [f32; PATCH] = std::array::from_fn(|i| rows[0][i] - 2.0 * rows[1][i] + rows[2][i]);
        *out = std::array::from_fn(|i| second[i] - 2.0 * second[i + 1] + second[i + 2]);
    }
    values
}

/// Writes the filtered values and the mean of each square of `frame`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn filter_squares(frame: &Plane, corners: &[(usize, usize)], values: &mut [[f32; AREA]], brightness: &mut [f32]) {
    for ((&corner, values), brightness) in corners.iter().zip(values).zip(brightness) {
        let patch = halved_patch(frame, corner);
        let sum: f32 = patch[1..=SIDE].iter().map(|row| row[1..=SIDE].iter().sum::<f32>()).sum();
        *brightness = sum / AREA as f32;
        *values = filter(&patch);
    }
}

/// Power of the filtered contrast of `frames`, each read at its own of `places`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn power_of(frames: &[&Plane], contrast: &Contrast, places: &[(usize, usize)]) -> f32 {
    let mut patch = Patch::default();
    for (&(t, weight), &at) in contrast.iter().zip(places) {
        let of_frame = halved_patch(frames[t], at);
        patch.as_flattened_mut().iter_mut().zip(of_frame.as_flattened()).for_each(|(sum, x)| *sum += weight * x);
    }
    filter(&patch).iter().map(|value| value * value).sum()
}

/// Noise variance from the quieter part of squares' variances, since texture adds to the others: the mean of the lowest
/// seven tenths over its value expected of noise alone. Variances of `free` independent values spread by √(2/`free`),
/// and the mean of the lowest seven tenths of that χ² lies 0.51 of the spread below the mean.
pub fn quiet_variance(mut variances: Vec<f32>, free: f32) -> f32 {
    let count = (variances.len() * 7).div_ceil(10);
    if count == 0 {
        return 0.0;
    }
    if count < variances.len() {
        variances.select_nth_unstable_by(count, f32::total_cmp);
    }
    let lowest = &variances[..count];
    let expected = if count < variances.len() { 1.0 - 0.513 * (2.0 / free).sqrt() } else { 1.0 };
    lowest.iter().sum::<f32>() / (count as f32 * expected)
}

pub fn sorted(mut values: Vec<f32>) -> Vec<f32> {
    values.sort_by(f32::total_cmp);
    values
}

/// Value below which `part` (0 … 1) of the sorted values lie.
pub fn quantile(sorted: &[f32], part: f32) -> f32 {
    sorted[((sorted.len() - 1) as f32 * part).round() as usize]
}

/// Relative standard deviation of sorted values, from their quartiles: those of a normal distribution lie 1.35σ apart.
pub fn spread(sorted: &[f32]) -> f32 {
    let part = |part| quantile(sorted, part);
    (part(0.75) - part(0.25)) / (1.35 * part(0.5).max(f32::MIN_POSITIVE))
}

/// Median of `values` (the upper one of two); 0 where there are none.
pub fn median(values: Vec<f32>) -> f32 {
    upper_median(values).unwrap_or(0.0)
}

/// The places of a lattice around (x, y), and itself.
pub fn around((x, y): (usize, usize), (columns, rows): (usize, usize)) -> impl Iterator<Item = (usize, usize)> {
    (y.saturating_sub(1)..(y + 2).min(rows))
        .flat_map(move |y| (x.saturating_sub(1)..(x + 2).min(columns)).map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::random::Stream;

    fn noise(size: (usize, usize), sigma: f64, seed: u64) -> Plane {
        let mut stream = Stream::new(seed, 0);
        Plane::from_fn(size.0, size.1, |u, _| 1e-3 * u as f32 + (sigma * stream.normal()) as f32)
    }

    #[test]
    fn white_noise_on_a_ramp_has_its_variance_in_every_combination() {
        let frames = [1, 2, 3].map(|seed| noise((400, 300), 0.02, seed));
        let squares = HighPass::new(&frames.iter().collect::<Vec<_>>());
        for weights in [&[(0, 1.0)][..], &[(0, 1.0), (1, -1.0)], &[(0, 1.0), (1, -2.0), (2, 1.0)]] {
            let variances = squares.variances(weights);
            let mean = variances.iter().sum::<f32>() / variances.len() as f32;
            assert!((mean / 4e-4 - 1.0).abs() < 0.03, "{mean}");
            let spread = variances.iter().map(|v| (v / mean - 1.0).powi(2)).sum::<f32>() / variances.len() as f32;
            assert!((spread * FREE_VALUES / 2.0 - 1.0).abs() < 0.2, "{spread}");
            let quiet = quiet_variance(variances, FREE_VALUES);
            assert!((quiet / 4e-4 - 1.0).abs() < 0.04, "{quiet}");
        }
        assert!(squares.same(1, 1) && !squares.same(1, 2));
        assert!(HighPass::new(&[&noise((18, 300), 0.1, 1)]).places.is_empty() && HighPass::new(&[]).places.is_empty());
    }
}
