//! Gaussian kernels, and the plain separable blur that defines their result.
//!
//! A kernel is the Gaussian sampled at whole pixels out to ⌈4σ⌉, of sum 1, as in VLFeat (`vl_imsmooth`); beyond the
//! image the nearest pixel is repeated. [`gaussian_blur`] is the reference for `crate::kernel::gaussian_bank`.

use super::{Mask, Plane};
use crate::monitor::{Cancelled, Monitor};
use rayon::prelude::*;

/// Symmetric, normalised Gaussian kernel: the centre tap and the taps to one side.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussianKernel {
    half: Vec<f32>,
}

impl GaussianKernel {
    /// Kernel of standard deviation `sigma` in pixels (0 or less gives the identity), cut at ⌈4σ⌉.
    pub fn new(sigma: f64) -> Self {
        Self::with_cut(sigma, 4.0)
    }

    /// Kernel of standard deviation `sigma` in pixels, cut at ⌈`cut`·σ⌉; `cut` in standard deviations.
    pub fn with_cut(sigma: f64, cut: f64) -> Self {
        if sigma <= 0.0 {
            return Self { half: vec![1.0] };
        }
        let radius = (cut * sigma).ceil().max(1.0) as usize;
        let taps: Vec<f64> = (0..=radius).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
        let sum = taps[0] + 2.0 * taps[1..].iter().sum::<f64>();
        Self { half: taps.iter().map(|t| (t / sum) as f32).collect() }
    }

    pub(crate) fn of_half(half: Vec<f32>) -> Self {
        Self { half }
    }

    /// Taps to each side of the centre.
    pub fn radius(&self) -> usize {
        self.half.len() - 1
    }

    /// Taps from the centre to one side.
    pub fn half(&self) -> &[f32] {
        &self.half
    }
}

/// Whole image blurred by `kernel`, along the columns, then along the rows: the plain reference, and slow.
pub fn gaussian_blur(plane: &Plane, kernel: &GaussianKernel) -> Plane {
    let (width, height) = plane.size();
    let inside = |i: usize, k: i64, n: usize| (i as i64 + k).clamp(0, n as i64 - 1) as usize;
    let reach = kernel.radius() as i64;
    let sum = |at: &dyn Fn(i64) -> f32| (-reach..=reach).map(|k| kernel.half[k.unsigned_abs() as usize] * at(k)).sum();
    let columns = Plane::from_fn(width, height, |u, v| sum(&|k| plane.at(u, inside(v, k, height))));
    Plane::from_fn(width, height, |u, v| sum(&|k| columns.at(inside(u, k, width), v)))
}

/// Plane smoothed by a Gaussian of `sigma_px` pixels (0 or less: unchanged), cut at 3σ; to look at, not to detect. NaN
/// stays NaN, and its neighbours are smoothed without it. The same for any number of threads.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn smoothed(plane: &Plane, sigma_px: f64, monitor: &Monitor) -> Result<Plane, Cancelled> {
    if sigma_px <= 0.0 {
        return Ok(plane.clone());
    }
    let kernel = GaussianKernel::with_cut(sigma_px, 3.0);
    if !plane.data().iter().any(|x| x.is_nan()) {
        return blurred_by_rows(plane, &kernel, monitor);
    }
    // Normalised by the blurred weights of the known values, so that NaN leaves no dark rim.
    let of = |value: fn(f32) -> f32| {
        let data = plane.data().iter().map(|&x| value(x)).collect();
        blurred_by_rows(&Plane::from_vec(plane.width(), plane.height(), data), &kernel, monitor)
    };
    let known = of(|x| f32::from(!x.is_nan()))?;
    let mut sum = of(|x| if x.is_nan() { 0.0 } else { x })?;
    for ((sum, known), &x) in sum.data_mut().iter_mut().zip(known.data()).zip(plane.data()) {
        *sum = if x.is_nan() { f32::NAN } else { *sum / known };
    }
    Ok(sum)
}

/// Plane (with its mask) blurred by a triangle that reaches 0 at `half_width` pixels; the nearest pixel is repeated.
pub(crate) fn triangle_blur(plane: &Plane, half_width: usize, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let area = (half_width * half_width) as f32;
    let kernel = GaussianKernel::of_half((0..half_width).map(|k| (half_width - k) as f32 / area).collect());
    let mask = plane.mask().map(|mask| blurred_by_rows(mask.weights(), &kernel, monitor)).transpose()?;
    Ok(blurred_by_rows(plane, &kernel, monitor)?.with_mask(mask.and_then(Mask::new)))
}

fn blurred_by_rows(plane: &Plane, kernel: &GaussianKernel, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let (width, height) = plane.size();
    let reach = kernel.radius();
    let mut blurred = Plane::zeros(width, height);
    let row_of = |(v, out): (usize, &mut [f32])| -> Result<(), Cancelled> {
        monitor.check()?;
        // Both passes for one row: the column sums stay in the cache and need no second plane.
        let mut row = vec![0.0; width + 2 * reach];
        for k in 0..=2 * reach {
            let weight = kernel.half[k.abs_diff(reach)];
            let from = plane.row((v + k).saturating_sub(reach).min(height - 1));
            row[reach..reach + width].iter_mut().zip(from).for_each(|(sum, x)| *sum += weight * x);
        }
        let (first, last) = (row[reach], row[reach + width - 1]);
        row[..reach].fill(first);
        row[reach + width..].fill(last);
        for k in 0..=2 * reach {
            let weight = kernel.half[k.abs_diff(reach)];
            out.iter_mut().zip(&row[k..]).for_each(|(sum, x)| *sum += weight * x);
        }
        Ok(())
    };
    if width > 0 {
        blurred.data_mut().par_chunks_mut(width).enumerate().try_for_each(row_of)?;
    }
    Ok(blurred)
}
