//! Two-view geometries in the form of COLMAP's database.

use super::keypoint::FIRST_PIXEL;
use nalgebra::{Isometry3, Matrix3};

/// Kind of a two-view geometry, with COLMAP's number for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GeometryKind {
    /// Too few matches agree on a geometry.
    Degenerate = 1,
    /// Essential matrix, of calibrated cameras.
    Calibrated = 2,
    /// Fundamental matrix.
    Uncalibrated = 3,
    /// Homography, of a plane or of a camera that only turns.
    PlanarOrPanoramic = 6,
}

/// Geometry of images A and B, in Burstscope's pixels (the centre of the first one is (0, 0)).
#[derive(Debug, Clone, PartialEq)]
pub struct DatabaseGeometry {
    /// Kind of the geometry.
    pub kind: GeometryKind,
    /// Index pairs of the inliers' features, of A and of B.
    pub inliers: Vec<[u32; 2]>,
    /// F: x_bᵀ·F·x_a = 0 for pixels.
    pub fundamental: Option<Matrix3<f64>>,
    /// E: d_bᵀ·E·d_a = 0 for directions.
    pub essential: Option<Matrix3<f64>>,
    /// H: x_b ~ H·x_a for pixels.
    pub homography: Option<Matrix3<f64>>,
    /// Map from the frame of A's camera to that of B's.
    pub b_from_a: Option<Isometry3<f64>>,
}

impl DatabaseGeometry {
    /// The geometry of a pair whose matches do not agree.
    pub fn degenerate() -> Self {
        Self {
            kind: GeometryKind::Degenerate,
            inliers: Vec::new(),
            fundamental: None,
            essential: None,
            homography: None,
            b_from_a: None,
        }
    }

    /// This geometry in COLMAP's pixels.
    pub(super) fn in_colmap_pixels(&self) -> Self {
        let there = Matrix3::new(1.0, 0.0, FIRST_PIXEL, 0.0, 1.0, FIRST_PIXEL, 0.0, 0.0, 1.0);
        let back = Matrix3::new(1.0, 0.0, -FIRST_PIXEL, 0.0, 1.0, -FIRST_PIXEL, 0.0, 0.0, 1.0);
        Self {
            fundamental: self.fundamental.map(|f| back.transpose() * f * back),
            homography: self.homography.map(|h| there * h * back),
            ..self.clone()
        }
    }
}
