//! The similarity that aligns one trajectory with another, and the projection of trajectories to a plane, for drawing.
//!
//! Umeyama, "Least-squares estimation of transformation parameters between two point patterns", IEEE PAMI 13(4), 1991,
//! 376–380: the scale, rotation and translation with the minimum sum of squared distances between the camera centres.
//!
//! A camera on a straight rail leaves the rotation about the rail undetermined. Such trajectories are common (motion in
//! 1D), so the viewing directions of the cameras determine it.

use burstscope_core::error::{Error, ErrorKind, Result};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Ratio of the spread of centres across their direction to that along it, below which noise decides the rotation.
const STRAIGHT: f64 = 0.01;

/// A scale, a rotation and a translation: `x` becomes `scale · rotation · x + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// Scale, greater than 0.
    pub scale: f64,
    /// Rotation, applied before the scale.
    pub rotation: UnitQuaternion<f64>,
    /// Translation, applied last.
    pub translation: Vector3<f64>,
}

impl Similarity {
    /// Transforms a pose: its centre is moved, its directions turned.
    pub fn apply(&self, pose: &Isometry3<f64>) -> Isometry3<f64> {
        let centre = self.place(pose.translation.vector.into());
        Isometry3::from_parts(Translation3::from(centre), self.rotation * pose.rotation)
    }

    /// Transforms a place.
    pub fn place(&self, place: [f64; 3]) -> Vector3<f64> {
        self.rotation * Vector3::from(place) * self.scale + self.translation
    }
}

/// Alignment of an estimate with the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alignment {
    /// Map from the estimate's world to the truth's.
    pub truth_from_estimate: Similarity,
    /// Whether the trajectories are straight, so that the cameras' directions determined the rotation about their line.
    pub straight: bool,
}

/// Finds the best similarity from the poses `estimate` to the poses `truth`, which correspond one to one.
///
/// # Errors
/// Fewer than two pairs, cameras that are all in one place, or trajectories without correlation.
///
/// # Panics
/// When the numbers of poses differ: a mistake of the caller.
pub fn align(estimate: &[Isometry3<f64>], truth: &[Isometry3<f64>]) -> Result<Alignment> {
    assert_eq!(estimate.len(), truth.len(), "poses belong together one by one");
    let degenerate = |problem: String| {
        Err(Error::new(ErrorKind::Failed, format!("the trajectories cannot be aligned: {problem}"), ""))
    };
    if estimate.len() < 2 {
        return degenerate(format!("there is {} pair of poses, and a scale needs two or more", estimate.len()));
    }
    let (from, to) = (Spread::of(estimate), Spread::of(truth));
    for (spread, whose) in [(&from, "estimated"), (&to, "true")] {
        if !spread.is_spread_out() {
            return degenerate(format!("the {whose} cameras all stand in one place, which tells nothing about scale"));
        }
    }
    let n = estimate.len() as f64;
    let pairs = || estimate.iter().zip(truth);
    let covariance: Matrix3<f64> = pairs()
        .map(|(e, t)| (t.translation.vector - to.mean) * (e.translation.vector - from.mean).transpose())
        .sum::<Matrix3<f64>>()
        / n;
    // Scaled to about 1, so that the tolerances of the decomposition do not depend on the unit.
    let unit = (from.variance * to.variance).sqrt();
    let svd = (covariance / unit).svd(true, true);
    let (Some(u), Some(vt)) = (svd.u, svd.v_t) else {
        return degenerate("the camera centres are not finite numbers".to_owned());
    };
    // The best orthogonal map may be a mirror image: the sign at the smallest singular value keeps it a rotation.
    let mirrored = if u.determinant() * vt.determinant() < 0.0 { -1.0 } else { 1.0 };
    let signs = Vector3::new(1.0, 1.0, mirrored);
    let values = svd.singular_values;
    let rotation = u * Matrix3::from_diagonal(&signs) * vt;
    let mut rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    let scale = unit * values.dot(&signs) / from.variance;
    if !(scale.is_finite() && values[0] > 1e-9) {
        return degenerate("the estimated and the true cameras move independently of each other".to_owned());
    }
    // Singular values of the covariance grow with the square of the spread.
    let straight = values[1] < STRAIGHT * STRAIGHT * values[0];
    if straight {
        // All turns about the rail fit the centres alike: the largest sum of traces aligns the viewing directions.
        let axis: Vector3<f64> = u.column(0).into();
        let turned = |(e, t): (&Isometry3<f64>, &Isometry3<f64>)| {
            (rotation * e.rotation * t.rotation.inverse()).to_rotation_matrix().into_inner()
        };
        rotation = rotation_about(axis, &pairs().map(turned).sum()) * rotation;
    }
    // Last, because the turn about the line moves the estimate's mean as well.
    let translation = to.mean - rotation * from.mean * scale;
    Ok(Alignment { truth_from_estimate: Similarity { scale, rotation, translation }, straight })
}

/// The rotation R about the unit vector `axis` with maximum trace of R·`sum`: Rodrigues' `a + b·cos θ + c·sin θ`.
fn rotation_about(axis: Vector3<f64>, sum: &Matrix3<f64>) -> UnitQuaternion<f64> {
    let along = (axis.transpose() * sum * axis)[0];
    let cos = sum.trace() - along;
    let sin = (axis.cross_matrix() * sum).trace();
    UnitQuaternion::new(axis * sin.atan2(cos))
}

struct Spread {
    mean: Vector3<f64>,
    variance: f64,
    /// Largest magnitude of a coordinate.
    magnitude: f64,
}

impl Spread {
    fn of(poses: &[Isometry3<f64>]) -> Self {
        let n = poses.len() as f64;
        let centres = || poses.iter().map(|p| p.translation.vector);
        let mean = centres().sum::<Vector3<f64>>() / n;
        let variance = centres().map(|c| (c - mean).norm_squared()).sum::<f64>() / n;
        Self { mean, variance, magnitude: centres().map(|c| c.amax()).fold(0.0, f64::max) }
    }

    /// Whether the centres differ by more than rounding.
    fn is_spread_out(&self) -> bool {
        self.variance.is_finite() && self.variance.sqrt() > 1e-12 * self.magnitude
    }
}

/// Direction from which a trajectory is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Projection {
    /// Along the direction in which the cameras spread least: the plane that shows most of the trajectory.
    #[default]
    Principal,
    /// Along z.
    Xy,
    /// Along y.
    Xz,
    /// Along x.
    Yz,
    /// From where the user turned it, see [`PlaneAxes::turned`].
    Free,
}

/// The two directions of a plane, of length 1 and at right angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneAxes {
    /// To the right.
    pub right: Vector3<f64>,
    /// Up.
    pub up: Vector3<f64>,
}

impl Projection {
    /// All projections, in the order of a picker.
    pub const ALL: [Self; 5] = [Self::Principal, Self::Xy, Self::Xz, Self::Yz, Self::Free];

    /// Name, labels of the two axes, and the axes unless they follow from the cameras' places.
    fn about(self) -> (&'static str, [&'static str; 2], Option<[Vector3<f64>; 2]>) {
        match self {
            Self::Principal => ("Principal plane", ["along the way", "across it"], None),
            Self::Xy => ("x, y", ["x", "y"], Some([Vector3::x(), Vector3::y()])),
            Self::Xz => ("x, z", ["x", "z"], Some([Vector3::x(), Vector3::z()])),
            Self::Yz => ("y, z", ["y", "z"], Some([Vector3::y(), Vector3::z()])),
            Self::Free => ("Free view", ["", ""], None),
        }
    }

    /// Name for the user.
    pub fn name(self) -> &'static str {
        self.about().0
    }

    /// Labels of the two axes.
    pub fn axis_names(self) -> [&'static str; 2] {
        self.about().1
    }

    /// The plane's axes. `cameras` matter only for the principal plane, and for the free view, which begins as they look.
    pub fn axes(self, cameras: &[Isometry3<f64>]) -> PlaneAxes {
        match self.about().2 {
            Some([right, up]) => PlaneAxes { right, up },
            None if self == Self::Free => upright_axes(cameras),
            None => principal_axes(cameras),
        }
    }
}

impl PlaneAxes {
    /// (right, up) of a point in space, in the same unit.
    pub fn project(&self, centre: [f64; 3]) -> [f64; 2] {
        let place = Vector3::from(centre);
        [self.right.dot(&place), self.up.dot(&place)]
    }

    /// Direction away from the viewer.
    pub fn ahead(&self) -> Vector3<f64> {
        self.up.cross(&self.right)
    }

    /// The axes after the viewer went around by `around` to the right, about the axis up, and then higher by `above`,
    /// degrees.
    pub fn turned(self, around: f64, above: f64) -> Self {
        let about = |axis: Vector3<f64>, degrees: f64| Rotation3::new(axis * degrees.to_radians());
        let right = about(self.up, around) * self.right;
        Self { right, up: about(right, -above) * self.up }
    }
}

/// The mean directions to the right and up in the pictures of the cameras.
fn upright_axes(cameras: &[Isometry3<f64>]) -> PlaneAxes {
    let mean = |axis: Vector3<f64>| cameras.iter().map(|camera| camera.rotation * axis).sum::<Vector3<f64>>();
    let least = 1e-3 * cameras.len().max(1) as f64;
    // The picture's v points down. Cameras that look in all directions have no mean one.
    let up = (-mean(Vector3::y())).try_normalize(least).unwrap_or(Vector3::y());
    let across = |axis: Vector3<f64>| (axis - up * up.dot(&axis)).try_normalize(least);
    let any = [mean(Vector3::x()), Vector3::x() / 1e-3, Vector3::z() / 1e-3].into_iter().find_map(across);
    PlaneAxes { right: any.unwrap_or(Vector3::x()), up }
}

/// The two directions in which the centres spread most, each to the side of its largest coordinate.
fn principal_axes(cameras: &[Isometry3<f64>]) -> PlaneAxes {
    let mean = Spread::of(cameras).mean;
    let covariance: Matrix3<f64> = cameras.iter().map(|c| c.translation.vector - mean).map(|d| d * d.transpose()).sum();
    let scale = covariance.amax();
    // Cameras in one place have no plane of their own.
    if !(scale.is_finite() && scale > 0.0) {
        return PlaneAxes { right: Vector3::x(), up: Vector3::y() };
    }
    let eigen = (covariance / scale).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axis = |k: usize| {
        let axis: Vector3<f64> = eigen.eigenvectors.column(order[k]).into();
        if axis[axis.iamax()] < 0.0 { -axis } else { axis }
    };
    PlaneAxes { right: axis(0), up: axis(1) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    fn pose(centre: [f64; 3], axis_angle: [f64; 3]) -> Isometry3<f64> {
        Isometry3::new(Vector3::from(centre), Vector3::from(axis_angle))
    }

    #[test]
    fn a_mirrored_estimate_is_not_laid_on_by_a_mirror() {
        let centres = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let truth = centres.map(|c| pose(c, [0.0; 3]));
        let mirror = centres.map(|[x, y, z]| pose([-x, y, z], [0.0; 3]));
        let Alignment { straight, truth_from_estimate } = align(&mirror, &truth).expect("aligned");
        let rotation = truth_from_estimate.rotation;
        assert!(!straight && (rotation.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn cameras_on_a_rail_are_turned_about_it_by_where_they_look() {
        // The cameras look along the world's y; the estimate's world is turned by 1.1 about the rail.
        let roll = UnitQuaternion::new(Vector3::x() * 1.1);
        let looks = UnitQuaternion::new(Vector3::new(-FRAC_PI_2, 0.0, 0.0));
        let truth = [0.0, 1.0, 2.5].map(|x| Isometry3::from_parts(Translation3::new(x, 0.0, 0.0), looks));
        let estimate = truth.map(|t| Isometry3::from_parts(t.translation, roll * t.rotation));
        let alignment = align(&estimate, &truth).expect("aligned");
        assert!(alignment.straight);
        for (e, t) in estimate.iter().zip(&truth) {
            let laid = alignment.truth_from_estimate.apply(e);
            assert!((laid.translation.vector - t.translation.vector).norm() < 1e-12);
            assert!(laid.rotation.angle_to(&t.rotation) < 1e-7);
        }
    }

    #[test]
    fn what_cannot_be_aligned_says_why() {
        let here = pose([1.0, 2.0, 3.0], [0.0; 3]);
        let there = pose([4.0, 2.0, 3.0], [0.0; 3]);
        let words = |estimate: &[_], truth: &[_]| align(estimate, truth).expect_err("degenerate").to_string();
        assert!(words(&[here], &[here]).contains("two or more"));
        assert!(words(&[here, here], &[here, there]).contains("estimated cameras all stand in one place"));
        assert!(words(&[here, there], &[here, here]).contains("true cameras all stand in one place"));
        // One trajectory goes back and forth twice while the other goes once.
        let line = |xs: [f64; 4]| xs.map(|x| pose([x, 0.0, 0.0], [0.0; 3]));
        assert!(words(&line([-1.0, 1.0, -1.0, 1.0]), &line([-1.0, -1.0, 1.0, 1.0])).contains("independently"));
    }

    proptest! {
        #[test]
        fn any_similarity_is_found_again(
            centres in prop::collection::vec(prop::array::uniform3(-10.0f64..10.0), 3..12),
            turns in prop::array::uniform3(-3.0f64..3.0),
            move_by in prop::array::uniform3(-100.0f64..100.0),
            scale in 0.01f64..100.0,
        ) {
            let truth: Vec<_> = centres.iter().map(|&c| pose(c, [c[1] * 0.1, c[0] * 0.2, c[2] * 0.1])).collect();
            let rotation = UnitQuaternion::new(Vector3::from(turns) * 0.6);
            let there = Similarity { scale, rotation, translation: Vector3::from(move_by) };
            let estimate: Vec<_> = truth.iter().map(|t| there.apply(t)).collect();
            let spread = Spread::of(&truth);
            prop_assume!(spread.variance > 1e-3);
            let alignment = align(&estimate, &truth).expect("aligned");
            for (e, t) in estimate.iter().zip(&truth) {
                let laid = alignment.truth_from_estimate.apply(e);
                prop_assert!((laid.translation.vector - t.translation.vector).norm() < 1e-6, "{alignment:?}");
                prop_assert!(laid.rotation.angle_to(&t.rotation) < 1e-4, "{alignment:?}");
            }
        }
    }

    #[test]
    fn the_principal_plane_shows_the_way() {
        // Along (−1, 0, −1) mostly, then along y.
        let centres = (0..9).map(|k| k as f64).map(|k| [-k, 0.1 * (k - 4.0).powi(2), -k]);
        let axes = Projection::Principal.axes(&centres.map(|centre| pose(centre, [0.0; 3])).collect::<Vec<_>>());
        let half = 0.5f64.sqrt();
        assert!((axes.right - Vector3::new(half, 0.0, half)).norm() < 1e-9, "{axes:?}");
        assert!((axes.up - Vector3::y()).norm() < 1e-9);
        assert!((axes.project([-1.0, 2.0, -1.0])[0] + 2.0f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_free_view_begins_as_the_cameras_look_and_goes_around() {
        // The cameras look along −z: a half turn about y puts x to the left in the world.
        let cameras = [0.0, 1.0].map(|x| pose([x, 0.0, 0.0], [0.0, 2.0 * FRAC_PI_2, 0.0]));
        let axes = Projection::Free.axes(&cameras);
        let near = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() < 1e-9;
        assert!(near(axes.right, -Vector3::x()) && near(axes.up, -Vector3::y()) && near(axes.ahead(), -Vector3::z()));
        // From the right the viewer looks to the left; from above it looks down.
        assert!(near(axes.turned(90.0, 0.0).ahead(), -axes.right));
        assert!(near(axes.turned(0.0, 90.0).ahead(), -axes.up) && near(axes.turned(0.0, 90.0).up, axes.ahead()));
    }

    proptest! {
        #[test]
        fn axes_are_of_length_one_and_at_right_angles(centres in prop::collection::vec(prop::array::uniform3(-1e6f64..1e6), 0..9)) {
            let cameras: Vec<_> = centres.iter().map(|&c| pose(c, c)).collect();
            for projection in [Projection::Principal, Projection::Free] {
                let PlaneAxes { right, up } = projection.axes(&cameras).turned(30.0, 20.0);
                prop_assert!((right.norm() - 1.0).abs() < 1e-9 && (up.norm() - 1.0).abs() < 1e-9 && right.dot(&up).abs() < 1e-9);
            }
        }
    }
}
