//! The coarser scales of a pooled descriptor: Gaussian levels around a feature at half the octave's resolution.
//!
//! A descriptor is pooled over the feature's own σ and over coarser scales, each [`SCALE_RATIO`] times the one before:
//! cells and blur grow with the scale. Coarser levels hold no detail that pixels of twice the size would lose, so the
//! stacked patch is halved once, and each level is a blur of that half.

use super::descriptor::{DescriptorScratch, Square, Sums, coarse_radius, sums as sums_of};
use crate::detector::along::around;
use crate::kernel::patch::{BlurScratch, Patch};
use crate::plane::blur::GaussianKernel;

/// Ratio of neighbouring scales, tuned on dark bursts of two scenes with other views kept back (docs/MEASUREMENTS.md).
const SCALE_RATIO: f32 = 1.75;

/// Cut of the coarser levels' kernels, in their σ, at most: patches stay narrow, and 0.3 % of the weight is lost.
const MAX_CUT: f64 = 3.0;

#[derive(Default)]
pub(super) struct CoarseScratch {
    half: Patch,
    level: Patch,
}

pub(super) struct CoarserScales {
    /// Blur of the halved patch to the level of each scale.
    kernels: Vec<GaussianKernel>,
}

impl CoarserScales {
    /// The scales beyond the first of `scales` for features of a level of σ `level`, from a patch of σ `from`, both in
    /// octave pixels; kernels end at `cut` of their σ, and at [`MAX_CUT`].
    pub(super) fn new(scales: u32, level: f64, from: f64, cut: f64) -> Self {
        // The mean of two pixels is as wide as two points half a pixel to each side of it: a variance of a quarter.
        let half_variance = 0.25 * (from * from + 0.25);
        let kernel = |scale: u32| {
            let sigma = 0.5 * level * f64::from(ratio(scale));
            GaussianKernel::with_cut((sigma * sigma - half_variance).max(0.0).sqrt(), cut.min(MAX_CUT))
        };
        Self { kernels: (1..scales).map(kernel).collect() }
    }

    /// Pixels of the octave that are needed around a feature of σ `sigma`, octave pixels; 0 without coarser scales.
    pub(super) fn reach(&self, sigma: f32) -> usize {
        let of_scale =
            |(kernel, scale): (&GaussianKernel, u32)| coarse_radius(half_sigma(sigma, scale)) + kernel.radius();
        // The halved pixel around the feature begins up to two pixels beside it.
        self.kernels.iter().zip(1..).map(of_scale).max().map_or(0, |reach| 2 * (reach + 1) + 3)
    }

    /// Appends the sums of each coarser scale to those of each of `angles` (radians), of a feature at (x, y) of σ
    /// `sigma`, from `raw`, which reaches [`Self::reach`] pixels around. The octave has `size`.
    pub(super) fn append(
        &self,
        raw: &Patch,
        size: (usize, usize),
        (x, y): (f32, f32),
        sigma: f32,
        (angles, sums): (&[f32], &mut [Vec<Sums>]),
        (coarse, blur, scratch): (&mut CoarseScratch, &mut BlurScratch, &mut DescriptorScratch),
    ) {
        if self.kernels.is_empty() {
            return;
        }
        let CoarseScratch { half, level } = coarse;
        half.halve(raw);
        // The first halved pixel is the mean of pixels 0 and 1.
        let (x, y) = (0.5 * (x - 0.5), 0.5 * (y - 0.5));
        let size = (size.0 / 2, size.1 / 2);
        for (kernel, scale) in self.kernels.iter().zip(1..) {
            let sigma = half_sigma(sigma, scale);
            let reach = coarse_radius(sigma) + 1;
            half.blurred(around(x, reach), around(y, reach), kernel, blur, level);
            for (&angle, sums) in angles.iter().zip(sums.iter_mut()) {
                sums.push(sums_of(level, size, &Square::coarse((x, y), sigma, angle), scratch));
            }
        }
    }
}

/// Scale number `scale` as a multiple of the feature's own, which is number 0.
fn ratio(scale: u32) -> f32 {
    SCALE_RATIO.powi(scale as i32)
}

/// σ of scale number `scale` of a feature of σ `sigma`, octave pixels, in halved pixels.
fn half_sigma(sigma: f32, scale: u32) -> f32 {
    0.5 * sigma * ratio(scale)
}
