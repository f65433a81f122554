//! The kernels of the levels: convolutions of a chain's kernels.

use crate::plane::blur::GaussianKernel;

/// Kernel of one level: the centre tap and those to one side.
#[derive(Debug, Clone)]
pub(crate) struct Kernel {
    pub half: Vec<f32>,
}

impl Kernel {
    /// Taps to each side of the centre.
    pub fn radius(&self) -> usize {
        self.half.len() - 1
    }
}

/// All taps of a kernel, left to right.
pub(crate) fn all_taps(half: &[f32]) -> Vec<f64> {
    half.iter().skip(1).rev().chain(half).map(|&tap| f64::from(tap)).collect()
}

/// The kernels of all levels of `chain`, each cut at `cut` of its own standard deviations. Radii never decrease.
pub(crate) fn composed(chain: &[GaussianKernel], cut: f64) -> Vec<Kernel> {
    let mut taps = vec![1.0f64];
    let mut radius = 0;
    chain
        .iter()
        .map(|step| {
            taps = convolved(&taps, &all_taps(step.half()));
            let middle = taps.len() / 2;
            let variance: f64 = taps.iter().enumerate().map(|(i, tap)| tap * (i as f64 - middle as f64).powi(2)).sum();
            radius = ((cut * variance.sqrt()).ceil() as usize).clamp(radius, middle.max(radius));
            let half = &taps[middle..=(middle + radius).min(taps.len() - 1)];
            let sum = half[0] + 2.0 * half[1..].iter().sum::<f64>();
            Kernel { half: half.iter().map(|tap| (tap / sum) as f32).collect() }
        })
        .collect()
}

/// The full convolution of two sequences of taps.
fn convolved(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; a.len() + b.len() - 1];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            out[i + j] += a * b;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variances_add_up_and_sums_are_one() {
        let chain = [GaussianKernel::new(1.5), GaussianKernel::new(1.2), GaussianKernel::new(0.0)];
        let kernels = composed(&chain, 4.5);
        for (kernel, variance) in kernels.iter().zip([2.25, 2.25 + 1.44, 2.25 + 1.44]) {
            let taps = all_taps(&kernel.half);
            let middle = kernel.radius() as f64;
            assert!((taps.iter().sum::<f64>() - 1.0).abs() < 1e-6);
            let measured: f64 = taps.iter().enumerate().map(|(i, t)| t * (i as f64 - middle).powi(2)).sum();
            assert!((measured / variance - 1.0).abs() < 3e-3, "{measured} {variance}");
        }
        assert_eq!(kernels[0].half.len(), GaussianKernel::new(1.5).half().len().min(8));
        let identity = composed(&[GaussianKernel::new(0.0)], 4.5);
        assert_eq!(identity[0].half, [1.0]);
    }
}
