//! The relative pose of two cameras, from the essential matrix.
//!
//! `E = [t]×·R` has four solutions: two rotations, and both signs of the translation. Only in one of them do points lie
//! in front of both cameras (Hartley and Zisserman, "Multiple View Geometry", 2nd ed., 9.6.2; the decomposition here is
//! Horn's, "Recovering Baseline and Orientation from 'Essential' Matrix", 1990, which needs no singular values).

use super::linear::cross_matrix;
use super::points::RayPair;
use nalgebra::{Matrix3, Vector3};

/// Pose of camera B relative to camera A: a point X in A's frame is at R·X + t in B's. The length of t is unknown and
/// set to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativePose {
    /// Rotation R, from A's frame to B's.
    pub rotation: Matrix3<f64>,
    /// Translation t, of length 1, in B's frame.
    pub translation: Vector3<f64>,
}

impl RelativePose {
    /// The essential matrix `E = [t]×·R`.
    pub fn essential(&self) -> Matrix3<f64> {
        cross_matrix(&self.translation) * self.rotation
    }

    /// The angle of the rotation, radians, 0 … π.
    pub fn rotation_angle(&self) -> f64 {
        angle_of(&self.rotation)
    }

    /// The depths, along A's and B's axes, at which the two rays in the directions (x, y, 1) of `pair` come closest.
    /// `None` for parallel directions.
    fn depths(&self, pair: &RayPair) -> Option<(f64, f64)> {
        // depth_b·d_b = depth_a·R·d_a + t, by least squares.
        let (a, b) = (self.rotation * pair.a_homogeneous(), pair.b_homogeneous());
        let (aa, ab, bb) = (a.norm_squared(), a.dot(&b), b.norm_squared());
        let (at, bt) = (a.dot(&self.translation), b.dot(&self.translation));
        let determinant = aa * bb - ab * ab;
        // Directions less than 10⁻⁵ rad apart do not determine a depth.
        (determinant > 1e-10 * aa * bb).then(|| ((ab * bt - bb * at) / determinant, (aa * bt - ab * at) / determinant))
    }

    /// Whether the point seen in these directions is in front of both cameras.
    fn is_in_front(&self, pair: &RayPair) -> bool {
        self.depths(pair).is_some_and(|(in_a, in_b)| in_a > 0.0 && in_b > 0.0)
    }
}

/// The angle of a rotation, radians.
fn angle_of(rotation: &Matrix3<f64>) -> f64 {
    // From both sine and cosine: each alone is inexact at one of the ends.
    let r = rotation;
    let sine = Vector3::new(r.m32 - r.m23, r.m13 - r.m31, r.m21 - r.m12).norm();
    libm::atan2(sine, r.trace() - 1.0)
}

/// The four poses of an essential matrix, (R₁, t), (R₂, t), (R₁, −t), (R₂, −t); `None` for a degenerate matrix.
pub(super) fn poses_of(e: &Matrix3<f64>) -> Option<[RelativePose; 4]> {
    let (c0, c1, c2) = (e.column(0), e.column(1), e.column(2));
    // t is perpendicular to all columns.
    let crosses = [c0.cross(&c1), c1.cross(&c2), c2.cross(&c0)];
    let longest = crosses.into_iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
    let direction = longest.try_normalize(0.0)?;
    // |E|² = 2·|t|².
    let length = (0.5 * e.norm_squared()).sqrt();
    let rotation = |t: Vector3<f64>| {
        let cofactors = Matrix3::from_columns(&[c1.cross(&c2), c2.cross(&c0), c0.cross(&c1)]);
        let raw = (cofactors - cross_matrix(&t) * e) / (length * length);
        nearest_rotation(&raw)
    };
    let (first, second) = (rotation(direction * length)?, rotation(-direction * length)?);
    let pose = |rotation, translation| RelativePose { rotation, translation };
    Some([pose(first, direction), pose(second, direction), pose(first, -direction), pose(second, -direction)])
}

/// The rotation nearest to a matrix that is nearly one, by Newton's iteration for the polar decomposition.
fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let mut r = *matrix;
    for _ in 0..30 {
        let next = (r + r.try_inverse()?.transpose()) * 0.5;
        let change = (next - r).norm();
        r = next;
        if change < 1e-15 {
            break;
        }
    }
    (r.iter().all(|x| x.is_finite()) && r.determinant() > 0.0).then_some(r)
}

/// The pose of an essential matrix for which most of `pairs`, matched directions, lie in front of both cameras, and
/// their number.
pub(super) fn pose_in_front<'a>(
    e: &Matrix3<f64>,
    pairs: impl Iterator<Item = &'a RayPair> + Clone,
) -> Option<(RelativePose, usize)> {
    let counted = poses_of(e)?.map(|pose| (pose, pairs.clone().filter(|pair| pose.is_in_front(pair)).count()));
    // The first of several with equal numbers.
    counted.into_iter().reduce(|best, other| if other.1 > best.1 { other } else { best })
}
