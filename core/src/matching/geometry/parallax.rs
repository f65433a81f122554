//! Plane and parallax: where a point of one view lies in the other, by its inverse depth.
//!
//! A point x of A lies in B at H·x + κ·e, where H is the transfer by some plane, e the epipole in B, and κ the parallax
//! relative to that plane. With a known camera H is the transfer by infinity, and κ the inverse depth; with an unknown
//! one κ is the inverse depth times a factor plus a plane, c·x (Shashua and Navab, "Relative affine structure", PAMI
//! 1996). So one number, or four, turn the inverse depths of a burst into places in another one.

use super::model::{TwoViewModel, straightened};
use super::points::{cross_matrix, null_vector};
use crate::camera::Camera;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Transfer of points into the other view by their parallax, in pixels without distortion ([`Parallax::straight`]).
#[derive(Debug, Clone)]
pub(in crate::matching) struct Parallax {
    by_plane: Matrix3<f64>,
    epipole: Vector3<f64>,
    /// Cameras of this view and of the other one, where they are known: then the plane is infinity.
    pub cameras: Option<[Camera; 2]>,
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
            TwoViewModel::Essential { cameras: [a, b], .. } => {
                let (pose, _) = model.relative_pose(inliers)?;
                let there = |here: &Camera, other: &Camera, rotation: Matrix3<f64>, translation: Vector3<f64>| {
                    let k = other.matrix();
                    let (by_plane, epipole) = (k * rotation * here.matrix().try_inverse()?, k * translation);
                    Some(Self { by_plane, epipole, cameras: Some([here.clone(), other.clone()]) })
                };
                // The way back: the inverse of the pose.
                let turned = pose.rotation.transpose();
                let back = there(b, a, turned, -(turned * pose.translation))?;
                Some([there(a, b, pose.rotation, pose.translation)?, back])
            }
            TwoViewModel::Fundamental { fundamental } => {
                let there = |f: Matrix3<f64>| {
                    let epipole = null_vector(&f.transpose())?;
                    // Any plane will do, since the parallax counts from it: this matrix needs no match.
                    let by_plane = (cross_matrix(&epipole) * f).try_normalize(0.0)?;
                    Some(Self { by_plane, epipole, cameras: None })
                };
                Some([there(*fundamental)?, there(fundamental.transpose())?])
            }
        }
    }

    /// The pixel of this view (`image` 0) or the other one (1) as a camera without distortion would see it.
    pub fn straight(&self, image: usize, pixel: [f64; 2]) -> Vector2<f64> {
        Vector2::from(self.cameras.as_ref().map_or(pixel, |cameras| straightened(&cameras[image], pixel)))
    }

    /// The place in the other view of what is at `x` with parallax `kappa`; `None` at infinity and behind the camera.
    pub fn transferred(&self, x: Vector2<f64>, kappa: f64) -> Option<Transferred> {
        let there = self.by_plane * x.push(1.0) + self.epipole * kappa;
        let place = there.xy() / there.z;
        let by_parallax = (self.epipole.xy() - place * self.epipole.z) / there.z;
        let is_there = (there.z > 0.0 || self.cameras.is_none()) && (place.norm() + by_parallax.norm()).is_finite();
        is_there.then_some(Transferred { place, by_parallax })
    }

    pub fn parallax(&self, x: Vector2<f64>, there: Vector2<f64>) -> Option<f64> {
        let there = there.push(1.0);
        let (fixed, moves) = (there.cross(&(self.by_plane * x.push(1.0))), there.cross(&self.epipole));
        let kappa = -fixed.dot(&moves) / moves.norm_squared();
        kappa.is_finite().then_some(kappa)
    }
}
