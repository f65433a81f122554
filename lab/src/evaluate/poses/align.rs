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
    pub fn about(self) -> (&'static str, [&'static str; 2], Option<[Vector3<f64>; 2]>) {
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

    /// The plane's axes. `cameras` matter only for the principal plane, and a free view, which begins as they look.
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

    /// The axes after the viewer went `around` to the right, about the axis up, and then higher by `above`, degrees.
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
