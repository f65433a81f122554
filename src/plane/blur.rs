//! Separable Gaussian blur, row by row.
//!
//! Numerics. A kernel is the Gaussian sampled at whole pixels out to ⌈4σ⌉ and normalised to sum 1, as in VLFeat (`vl_imsmooth`); beyond the
//! image the nearest pixel is repeated. One output row is made in two passes: the rows above and below are combined (vertical pass, for a few rows at
//! once), then the combined row is convolved (horizontal pass); symmetric taps are added before they are multiplied. Each output value is
//! computed by itself in a fixed order, with fused multiply-adds in full blocks and in the rest alike, so strips and threads cannot change a bit.

use super::Plane;
use super::blocks::{BlockSize, LARGE, SMALL, for_blocks};
use super::rows::{RowSource, Rows};
use crate::monitor::{Cancelled, Monitor};
use multiversion::multiversion;
use rayon::prelude::*;
use std::ops::Range;

/// A symmetric, normalised Gaussian kernel: its centre tap and the taps to one side.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussianKernel {
    half: Vec<f32>,
}

impl GaussianKernel {
    /// The kernel of standard deviation `sigma` in pixels (0 or less gives the identity), cut at ⌈4σ⌉.
    pub fn new(sigma: f64) -> Self {
        Self::with_cut(sigma, 4.0)
    }

    /// The kernel of standard deviation `sigma` in pixels, cut at ⌈`cut`·σ⌉; `cut` in standard deviations.
    pub fn with_cut(sigma: f64, cut: f64) -> Self {
        if sigma <= 0.0 {
            return Self { half: vec![1.0] };
        }
        let radius = (cut * sigma).ceil().max(1.0) as usize;
        let taps: Vec<f64> = (0..=radius).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
        let sum = taps[0] + 2.0 * taps[1..].iter().sum::<f64>();
        Self { half: taps.iter().map(|t| (t / sum) as f32).collect() }
    }

    /// Taps to each side of the centre.
    pub fn radius(&self) -> usize {
        self.half.len() - 1
    }

    /// The centre tap and those to one side.
    pub fn half(&self) -> &[f32] {
        &self.half
    }
}

/// Rows that share one vertical pass: the rows they read overlap, so a block of columns of them stays in the nearest cache.
const GROUP: usize = 8;
/// Kernels reach at most this many pixels to each side: ⌈8σ⌉ at the coarsest step of one level an octave.
const MAX_RADIUS: usize = 128;

/// `B` columns of the vertical pass, from `start` on, for all its output rows.
#[inline(always)]
fn combine_block<const B: usize>(rows: &[&[f32]], half: &[f32], start: usize, out: &mut [f32], stride: usize) {
    let radius = half.len() - 1;
    for i in 0..rows.len() - 2 * radius {
        let centre = i + radius;
        let mut acc = [0.0f32; B];
        let c: &[f32; B] = rows[centre][start..start + B].try_into().expect("a block");
        for u in 0..B {
            acc[u] = half[0] * c[u];
        }
        for (k, &tap) in half.iter().enumerate().skip(1) {
            let a: &[f32; B] = rows[centre - k][start..start + B].try_into().expect("a block");
            let b: &[f32; B] = rows[centre + k][start..start + B].try_into().expect("a block");
            for u in 0..B {
                acc[u] = tap.mul_add(a[u] + b[u], acc[u]);
            }
        }
        out[i * stride + start..i * stride + start + B].copy_from_slice(&acc);
    }
}

/// The vertical pass for `rows.len() − 2·radius` output rows: `out = half[0]·centre + Σ half[k]·(above + below)`. `rows` are the input rows from the first one
/// that is read to the last; output row `i` starts at `out[i·stride]` and has `width` values.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn combine_rows(rows: &[&[f32]], half: &[f32], width: usize, out: &mut [f32], stride: usize) {
    for_blocks(
        width,
        #[inline(always)]
        |start, size| match size {
            BlockSize::Large => combine_block::<LARGE>(rows, half, start, out, stride),
            BlockSize::Small => combine_block::<SMALL>(rows, half, start, out, stride),
            BlockSize::One => combine_block::<1>(rows, half, start, out, stride),
        },
    );
}

/// `B` values of the horizontal pass, from `start` on.
#[inline(always)]
fn convolve_block<const B: usize>(padded: &[f32], half: &[f32], start: usize, out: &mut [f32]) {
    let at = start + half.len() - 1;
    let mut acc = [0.0f32; B];
    let c: &[f32; B] = padded[at..at + B].try_into().expect("a block");
    for i in 0..B {
        acc[i] = half[0] * c[i];
    }
    for (k, &tap) in half.iter().enumerate().skip(1) {
        let a: &[f32; B] = padded[at - k..at - k + B].try_into().expect("a block");
        let b: &[f32; B] = padded[at + k..at + k + B].try_into().expect("a block");
        for i in 0..B {
            acc[i] = tap.mul_add(a[i] + b[i], acc[i]);
        }
    }
    out[start..start + B].copy_from_slice(&acc);
}

/// The horizontal pass over `padded`, which has `radius` repeated pixels at each end of `out.len()` real ones.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn convolve_row(padded: &[f32], half: &[f32], out: &mut [f32]) {
    for_blocks(
        out.len(),
        #[inline(always)]
        |start, size| match size {
            BlockSize::Large => convolve_block::<LARGE>(padded, half, start, out),
            BlockSize::Small => convolve_block::<SMALL>(padded, half, start, out),
            BlockSize::One => convolve_block::<1>(padded, half, start, out),
        },
    );
}

/// Blurs the rows `range` of an image of `width` × `height`, and hands each to `write(v, row)`. `source` must hold `range` widened by the kernel's radius and
/// clamped to the image. `padded` is scratch space.
fn blur_each(
    source: &impl RowSource,
    (width, height): (usize, usize),
    kernel: &GaussianKernel,
    range: Range<usize>,
    padded: &mut Vec<f32>,
    mut write: impl FnMut(usize, &mut dyn FnMut(&mut [f32])),
) {
    let radius = kernel.radius();
    assert!(radius <= MAX_RADIUS, "a kernel of radius {radius} is larger than any level needs");
    let stride = width + 2 * radius;
    padded.resize((GROUP * stride).max(padded.len()), 0.0);
    let mut rows: [&[f32]; 2 * MAX_RADIUS + GROUP] = [&[]; 2 * MAX_RADIUS + GROUP];
    let mut first = range.start;
    while first < range.end {
        let count = GROUP.min(range.end - first);
        for (i, row) in rows[..count + 2 * radius].iter_mut().enumerate() {
            *row = source.source_row((first + i).saturating_sub(radius).min(height - 1));
        }
        combine_rows(&rows[..count + 2 * radius], kernel.half(), width, &mut padded[radius..], stride);
        for i in 0..count {
            let line = &mut padded[i * stride..(i + 1) * stride];
            let (before, after) = (line[radius], line[radius + width - 1]);
            line[..radius].fill(before);
            line[radius + width..].fill(after);
            write(first + i, &mut |out| convolve_row(line, kernel.half(), out));
        }
        first += count;
    }
}

/// Blurs rows `range` of an image of `width` × `height` into `out`, which is reset to them. `source` must hold `range` widened by the kernel's
/// radius and clamped to the image. `padded` is scratch space.
pub fn blur_rows(
    source: &impl RowSource,
    size: (usize, usize),
    kernel: &GaussianKernel,
    range: Range<usize>,
    padded: &mut Vec<f32>,
    out: &mut Rows,
) {
    out.reset(size.0, range.clone());
    blur_each(source, size, kernel, range, padded, |v, convolve| convolve(out.row_mut(v)));
}

/// The whole image blurred by `kernel`, rows in parallel.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn gaussian_blur(plane: &Plane, kernel: &GaussianKernel, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let (width, height) = plane.size();
    let mut out = Plane::zeros(width, height);
    if width == 0 || height == 0 {
        return Ok(out);
    }
    out.data_mut().par_chunks_mut(GROUP * width).enumerate().try_for_each_init(Vec::new, |padded, (group, rows)| {
        monitor.check()?;
        let first = group * GROUP;
        let range = first..first + rows.len() / width;
        blur_each(plane, (width, height), kernel, range, padded, |v, convolve| {
            convolve(&mut rows[(v - first) * width..(v - first + 1) * width]);
        });
        Ok(())
    })?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_sum_to_one_and_reach_four_sigma() {
        for sigma in [0.3, 1.0, 1.6, 3.09] {
            let kernel = GaussianKernel::new(sigma);
            let sum = kernel.half()[0] + 2.0 * kernel.half()[1..].iter().sum::<f32>();
            assert!((sum - 1.0).abs() < 1e-6);
            assert_eq!(kernel.radius(), (4.0 * sigma).ceil() as usize);
        }
        assert_eq!(GaussianKernel::new(0.0).half(), &[1.0]);
    }

    #[test]
    fn a_constant_stays_and_a_point_becomes_the_kernel() {
        let flat = Plane::from_fn(150, 20, |_, _| 0.25);
        let kernel = GaussianKernel::new(1.5);
        let blurred = gaussian_blur(&flat, &kernel, &Monitor::default()).expect("not cancelled");
        assert!(blurred.data().iter().all(|x| (x - 0.25).abs() < 1e-6));

        let point = Plane::from_fn(150, 41, |u, v| f32::from(u == 70 && v == 20));
        let blurred = gaussian_blur(&point, &kernel, &Monitor::default()).expect("not cancelled");
        for (du, dv) in [(0, 0), (1, 0), (0, 3), (4, 2), (6, 6)] {
            let expected = kernel.half()[du] * kernel.half()[dv];
            assert!((blurred.at(70 + du, 20 - dv) - expected).abs() < 1e-8);
            assert!((blurred.at(70 - du, 20 + dv) - expected).abs() < 1e-8);
        }
    }

    #[test]
    fn strips_give_the_bits_of_the_whole() {
        let plane = Plane::from_fn(97, 60, |u, v| ((u * 7 + v * 13) % 31) as f32 / 31.0);
        let kernel = GaussianKernel::new(2.2);
        let whole = gaussian_blur(&plane, &kernel, &Monitor::default()).expect("not cancelled");
        let (mut padded, mut strip) = (Vec::new(), Rows::default());
        for start in (0..60).step_by(7) {
            let range = start..(start + 7).min(60);
            blur_rows(&plane, (97, 60), &kernel, range.clone(), &mut padded, &mut strip);
            for v in range {
                assert_eq!(strip.row(v), whole.row(v));
            }
        }
    }

    #[test]
    fn cancelling_stops_a_blur() {
        let monitor = Monitor::default();
        monitor.cancel();
        assert_eq!(gaussian_blur(&Plane::zeros(8, 8), &GaussianKernel::new(1.0), &monitor), Err(Cancelled));
    }
}
