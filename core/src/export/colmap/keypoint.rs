//! Keypoints in the form of COLMAP's files.

use crate::detector::Feature;

/// Half a pixel: the coordinate of the first pixel's centre in COLMAP.
pub(super) const FIRST_PIXEL: f64 = 0.5;

/// Keypoint in COLMAP's convention: the centre of the first pixel is (0.5, 0.5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColmapKeypoint {
    /// Column, pixels.
    pub x: f32,
    /// Row, pixels.
    pub y: f32,
    /// Scale σ, pixels.
    pub scale: f32,
    /// Orientation, radians, from +x towards +y.
    pub orientation: f32,
}

impl ColmapKeypoint {
    /// Position (u, v) in Burstscope's convention, where the centre of the first pixel is (0, 0).
    pub fn pos_image(&self) -> [f64; 2] {
        [f64::from(self.x) - FIRST_PIXEL, f64::from(self.y) - FIRST_PIXEL]
    }
}

impl From<&Feature> for ColmapKeypoint {
    fn from(feature: &Feature) -> Self {
        // COLMAP uses 32-bit floats; the sum is rounded once.
        let moved = |place: f32| (f64::from(place) + FIRST_PIXEL) as f32;
        Self { x: moved(feature.u), y: moved(feature.v), scale: feature.sigma, orientation: feature.orientation }
    }
}
