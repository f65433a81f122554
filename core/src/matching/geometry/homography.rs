//! The homography H: maps each point of image A to one of image B, where the scene is a plane or the camera only
//! turned.
//!
//! x_b ~ H·x_a. Four matches determine it by the direct linear transform; more are fitted by the same equations, each
//! divided by the depth under the previous estimate, which makes the algebraic error the distance in the image (Hartley
//! and Zisserman, "Multiple View Geometry", 2nd ed., 4.1 and 4.2). The error of a match is the symmetric transfer
//! error: the root mean square of the distances in both images.

use super::consensus::Problem;
use super::linear::{Vector9, matrix_of, min_eigenvector, null_space};
use super::points::RayPair;
use nalgebra::{Matrix3, SMatrix};

/// A homography and its inverse, with signs that put matches in front of the camera.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Homography {
    /// From A to B.
    pub forward: Matrix3<f64>,
    /// From B to A.
    pub backward: Matrix3<f64>,
}

impl Homography {
    /// The matrix with the sign for which most of `pairs` are mapped to positive third coordinates; `None` for a matrix
    /// that has no inverse.
    pub(super) fn oriented<'a>(h: &Matrix3<f64>, pairs: impl Iterator<Item = &'a RayPair>) -> Option<Self> {
        let depth = |p: &RayPair| h.m31 * p.a[0] + h.m32 * p.a[1] + h.m33;
        let sign: f64 = pairs.map(|p| if depth(p) < 0.0 { -1.0 } else { 1.0 }).sum();
        let norm = h.norm();
        let forward = h * (if sign < 0.0 { -1.0 } else { 1.0 } / norm);
        // The determinant of a matrix of norm 1 is at most 0.19; below this the plane is seen edge-on.
        let determinant = forward.determinant();
        if !(norm > 0.0 && determinant.abs() > 1e-9) {
            return None;
        }
        // A point that is mapped with a positive third coordinate w comes back with 1/w, so the inverse has the right
        // sign too.
        Some(Self { forward, backward: forward.try_inverse()? })
    }
}

/// The image of a point under `h`; `None` for a point behind the camera or at infinity.
pub(super) fn mapped(h: &Matrix3<f64>, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
    let w = h.m31 * x + h.m32 * y + h.m33;
    (w > 0.0).then(|| [(h.m11 * x + h.m12 * y + h.m13) / w, (h.m21 * x + h.m22 * y + h.m23) / w])
}

/// The squared symmetric transfer error: the mean of the squared distances in A and in B. Infinite behind the cameras.
pub(super) fn squared_error(h: &Homography, pair: &RayPair) -> f64 {
    let (Some(in_b), Some(in_a)) = (mapped(&h.forward, pair.a), mapped(&h.backward, pair.b)) else {
        return f64::INFINITY;
    };
    let squared = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]);
    0.5 * (squared(in_b, pair.b) + squared(in_a, pair.a))
}

/// Estimation of H from matches in normalised coordinates.
pub(super) struct HomographyProblem<'a> {
    pub pairs: &'a [RayPair],
}

impl Problem for HomographyProblem<'_> {
    type Model = Homography;
    const SAMPLE_SIZE: usize = 4;

    fn count(&self) -> usize {
        self.pairs.len()
    }

    fn solve(&self, sample: &[usize], models: &mut Vec<Homography>) {
        let pairs: [&RayPair; 4] = std::array::from_fn(|i| &self.pairs[sample[i]]);
        if !keeps_orientation(&pairs) {
            return;
        }
        let mut rows = [[0.0; 9]; 8];
        for (two, pair) in rows.chunks_exact_mut(2).zip(pairs) {
            two.copy_from_slice(&transfer_rows(pair));
        }
        let Some([h]) = null_space::<1>(&mut rows) else { return };
        models.extend(Homography::oriented(&matrix_of(&h), pairs.into_iter()));
    }

    fn squared_error(&self, model: &Homography, index: usize) -> f64 {
        squared_error(model, &self.pairs[index])
    }

    fn refit(&self, model: &Homography, weights: &[f64], _: f64) -> Option<Homography> {
        let mut normal = SMatrix::<f64, 9, 9>::zeros();
        let mut used = 0;
        let weighted = || self.pairs.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
        for (pair, &weight) in weighted() {
            let [x, y] = pair.a;
            let depth = model.forward.m31 * x + model.forward.m32 * y + model.forward.m33;
            if depth > 0.0 {
                for row in transfer_rows(pair).map(Vector9::from) {
                    normal.syger(weight / (depth * depth), &row, &row, 1.0);
                }
                used += 1;
            }
        }
        if used < 4 {
            return None;
        }
        normal.fill_upper_triangle_with_lower_triangle();
        Homography::oriented(&matrix_of(&min_eigenvector(&normal)?), weighted().map(|(pair, _)| pair))
    }
}

/// Coefficients of H's elements, row by row, in the two equations of a match; each equation is the transfer's error in
/// u or v times its depth.
fn transfer_rows(pair: &RayPair) -> [[f64; 9]; 2] {
    let ([x, y], [u, v]) = (pair.a, pair.b);
    [[-x, -y, -1.0, 0.0, 0.0, 0.0, u * x, u * y, u], [0.0, 0.0, 0.0, -x, -y, -1.0, v * x, v * y, v]]
}

/// Whether any three of the four points turn the same way in both images, and no three lie on a line. Planes in front
/// of both cameras can be seen mirrored, from behind; then all turns are reversed.
fn keeps_orientation(pairs: &[&RayPair; 4]) -> bool {
    let turn = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let mut sign = 0.0;
    for [i, j, k] in [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]] {
        let in_a = turn(pairs[i].a, pairs[j].a, pairs[k].a);
        let in_b = turn(pairs[i].b, pairs[j].b, pairs[k].b);
        // In normalised coordinates points are about 1 apart: these are triangles far thinner than a pixel.
        if in_a.abs() < 1e-6 || in_b.abs() < 1e-6 {
            return false;
        }
        let agree = (in_a * in_b).signum();
        if sign != 0.0 && agree != sign {
            return false;
        }
        sign = agree;
    }
    true
}
