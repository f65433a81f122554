//! Trajectories projected to a plane, for drawing.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

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
    pub const ALL: [Self; 4] = [Self::Principal, Self::Xy, Self::Xz, Self::Yz];

    /// Name for the user.
    pub fn name(self) -> &'static str {
        match self {
            Self::Principal => "Principal plane",
            Self::Xy => "x, y",
            Self::Xz => "x, z",
            Self::Yz => "y, z",
        }
    }

    /// Labels of the two axes.
    pub fn axis_names(self) -> [&'static str; 2] {
        match self {
            Self::Principal => ["along the way", "across it"],
            Self::Xy => ["x", "y"],
            Self::Xz => ["x", "z"],
            Self::Yz => ["y", "z"],
        }
    }

    /// The plane's axes. `centres` matter only for the principal plane.
    pub fn axes(self, centres: &[[f64; 3]]) -> PlaneAxes {
        let plane = |right: Vector3<f64>, up: Vector3<f64>| PlaneAxes { right, up };
        match self {
            Self::Principal => principal_axes(centres),
            Self::Xy => plane(Vector3::x(), Vector3::y()),
            Self::Xz => plane(Vector3::x(), Vector3::z()),
            Self::Yz => plane(Vector3::y(), Vector3::z()),
        }
    }
}

impl PlaneAxes {
    /// (right, up) of a point in space, in the same unit.
    pub fn project(&self, centre: [f64; 3]) -> [f64; 2] {
        let place = Vector3::from(centre);
        [self.right.dot(&place), self.up.dot(&place)]
    }
}

/// The two directions in which the centres spread most. Each points to the side of its largest coordinate, so that the
/// same centres give the same picture.
fn principal_axes(centres: &[[f64; 3]]) -> PlaneAxes {
    let n = centres.len().max(1) as f64;
    let mean = centres.iter().map(|c| Vector3::from(*c)).sum::<Vector3<f64>>() / n;
    let covariance: Matrix3<f64> = centres.iter().map(|c| Vector3::from(*c) - mean).map(|d| d * d.transpose()).sum();
    let scale = covariance.amax();
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

    #[test]
    fn the_principal_plane_shows_the_way() {
        // Along (−1, 0, −1) mostly, then along y.
        let centres: Vec<[f64; 3]> = (0..9).map(|k| k as f64).map(|k| [-k, 0.1 * (k - 4.0).powi(2), -k]).collect();
        let axes = Projection::Principal.axes(&centres);
        let half = 0.5f64.sqrt();
        assert!((axes.right - Vector3::new(half, 0.0, half)).norm() < 1e-9, "{axes:?}");
        assert!((axes.up - Vector3::y()).norm() < 1e-9);
        assert!((axes.project([-1.0, 2.0, -1.0])[0] + 2.0f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn planes_along_the_axes_take_two_coordinates() {
        let place = [1.0, 2.0, 3.0];
        let projected = Projection::ALL.map(|p| p.axes(&[]).project(place));
        assert_eq!(projected, [[1.0, 2.0], [1.0, 2.0], [1.0, 3.0], [2.0, 3.0]]);
    }

    proptest! {
        #[test]
        fn axes_are_of_length_one_and_at_right_angles(centres in prop::collection::vec(prop::array::uniform3(-1e6f64..1e6), 0..9)) {
            let PlaneAxes { right, up } = Projection::Principal.axes(&centres);
            prop_assert!((right.norm() - 1.0).abs() < 1e-9 && (up.norm() - 1.0).abs() < 1e-9 && right.dot(&up).abs() < 1e-9);
        }
    }
}
