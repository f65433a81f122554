//! The scale space: octaves and levels in VLFeat's convention.
//!
//! Octave `o` has pixels of 2^o input pixels; its levels `s = −1 … S+1` have σ = σ0·2^(o + s/S) input pixels, with σ0 =
//! 1.6·2^(1/S), so that the first level of an octave always has σ = 1.6 octave pixels. The input is taken to have σ =
//! 0.5. Each level is blurred from the one before it by σ0·2^(s/S)·√(1 − 2^(−2/S)) octave pixels; the next octave
//! starts from every second pixel of level S−1, whose σ is twice the first level's. DoG level `s` (−1 … S) is
//! `G(s+1) − G(s)`, and extrema are searched at levels 0 … S−1. Octave −1 is the image doubled by linear interpolation:
//! pixel (2i, 2j) is pixel (i, j). Positive first octaves take every 2^o-th pixel.

use crate::detector::params::{DetectorParams, MIN_OCTAVE_SIDE};
use crate::kernel::gaussian_bank::FilterBank;
use crate::plane::blur::GaussianKernel;
use std::ops::Range;

/// Assumed σ of the input image, in input pixels.
pub const SIGMA_INPUT: f64 = 0.5;
/// σ of the first level (s = −1) of every octave, in octave pixels.
pub const SIGMA_BASE: f64 = 1.6;

/// Scales and kernels of a scale space with `S` levels per octave.
#[derive(Debug, Clone)]
pub struct ScaleSpace {
    /// Number of levels per octave, S.
    pub levels: usize,
    /// Index of the finest octave.
    pub first_octave: i32,
    /// Radius at which kernels are cut, in standard deviations.
    pub kernel_cut: f64,
    /// Kernel from the input's σ to the first level of the first octave.
    pub base_kernel: GaussianKernel,
    /// Kernels from level s−1 to level s, for s = 0 … S+1.
    pub step_kernels: Vec<GaussianKernel>,
}

impl ScaleSpace {
    /// Scale space of a search with `params`.
    pub fn of(params: &DetectorParams) -> Self {
        Self::new(params.levels as usize, params.first_octave, f64::from(params.kernel_cut))
    }

    /// Scale space of `levels` per octave from octave `first_octave` on, with kernels that end at `kernel_cut` standard
    /// deviations.
    pub fn new(levels: usize, first_octave: i32, kernel_cut: f64) -> Self {
        let input = SIGMA_INPUT * 2f64.powi(-first_octave);
        let base = (SIGMA_BASE * SIGMA_BASE - input * input).max(0.0).sqrt();
        let step_kernels =
            (0..levels + 2).map(|s| GaussianKernel::with_cut(Self::step_sigma(levels, s), kernel_cut)).collect();
        Self { levels, first_octave, base_kernel: GaussianKernel::with_cut(base, kernel_cut), step_kernels, kernel_cut }
    }

    fn sigma0(levels: usize) -> f64 {
        SIGMA_BASE * 2f64.powf(1.0 / levels as f64)
    }

    /// σ of the blur from level s−1 to level s, octave pixels.
    fn step_sigma(levels: usize, s: usize) -> f64 {
        let k = 2f64.powf(1.0 / levels as f64);
        Self::sigma0(levels) * k.powi(s as i32) * (1.0 - 1.0 / (k * k)).sqrt()
    }

    /// σ in octave pixels at `level`, which may be fractional.
    pub fn sigma_octave(&self, level: f64) -> f64 {
        Self::sigma0(self.levels) * 2f64.powf(level / self.levels as f64)
    }

    /// σ in input pixels at `octave` and `level`.
    pub fn sigma_image(&self, octave: i32, level: f64) -> f64 {
        self.sigma_octave(level) * 2f64.powi(octave)
    }

    /// Filters that make the Gaussian level indices `levels` (0 is level −1) of an octave from its pixels: of the first
    /// octave from the stacked image, of later ones from their first level.
    pub fn bank(&self, first: bool, levels: Range<usize>) -> FilterBank {
        let base = if first { self.base_kernel.clone() } else { GaussianKernel::new(0.0) };
        FilterBank::new(std::iter::once(base).chain(self.step_kernels.iter().cloned()).collect(), levels)
    }

    /// Indices of all Gaussian levels of an octave: those of levels −1 … S+1.
    pub fn all_levels(&self) -> Range<usize> {
        0..self.levels + 3
    }
}

/// Size (columns, rows) of an octave of an image of `size`.
pub fn octave_size(size: (usize, usize), octave: i32) -> (usize, usize) {
    if octave < 0 { (size.0 << -octave, size.1 << -octave) } else { (size.0 >> octave, size.1 >> octave) }
}

/// Number of input pixels per octave pixel along a side, 2^octave.
pub fn octave_pixel(octave: i32) -> f32 {
    2f32.powi(octave)
}

/// Octaves that a search with `params` visits in an image of `size` = (columns, rows): those requested, as long as
/// their shorter side has [`MIN_OCTAVE_SIDE`] pixels. At least the first one.
pub fn searched_octaves(params: &DetectorParams, size: (usize, usize)) -> Range<i32> {
    let first = params.first_octave;
    let side = size.0.min(size.1);
    let fits = |o: i32| (if o < 0 { side * 2 } else { side >> o }) >= MIN_OCTAVE_SIDE;
    let end = (first..first + params.octaves as i32).take_while(|&o| fits(o)).last().unwrap_or(first) + 1;
    first..end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_follow_vlfeat() {
        let space = ScaleSpace::new(3, -1, 4.0);
        assert!((space.sigma_octave(-1.0) - 1.6).abs() < 1e-12);
        assert!((space.sigma_octave(2.0) - 3.2).abs() < 1e-12);
        assert!((space.sigma_image(-1, 0.0) - 1.6 * 2f64.powf(1.0 / 3.0) / 2.0).abs() < 1e-12);
        assert!((space.sigma_image(1, -1.0) - space.sigma_image(0, 2.0)).abs() < 1e-12);
        assert_eq!(space.step_kernels.len(), 5);
    }

    #[test]
    fn each_step_adds_up_to_the_level() {
        let space = ScaleSpace::new(4, 0, 4.0);
        let mut variance = SIGMA_BASE * SIGMA_BASE;
        for s in 0..6 {
            variance += ScaleSpace::step_sigma(4, s).powi(2);
            assert!((variance.sqrt() - space.sigma_octave(s as f64)).abs() < 1e-9);
        }
    }

    #[test]
    fn octaves_halve() {
        assert_eq!(octave_size((801, 640), 1), (400, 320));
        assert_eq!(octave_size((10, 20), -1), (20, 40));
    }
}
