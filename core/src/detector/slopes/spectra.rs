//! Spectra of small windows of the reduced frames, and the sums of products of pairs of them.
//!
//! Frames are reduced to means over squares: level `l` has pixels of 2^l image pixels. A window of [`SIDE`]² level
//! pixels is cut from every frame at the same place, multiplied by a Hann window, transformed, and band-passed. The
//! product conj(F_s)·F_t is the spectrum of the cross-correlation of frames s and t; products of the same
//! [lag](super::lags) are added up. A frame is never multiplied by itself, so that its noise adds nothing on average.

use super::lags::Lags;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;
use rustfft::num_complex::Complex32;
use rustfft::{Fft, FftPlanner};
use std::ops::Range;
use std::sync::Arc;

/// Number of rows and of columns of a window, level pixels.
pub(super) const SIDE: usize = 32;
const AREA: usize = SIDE * SIDE;
/// Number of values of half a spectrum; the other half follows from it, because the window's values are real.
const HALF: usize = (SIDE / 2 + 1) * SIDE;
/// σ of the band's inner Gaussian, level pixels: with the mean over a pixel 2 to 2.5 image pixels at level 1.
const BAND_SIGMA: f64 = 1.0;
const BAND_RATIO: f64 = 1.6;
/// Largest frequency of a line along itself, cycles a window: the window spreads it over 1, its growth a bit more.
const LINE_FREQUENCIES: usize = 2;
/// Parts of the picture, one after the other along lines, that are compared, and in how many frames at most.
const PARTS: usize = 4;
const FRAMES_COMPARED: usize = 4;
/// Least correlation of the parts: with stripes as strong as the noise 0.65 to 1, in grids of lamps up to 0.54.
const MIN_SHARED: f64 = 0.6;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spectrum {
    pub re: Vec<f32>,
    pub im: Vec<f32>,
}

impl Spectrum {
    fn add_product(&mut self, a: &Self, b: &Self) {
        add_conjugate_products(&a.re, &a.im, &b.re, &b.im, &mut self.re, &mut self.im);
    }

    fn zeros() -> Self {
        Self { re: vec![0.0; HALF], im: vec![0.0; HALF] }
    }

    fn add(&mut self, other: &Self) {
        self.re.iter_mut().zip(&other.re).for_each(|(a, b)| *a += b);
        self.im.iter_mut().zip(&other.im).for_each(|(a, b)| *a += b);
    }
}

/// Adds conj(a)·b to `re` and `im`, at most as many as `a` and `b` have: the innermost loop of the finder.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn add_conjugate_products(a_re: &[f32], a_im: &[f32], b_re: &[f32], b_im: &[f32], re: &mut [f32], im: &mut [f32]) {
    let n = re.len();
    let (a_re, a_im, b_re, b_im, im) = (&a_re[..n], &a_im[..n], &b_re[..n], &b_im[..n], &mut im[..n]);
    for i in 0..n {
        re[i] += a_re[i] * b_re[i] + a_im[i] * b_im[i];
        im[i] += a_re[i] * b_im[i] - a_im[i] * b_re[i];
    }
}

/// Products of pairs of frames over one or many windows: of each pair, or summed over the pairs of a lag.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CrossSpectra {
    pub products: Vec<Spectrum>,
    /// For each product, the variance of a value of the correlation if the frames had nothing in common.
    pub variance: Vec<f64>,
    /// Sum of the squares of the variances of single pairs in single windows.
    squares: f64,
}

impl CrossSpectra {
    pub fn zeros(count: usize) -> Self {
        Self { products: vec![Spectrum::zeros(); count], variance: vec![0.0; count], squares: 0.0 }
    }

    /// Number of pairs of frames in windows that the correlations come from, as if all of these were equally strong.
    pub fn pairs_behind(&self) -> f64 {
        self.variance.iter().sum::<f64>().powi(2) / self.squares.max(f64::MIN_POSITIVE)
    }

    /// Removes the first `count` lags, at which frames share noise; the noise of the others then repeats itself.
    pub fn forget_lags(&mut self, count: usize) {
        self.products.iter_mut().take(count).for_each(|lag| *lag = Spectrum::zeros());
        // Each product of noise then occurs up to (count + 1)² times, once for each pair that shares it.
        let repeated = ((count + 1) * (count + 1)) as f64;
        self.squares *= repeated * repeated;
        for (lag, variance) in self.variance.iter_mut().enumerate() {
            *variance *= if lag < count { 0.0 } else { repeated };
        }
    }

    pub fn add(&mut self, other: &Self) {
        self.products.iter_mut().zip(&other.products).for_each(|(a, b)| a.add(b));
        self.variance.iter_mut().zip(&other.variance).for_each(|(a, b)| *a += b);
        self.squares += other.squares;
    }
}

/// Products of pairs of frames, summed over windows.
pub(super) struct Sum {
    /// Products of each lag.
    pub lags: CrossSpectra,
    /// Products of each pair of [`Lags::near`].
    pub pairs: CrossSpectra,
    pub windows: usize,
    /// Columns and rows that the windows cover, level pixels.
    pub area: [Range<usize>; 2],
}

impl Sum {
    pub fn new(lags: &Lags) -> Self {
        let (lags, pairs) = (CrossSpectra::zeros(lags.by_lag.len()), CrossSpectra::zeros(lags.near.len()));
        Self { lags, pairs, windows: 0, area: [0..0, 0..0] }
    }

    pub fn add(&mut self, other: &Self) {
        self.lags.add(&other.lags);
        self.pairs.add(&other.pairs);
        if other.windows > 0 {
            self.widen(other.area.clone(), other.windows);
        }
    }

    pub fn widen(&mut self, area: [Range<usize>; 2], windows: usize) {
        for (a, b) in self.area.iter_mut().zip(area) {
            *a = if self.windows == 0 { b } else { a.start.min(b.start)..a.end.max(b.end) };
        }
        self.windows += windows;
    }
}

pub(super) struct Fourier {
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
    window: Vec<f32>,
    /// Amplitude of the band-pass, for half a spectrum.
    band: Vec<f32>,
    /// Overlap of the window with itself for a shift (v, u) modulo [`SIDE`]; 1 at shift 0.
    pub overlap: Vec<f32>,
}

pub(super) struct Scratch {
    packed: Vec<Complex32>,
    turned: Vec<Complex32>,
    fft: Vec<Complex32>,
    frames: Vec<Spectrum>,
    energy: Vec<Vec<f32>>,
}

impl Fourier {
    pub fn new() -> Self {
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(SIDE), planner.plan_fft_inverse(SIDE));
        let hann = |i: usize| (std::f64::consts::PI * (i as f64 + 0.5) / SIDE as f64).sin().powi(2);
        let window: Vec<f32> = (0..AREA).map(|i| (hann(i / SIDE) * hann(i % SIDE)) as f32).collect();
        let frequency = |i: usize| {
            let i = if i > SIDE / 2 { i as f64 - SIDE as f64 } else { i as f64 };
            std::f64::consts::TAU * i / SIDE as f64
        };
        // The band is a DoG like those of the search, so that power stands for features.
        let gauss = |w2: f64, sigma: f64| (-0.5 * w2 * sigma * sigma).exp();
        let band = (0..HALF)
            .map(|i| {
                let w2 = frequency(i / SIDE).powi(2) + frequency(i % SIDE).powi(2);
                (gauss(w2, BAND_SIGMA) - gauss(w2, BAND_RATIO * BAND_SIGMA)) as f32
            })
            .collect();
        let along = |shift: usize| -> f64 { (0..SIDE).map(|i| hann(i) * hann((i + shift) % SIDE)).sum() };
        let line: Vec<f64> = (0..SIDE).map(|shift| along(shift) / along(0)).collect();
        let overlap = (0..AREA).map(|i| (line[i / SIDE] * line[i % SIDE]) as f32).collect();
        Self { forward, inverse, window, band, overlap }
    }

    /// The transform for `frames`. Where stripes of a sensor cross the whole picture, spectra lack their frequencies:
    /// they stay as the scene moves, and along them noise alone would choose a motion.
    pub fn of(frames: &[Plane]) -> Self {
        let mut fourier = Self::new();
        for axis in (0..2).filter(|axis| has_lines(frames, *axis)) {
            let along = |i: usize| [i / SIDE, i % SIDE].map(|along| along.min(SIDE - along))[axis];
            let band = fourier.band.iter_mut().enumerate();
            band.filter(|(i, _)| along(*i) <= LINE_FREQUENCIES).for_each(|(_, h)| *h = 0.0);
        }
        fourier
    }

    pub fn scratch(&self, frame_count: usize) -> Scratch {
        let zero = Complex32::default();
        let length = self.forward.get_inplace_scratch_len().max(self.inverse.get_inplace_scratch_len());
        let (frames, energy) = (vec![Spectrum::zeros(); frame_count], vec![vec![0.0; HALF]; frame_count]);
        Scratch { packed: vec![zero; AREA], turned: vec![zero; AREA], fft: vec![zero; length], frames, energy }
    }

    /// Products of each lag for the window of `frames` whose first pixel is (`u`, `v`).
    pub fn products(
        &self,
        frames: &[Plane],
        lags: &Lags,
        (u, v): (usize, usize),
        scratch: &mut Scratch,
    ) -> CrossSpectra {
        // Two frames at a time: one as the real, one as the imaginary part.
        for first in (0..frames.len()).step_by(2) {
            let second = frames.get(first + 1);
            self.pack(&frames[first], second, (u, v), &mut scratch.packed);
            transform(&*self.forward, &mut scratch.packed, &mut scratch.turned, &mut scratch.fft);
            let (a, b) = scratch.frames[first..].split_at_mut(1);
            unpack(&scratch.packed, &self.band, &mut a[0], b.first_mut().filter(|_| second.is_some()));
        }
        // The energies give the variance of each correlation without a model of the noise.
        for (energy, spectrum) in scratch.energy.iter_mut().zip(&scratch.frames) {
            for (e, (re, im)) in energy.iter_mut().zip(spectrum.re.iter().zip(&spectrum.im)) {
                *e = re * re + im * im;
            }
        }
        let mut out = CrossSpectra::zeros(lags.by_lag.len());
        for ((lag, pairs), of_lag) in out.products.iter_mut().zip(&lags.by_lag).zip(&mut out.variance) {
            for &(s, t) in pairs {
                lag.add_product(&scratch.frames[s], &scratch.frames[t]);
                let variance = whole_sum_of_products(&scratch.energy[s], &scratch.energy[t]) / (AREA * AREA) as f64;
                *of_lag += variance;
                out.squares += variance * variance;
            }
        }
        out
    }

    /// Adds the products of [`Lags::near`], pair by pair, for the window of which [`Self::products`] left the spectra.
    pub fn add_pairs(&self, sums: &mut CrossSpectra, lags: &Lags, scratch: &Scratch) {
        let sums = sums.products.iter_mut().zip(&mut sums.variance);
        for ((sum, variance), &(s, t)) in sums.zip(&lags.near) {
            sum.add_product(&scratch.frames[s], &scratch.frames[t]);
            *variance += whole_sum_of_products(&scratch.energy[s], &scratch.energy[t]) / (AREA * AREA) as f64;
        }
    }

    fn pack(&self, a: &Plane, b: Option<&Plane>, (u, v): (usize, usize), packed: &mut [Complex32]) {
        let rows =
            |plane: &Plane| -> f32 { (v..v + SIDE).map(|y| plane.row(y)[u..u + SIDE].iter().sum::<f32>()).sum() };
        // The mean is taken off first, or the Hann window would make a blob of it.
        let mean_a = rows(a) / AREA as f32;
        let mean_b = b.map_or(0.0, rows) / AREA as f32;
        for y in 0..SIDE {
            let row_a = &a.row(v + y)[u..u + SIDE];
            let row_b = b.map(|b| &b.row(v + y)[u..u + SIDE]);
            for x in 0..SIDE {
                let weight = self.window[y * SIDE + x];
                let im = row_b.map_or(0.0, |row| weight * (row[x] - mean_b));
                packed[y * SIDE + x] = Complex32::new(weight * (row_a[x] - mean_a), im);
            }
        }
    }

    /// Correlations (row-major, shift (v, u) modulo [`SIDE`]) whose spectra are `spectra`.
    pub fn correlations(&self, spectra: &[Spectrum], scratch: &mut Scratch) -> Vec<Vec<f32>> {
        let mut out = Vec::with_capacity(spectra.len());
        for two in spectra.chunks(2) {
            merge(&two[0], two.get(1), &mut scratch.packed);
            // `transform` exchanges the axes; applied twice, it restores their order.
            transform(&*self.inverse, &mut scratch.packed, &mut scratch.turned, &mut scratch.fft);
            let scale = 1.0 / AREA as f32;
            out.push(scratch.packed.iter().map(|z| z.re * scale).collect());
            if two.len() == 2 {
                out.push(scratch.packed.iter().map(|z| z.im * scale).collect());
            }
        }
        out
    }
}

/// Transforms along both axes; the result has rows and columns exchanged.
fn transform(fft: &dyn Fft<f32>, data: &mut [Complex32], turned: &mut [Complex32], scratch: &mut [Complex32]) {
    fft.process_with_scratch(data, scratch);
    for y in 0..SIDE {
        for x in 0..SIDE {
            turned[x * SIDE + y] = data[y * SIDE + x];
        }
    }
    fft.process_with_scratch(turned, scratch);
    data.copy_from_slice(turned);
}

fn opposite(i: usize) -> usize {
    (SIDE - i / SIDE) % SIDE * SIDE + (SIDE - i % SIDE) % SIDE
}

/// Extracts the band-passed half spectra of the two real images that were transformed as one complex image.
fn unpack(packed: &[Complex32], band: &[f32], a: &mut Spectrum, mut b: Option<&mut Spectrum>) {
    for (i, h) in band.iter().enumerate() {
        // Spectra of real images are symmetric, so that opposite frequencies part the two.
        let (z, o) = (packed[i], packed[opposite(i)]);
        let h = 0.5 * h;
        (a.re[i], a.im[i]) = (h * (z.re + o.re), h * (z.im - o.im));
        if let Some(b) = &mut b {
            (b.re[i], b.im[i]) = (h * (z.im + o.im), h * (o.re - z.re));
        }
    }
}

/// The whole spectrum whose transform has the first correlation as real and the second as imaginary part.
fn merge(a: &Spectrum, b: Option<&Spectrum>, packed: &mut [Complex32]) {
    for (i, z) in packed.iter_mut().enumerate() {
        let (j, sign) = if i < HALF { (i, 1.0) } else { (opposite(i), -1.0) };
        let (re, im) = b.map_or((0.0, 0.0), |b| (b.re[j], sign * b.im[j]));
        *z = Complex32::new(a.re[j] - im, sign * a.im[j] + re);
    }
}

/// Σ a·b over the whole spectrum, from its halves: rows 0 and SIDE/2 occur once, the others twice.
fn whole_sum_of_products(a: &[f32], b: &[f32]) -> f64 {
    let sum = |range: std::ops::Range<usize>| {
        f64::from(a[range.clone()].iter().zip(&b[range]).map(|(a, b)| a * b).sum::<f32>())
    };
    sum(0..SIDE) + 2.0 * sum(SIDE..HALF - SIDE) + sum(HALF - SIDE..HALF)
}

/// Number of pixels up to which images are examined from level 0 on.
const SMALL_PIXELS: usize = 25_000;
/// Number of pixels up to which images are examined from level 1 on, larger ones from level 2 on.
const MEDIUM_PIXELS: usize = 270_000;
const LEVELS: u32 = 3;

/// Levels at which an image of `size` is examined: those whose sides are at least `min_side` level pixels.
pub(super) fn levels_for((width, height): (usize, usize), min_side: usize) -> Range<u32> {
    let larger_than = |pixels: usize| u32::from(width * height > pixels);
    // Large images start at coarser levels, which still have many windows and take a quarter of the time each.
    let first = larger_than(SMALL_PIXELS) + larger_than(MEDIUM_PIXELS);
    let fits = |level: &u32| (width.min(height) >> level) >= min_side;
    let first = (0..=first).rev().find(fits).unwrap_or(0);
    first..first + (first..first + LEVELS).take_while(fits).count() as u32
}

/// Whether lines along `axis`, 0 for u and 1 for v, cross the whole picture: the edges of things end or lean, so that
/// parts of the picture that follow one another along the axis have none of their lines in common.
fn has_lines(frames: &[Plane], axis: usize) -> bool {
    let (mut shared, mut own) = (0.0, 0.0);
    for frame in frames.iter().step_by(frames.len().div_ceil(FRAMES_COMPARED).max(1)) {
        let [along, across] = if axis == 0 { frame.size().into() } else { [frame.height(), frame.width()] };
        let value = |line: usize, at: usize| if axis == 0 { frame.at(at, line) } else { frame.at(line, at) };
        let part = |k: usize| -> Vec<f64> {
            let range = k * along / PARTS..(k + 1) * along / PARTS;
            let sum = |line: usize| range.clone().map(|at| f64::from(value(line, at))).sum::<f64>();
            let lines: Vec<f64> = (0..across).map(sum).collect();
            // What varies slowly across lines is the scene's light.
            lines.windows(3).map(|three| three[1] - 0.5 * (three[0] + three[2])).collect()
        };
        let parts: Vec<Vec<f64>> = (0..PARTS).map(part).collect();
        for line in 0..across.saturating_sub(2) {
            let of_parts = || parts.iter().map(|part| part[line]);
            let squares = of_parts().map(|x| x * x).sum::<f64>();
            shared += of_parts().sum::<f64>().powi(2) - squares;
            own += (PARTS - 1) as f64 * squares;
        }
    }
    shared > MIN_SHARED * own
}

pub(super) fn pyramids(frames: &[&Plane], levels: Range<u32>, monitor: &Monitor) -> Result<Vec<Vec<Plane>>, Cancelled> {
    let mut by_level: Vec<Vec<Plane>> = Vec::with_capacity(levels.len());
    for level in levels {
        let plane = |t: usize| {
            monitor.check()?;
            Ok(by_level.last().map_or_else(|| means(frames[t], 1 << level), |finer| means(&finer[t], 2)))
        };
        let planes = (0..frames.len()).into_par_iter().map(plane).collect::<Result<_, Cancelled>>()?;
        by_level.push(planes);
    }
    Ok(by_level)
}

/// Means over squares of `side` × `side` pixels; incomplete squares at the right and below are dropped.
fn means(plane: &Plane, side: usize) -> Plane {
    let (width, height) = (plane.width() / side, plane.height() / side);
    let mut out = Plane::zeros(width, height);
    let mut sums = vec![0.0; width * side];
    for (v, row) in out.data_mut().chunks_exact_mut(width.max(1)).enumerate() {
        sums.copy_from_slice(&plane.row(v * side)[..width * side]);
        (1..side).for_each(|i| add_row(&mut sums, plane.row(v * side + i)));
        mean_row(row, &sums, side);
    }
    out
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn add_row(sums: &mut [f32], row: &[f32]) {
    sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn mean_row(row: &mut [f32], sums: &[f32], side: usize) {
    let scale = 1.0 / (side * side) as f32;
    match side {
        2 => row.iter_mut().zip(sums.chunks_exact(2)).for_each(|(x, s)| *x = (s[0] + s[1]) * scale),
        4 => row.iter_mut().zip(sums.chunks_exact(4)).for_each(|(x, s)| *x = ((s[0] + s[1]) + (s[2] + s[3])) * scale),
        _ => row.iter_mut().zip(sums.chunks_exact(side)).for_each(|(x, s)| *x = s.iter().sum::<f32>() * scale),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Positions;
    use crate::synth::random::Stream;

    fn moving(step: (f64, f64), count: usize) -> Vec<Plane> {
        let mut noise = Stream::new(3, 0);
        let waves: Vec<[f64; 4]> = (0..40)
            .map(|_| {
                let (u, v) = (noise.within(-0.9, 0.9), noise.within(-0.9, 0.9));
                [u, v, noise.within(0.0, std::f64::consts::TAU), noise.normal()]
            })
            .collect();
        let value = |u: f64, v: f64| waves.iter().map(|w| w[3] * (w[0] * u + w[1] * v + w[2]).cos()).sum::<f64>();
        let at = |t: usize, u: usize, v: usize| value(u as f64 - t as f64 * step.0, v as f64 - t as f64 * step.1);
        (0..count).map(|t| Plane::from_fn(40, 40, |u, v| at(t, u, v) as f32)).collect()
    }

    #[test]
    fn a_correlation_is_the_sum_of_shifted_products() {
        let fourier = Fourier::new();
        let frames = moving((2.0, -1.0), 3);
        let mut scratch = fourier.scratch(3);
        let lags = Lags::of(&Positions::even(3));
        let products = fourier.products(&frames, &lags, (4, 3), &mut scratch);
        let mut pairs = CrossSpectra::zeros(lags.near.len());
        fourier.add_pairs(&mut pairs, &lags, &scratch);
        let correlations = fourier.correlations(&products.products, &mut scratch);
        assert_eq!((products.products.len(), correlations.len(), lags.neighbours()), (2, 2, 2));
        assert_eq!((lags.near, &pairs.products[2]), (vec![(0, 1), (1, 2), (0, 2)], &products.products[1]));
        // The band-passed windows themselves, one at a time.
        let band_passed = |frame: &Plane| {
            let mut packed = vec![Complex32::default(); AREA];
            fourier.pack(frame, None, (4, 3), &mut packed);
            let mut turned = packed.clone();
            let mut fft = vec![Complex32::default(); scratch.fft.len()];
            transform(&*fourier.forward, &mut packed, &mut turned, &mut fft);
            let mut spectrum = Spectrum::zeros();
            unpack(&packed, &fourier.band, &mut spectrum, None);
            fourier.correlations(&[spectrum], &mut fourier.scratch(0)).remove(0)
        };
        let planes: Vec<Vec<f32>> = frames.iter().map(band_passed).collect();
        let by_hand = |a: &[f32], b: &[f32], (du, dv): (usize, usize)| -> f32 {
            (0..AREA).map(|i| a[i] * b[(i / SIDE + dv) % SIDE * SIDE + (i % SIDE + du) % SIDE]).sum()
        };
        for shift in [(0, 0), (2, 31), (5, 7), (30, 1)] {
            let index = shift.1 * SIDE + shift.0;
            let lag_1 = by_hand(&planes[0], &planes[1], shift) + by_hand(&planes[1], &planes[2], shift);
            let scale = by_hand(&planes[0], &planes[0], (0, 0));
            assert!((correlations[0][index] - lag_1).abs() < 1e-3 * scale, "{shift:?}");
            let lag_2 = by_hand(&planes[0], &planes[2], shift);
            assert!((correlations[1][index] - lag_2).abs() < 1e-3 * scale, "{shift:?}");
        }
        // The correlation is largest at the motion of the scene.
        let largest = (0..AREA).max_by(|&a, &b| correlations[0][a].total_cmp(&correlations[0][b]));
        assert_eq!(largest, Some((SIDE - 1) * SIDE + 2));
    }

    #[test]
    fn the_variance_is_that_of_frames_with_nothing_in_common() {
        let fourier = Fourier::new();
        let mut noise = Stream::new(9, 0);
        let (mut measured, mut predicted, mut scratch) = (0.0, 0.0, fourier.scratch(4));
        for _ in 0..20 {
            let frames: Vec<Plane> = (0..4).map(|_| Plane::from_fn(32, 32, |_, _| noise.normal() as f32)).collect();
            let products = fourier.products(&frames, &Lags::of(&Positions::even(4)), (0, 0), &mut scratch);
            let correlations = fourier.correlations(&products.products, &mut scratch);
            measured += correlations[0].iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / AREA as f64;
            predicted += products.variance[0];
        }
        assert!((measured / predicted - 1.0).abs() < 0.1, "{measured} {predicted}");
    }

    #[test]
    fn a_level_holds_the_means_of_its_squares() {
        let frame = Plane::from_fn(43, 38, |u, v| (u * 3 + v * 7 % 5) as f32);
        let levels = pyramids(&[&frame, &frame], 1..3, &Monitor::default()).expect("not cancelled");
        assert_eq!((levels.len(), levels[0].len()), (2, 2));
        for (plane, side) in levels.iter().map(|l| &l[1]).zip([2, 4]) {
            assert_eq!(plane.size(), (43 / side, 38 / side));
            let sum: f32 = (0..side * side).map(|i| frame.at(2 * side + i % side, 3 * side + i / side)).sum();
            assert!((plane.at(2, 3) - sum / (side * side) as f32).abs() < 1e-4);
        }
    }

    #[test]
    fn levels_suit_the_size_and_never_get_too_small() {
        assert_eq!(levels_for((120, 160), 32), 0..2);
        assert_eq!(levels_for((480, 360), 32), 1..4);
        assert_eq!(levels_for((1600, 1200), 32), 2..5);
        assert_eq!(levels_for((4000, 40), 32), 0..1);
        assert!(levels_for((31, 500), 32).is_empty());
    }
}
