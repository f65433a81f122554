//! Keypoint: an extremum that the search found, before it is localised, oriented and described.

use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::levels::octave_pixel;

/// An extremum of D that passed every test of the search, at the place and scale of the quadratic fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keypoint {
    /// The octave in which it was found.
    pub octave: i32,
    /// Column, octave pixels.
    pub x: f32,
    /// Row, octave pixels.
    pub y: f32,
    /// Scale, octave pixels.
    pub sigma_octave: f32,
    /// DoG level.
    pub level: i32,
    /// The sample (column, row) that was the candidate, octave pixels. No two keypoints of one octave, level and slope
    /// share it.
    pub sample: [u32; 2],
    /// Index in the slope grid.
    pub slope_index: usize,
    /// Slope, refined between those of the grid; pixels per frame.
    pub slope: Slope,
    /// D at the keypoint, fraction of full scale.
    pub value: f32,
    /// |D| over its noise; infinite for a noiseless burst.
    pub snr: f32,
}

impl Keypoint {
    /// Place (u, v) and scale σ in input pixels.
    pub fn in_image(&self) -> (f32, f32, f32) {
        let pixel = octave_pixel(self.octave);
        (self.x * pixel, self.y * pixel, self.sigma_octave * pixel)
    }

    /// Strength for ranking: see [`strength`].
    pub fn strength(&self) -> f32 {
        strength(self.value, self.snr)
    }
}

/// Strength of a response for ranking: |response|·√snr, or |response| where the burst has no noise.
///
/// Response alone puts noise at fine scales above large faint blobs; signal-to-noise alone puts the weak hollows
/// between large blobs above everything. Their product found most discs of the charts among 10 % of false features,
/// over powers 0, ½, 1 and 2 of the snr.
pub fn strength(response: f32, snr: f32) -> f32 {
    response.abs() * if snr.is_finite() { snr.sqrt() } else { 1.0 }
}
