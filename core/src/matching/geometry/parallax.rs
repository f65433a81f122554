//! Plane and parallax: where a point of one view lies in the other, by its inverse depth.
//!
//! A point x of A lies in B at H·x + κ·e, where H is the transfer by some plane, e the epipole in B, and κ the parallax
//! relative to that plane. With a known camera H is the transfer by infinity, and κ the inverse depth; with an unknown
//! one κ is the inverse depth times a factor plus a plane, c·x (Shashua and Navab, "Relative affine structure", PAMI
//! 1996). So one number, or four, turn the inverse depths of a burst into places in another one.

use super::model::{TwoViewModel, straightened};
use super::points::{cross_matrix, null_vector};
use crate::matching::camera::Camera;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Transfer of points into the other view by their parallax, in pixels without distortion ([`Parallax::straight`]).
#[derive(Debug, Clone)]
pub(in crate::matching) struct Parallax {
    by_plane: Matrix3<f64>,
    epipole: Vector3<f64>,
    /// Whether the plane is infinity.
    pub is_calibrated: bool,
    camera: Option<Camera>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::matching) struct Transferred {
    pub place: Vector2<f64>,
    /// Pixels by which the place moves when κ grows by 1.
    pub by_parallax: Vector2<f64>,
}

impl Parallax {
    /// From A to B and back, for `inliers` of `model`; `None` for a homography, or a degenerate model.
    pub fn of(model: &TwoViewModel, inliers: &[([f64; 2], [f64; 2])]) -> Option<[Self; 2]> {
        match model {
            TwoViewModel::Homography { .. } => None,
            TwoViewModel::Essential { camera, .. } => {
                let (pose, _) = model.relative_pose(inliers)?;
                let k = camera.matrix();
                let back = k.try_inverse()?;
                let there = |rotation: Matrix3<f64>, translation: Vector3<f64>| Self {
                    by_plane: k * rotation * back,
                    epipole: k * translation,
                    is_calibrated: true,
                    camera: Some(camera.clone()),
                };
                // The way back: the inverse of the pose.
                let turned = pose.rotation.transpose();
                Some([there(pose.rotation, pose.translation), there(turned, -(turned * pose.translation))])
            }
            TwoViewModel::Fundamental { fundamental } => {
                let there = |f: Matrix3<f64>| {
                    let epipole = null_vector(&f.transpose())?;
                    // Any plane will do, since the parallax counts from it: this matrix needs no match.
                    let by_plane = (cross_matrix(&epipole) * f).try_normalize(0.0)?;
                    Some(Self { by_plane, epipole, is_calibrated: false, camera: None })
                };
                Some([there(*fundamental)?, there(fundamental.transpose())?])
            }
        }
    }

    pub fn straight(&self, pixel: [f64; 2]) -> Vector2<f64> {
        Vector2::from(self.camera.as_ref().map_or(pixel, |camera| straightened(camera, pixel)))
    }

    /// The place in the other view of what is at `x` with parallax `kappa`; `None` at infinity and behind the camera.
    pub fn transferred(&self, x: Vector2<f64>, kappa: f64) -> Option<Transferred> {
        let there = self.by_plane * x.push(1.0) + self.epipole * kappa;
        let place = there.xy() / there.z;
        let by_parallax = (self.epipole.xy() - place * self.epipole.z) / there.z;
        let is_there = (there.z > 0.0 || !self.is_calibrated) && (place.norm() + by_parallax.norm()).is_finite();
        is_there.then_some(Transferred { place, by_parallax })
    }

    pub fn parallax(&self, x: Vector2<f64>, there: Vector2<f64>) -> Option<f64> {
        let there = there.push(1.0);
        let (fixed, moves) = (there.cross(&(self.by_plane * x.push(1.0))), there.cross(&self.epipole));
        let kappa = -fixed.dot(&moves) / moves.norm_squared();
        kappa.is_finite().then_some(kappa)
    }
}
