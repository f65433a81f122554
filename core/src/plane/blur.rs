//! Gaussian kernels, and the plain separable blur that defines what they compute.
//!
//! A kernel is the Gaussian sampled at whole pixels out to ⌈4σ⌉ and normalised to sum 1, as in VLFeat (`vl_imsmooth`);
//! beyond the image the nearest pixel is repeated. The detector makes its levels with [`crate::kernel::gaussian_bank`];
//! [`gaussian_blur`] is the reference for its tests.

use super::Plane;

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

/// The whole image blurred by `kernel`: along the columns, then along the rows.
pub fn gaussian_blur(plane: &Plane, kernel: &GaussianKernel) -> Plane {
    let (width, height) = plane.size();
    let inside = |i: usize, k: i64, n: usize| (i as i64 + k).clamp(0, n as i64 - 1) as usize;
    let reach = kernel.radius() as i64;
    let sum = |at: &dyn Fn(i64) -> f32| (-reach..=reach).map(|k| kernel.half[k.unsigned_abs() as usize] * at(k)).sum();
    let columns = Plane::from_fn(width, height, |u, v| sum(&|k| plane.at(u, inside(v, k, height))));
    Plane::from_fn(width, height, |u, v| sum(&|k| columns.at(inside(u, k, width), v)))
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
        let blurred = gaussian_blur(&flat, &kernel);
        assert!(blurred.data().iter().all(|x| (x - 0.25).abs() < 1e-6));

        let point = Plane::from_fn(150, 41, |u, v| f32::from(u == 70 && v == 20));
        let blurred = gaussian_blur(&point, &kernel);
        for (du, dv) in [(0, 0), (1, 0), (0, 3), (4, 2), (6, 6)] {
            let expected = kernel.half()[du] * kernel.half()[dv];
            assert!((blurred.at(70 + du, 20 - dv) - expected).abs() < 1e-8);
            assert!((blurred.at(70 - du, 20 + dv) - expected).abs() < 1e-8);
        }
    }
}
