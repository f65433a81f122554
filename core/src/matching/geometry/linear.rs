//! Models that linear equations of the matches give: the fundamental matrix, and the homography.
//!
//! The fundamental matrix F: x_bᵀ·F·x_a = 0 for unknown cameras. Seven matches leave a line of matrices, on which det F
//! = 0 has up to three solutions (Hartley and Zisserman, "Multiple View Geometry", 2nd ed., 11.1.2). More are fitted by
//! the eight-point algorithm (Hartley, "In Defense of the Eight-Point Algorithm", PAMI 1997) with each match divided by
//! the gradient of its equation: the algebraic error is then the Sampson distance.
//!
//! Two causes of wrong solutions are checked: points on different sides of the epipoles, behind a camera (Chum, Werner
//! and Matas, "Epipolar Geometry Estimation via Oriented Epipolar Constraints", ICPR 2004); and a dominant plane, whose
//! homography with two points off it may give a better matrix ("Two-View Geometry Estimation Unaffected by a Dominant
//! Plane", CVPR 2005, by the same authors; here the plane is searched among all inliers).
//!
//! The homography H, for a plane or a camera that only turned: x_b ~ H·x_a, by the direct linear transform from four
//! matches or more, each divided by its depth under the previous estimate (Hartley and Zisserman, 4.1 and 4.2).

use super::consensus::{Loss, Problem, Sampler};
use super::points::{RayPair, Vector9, cross_matrix, matrix_of, min_eigenvector, null_space, null_vector};
use nalgebra::{Matrix3, SMatrix};
use polycool::PolyDyn;

pub(super) struct FundamentalProblem<'a> {
    pub pairs: &'a [RayPair],
}

/// Samples of four inliers in the search for a plane: one that holds half of them is missed once in 600 times.
const PLANE_ITERATIONS: usize = 100;
const PARALLAX_ITERATIONS: usize = 300;

impl Problem for FundamentalProblem<'_> {
    type Model = Matrix3<f64>;
    const SAMPLE_SIZE: usize = 7;

    fn solve(&self, sample: &[usize], models: &mut Vec<Matrix3<f64>>) {
        let pairs: [&RayPair; 7] = std::array::from_fn(|i| &self.pairs[sample[i]]);
        models.extend(from_seven(&pairs).into_iter().filter(|f| is_oriented(f, &pairs)));
    }

    fn squared_errors(&self, model: &Matrix3<f64>) -> impl Iterator<Item = f64> {
        self.pairs.iter().map(move |pair| sampson_squared(model, pair))
    }

    fn refit(&self, model: &Matrix3<f64>, weights: &[f64], _: f64) -> Option<Matrix3<f64>> {
        let mut normal = SMatrix::<f64, 9, 9>::zeros();
        let mut used = 0;
        for (pair, &weight) in self.pairs.iter().zip(weights) {
            let (_, gradient) = equation(model, pair, [[1.0; 2]; 2]);
            if weight > 0.0 && gradient > 0.0 {
                let row = Vector9::from(epipolar_row(pair));
                normal.syger(weight / gradient, &row, &row, 1.0);
                used += 1;
            }
        }
        if used < 8 {
            return None;
        }
        normal.fill_upper_triangle_with_lower_triangle();
        // A linear fit has no rank of its own: it is made 2 afterwards.
        of_rank_two(&matrix_of(&min_eigenvector(&normal)?))
    }

    fn repair(&self, model: &Matrix3<f64>, loss: &Loss, sampler: &mut Sampler) -> Option<Matrix3<f64>> {
        let plane = self.dominant_plane(model, loss, sampler)?;
        let is_off_plane = |pair: &&RayPair| !loss.is_inlier(squared_error(&plane, pair));
        let off_plane: Vec<&RayPair> = self.pairs.iter().filter(is_off_plane).collect();
        if off_plane.len() < 2 {
            return None;
        }
        let mut best: Option<(Matrix3<f64>, f64)> = None;
        for _ in 0..PARALLAX_ITERATIONS {
            let [first, second] = [0, 1].map(|_| off_plane[sampler.below(off_plane.len())]);
            let Some(f) = from_plane_and_parallax(&plane.forward, first, second) else { continue };
            // Points on the plane fit each of these matrices.
            let cost: f64 = off_plane.iter().map(|pair| loss.cost(sampson_squared(&f, pair))).sum();
            if best.is_none_or(|(_, min)| cost < min) {
                best = Some((f, cost));
            }
        }
        best.map(|(f, _)| f)
    }
}

impl FundamentalProblem<'_> {
    /// The homography of a plane that holds at least half of the model's inliers.
    fn dominant_plane(&self, model: &Matrix3<f64>, loss: &Loss, sampler: &mut Sampler) -> Option<Homography> {
        let inliers: Vec<RayPair> =
            self.pairs.iter().filter(|pair| loss.is_inlier(sampson_squared(model, pair))).copied().collect();
        if inliers.len() < 4 {
            return None;
        }
        let problem = HomographyProblem { pairs: &inliers };
        let cost = |h: &Homography| -> f64 { inliers.iter().map(|pair| loss.cost(squared_error(h, pair))).sum() };
        // Drawn from the model's inliers, of which a dominant plane holds most.
        let mut models = Vec::new();
        for _ in 0..PLANE_ITERATIONS {
            problem.solve(&[0; 4].map(|_| sampler.below(inliers.len())), &mut models);
        }
        let mut plane = models.into_iter().map(|h| (cost(&h), h)).min_by(|a, b| a.0.total_cmp(&b.0))?.1;
        for _ in 0..3 {
            let weights: Vec<f64> = inliers.iter().map(|pair| loss.weight(squared_error(&plane, pair))).collect();
            plane = problem.refit(&plane, &weights, 0.0)?;
        }
        let on_plane = inliers.iter().filter(|pair| loss.is_inlier(squared_error(&plane, pair))).count();
        (2 * on_plane >= inliers.len()).then_some(plane)
    }
}

/// Coefficients of F's elements, row by row, in x_bᵀ·F·x_a.
pub(super) fn epipolar_row(pair: &RayPair) -> [f64; 9] {
    let ([x, y], [u, v]) = (pair.a, pair.b);
    [u * x, u * y, u, v * x, v * y, v, x, y, 1.0]
}

/// The squared Sampson distance; infinite at the epipoles.
pub(super) fn sampson_squared(f: &Matrix3<f64>, pair: &RayPair) -> f64 {
    let (value, gradient) = equation(f, pair, [[1.0; 2]; 2]);
    if gradient > 0.0 { value * value / gradient } else { f64::INFINITY }
}

/// x_bᵀ·F·x_a, and the squared length of its gradient by the coordinates in pixels, of which `px` make a unit.
#[inline(always)]
pub(super) fn equation(f: &Matrix3<f64>, pair: &RayPair, px: [[f64; 2]; 2]) -> (f64, f64) {
    let ([x, y], [u, v]) = (pair.a, pair.b);
    let in_b = [f.m11 * x + f.m12 * y + f.m13, f.m21 * x + f.m22 * y + f.m23];
    let in_a = [f.m11 * u + f.m21 * v + f.m31, f.m12 * u + f.m22 * v + f.m32];
    let value = u * in_b[0] + v * in_b[1] + f.m31 * x + f.m32 * y + f.m33;
    let gradient = [in_b[0] / px[1][0], in_b[1] / px[1][1], in_a[0] / px[0][0], in_a[1] / px[0][1]];
    (value, gradient.iter().map(|g| g * g).sum())
}

fn from_seven(pairs: &[&RayPair; 7]) -> Vec<Matrix3<f64>> {
    let Some([first, second]) = null_space::<2>(&mut pairs.map(epipolar_row)) else { return Vec::new() };
    let (first, second) = (matrix_of(&first), matrix_of(&second));
    // det(first + z·second), a cubic in z, from its values at four places.
    let determinant = |z: f64| (first + second * z).determinant();
    let (d0, d1, d2) = (determinant(0.0), determinant(1.0), determinant(-1.0));
    let d3 = second.determinant();
    let square = 0.5 * (d1 + d2) - d0;
    let linear = 0.5 * (d1 - d2) - d3;
    real_roots(&[d0, linear, square, d3]).into_iter().map(|z| (first + second * z).normalize()).collect()
}

/// Whether all points can be in front of both cameras: e_b × x_b and F·x_a then agree in sense for all or for none.
fn is_oriented(f: &Matrix3<f64>, pairs: &[&RayPair]) -> bool {
    let Some(epipole) = null_vector(&f.transpose()) else { return false };
    let side = |pair: &&RayPair| epipole.cross(&pair.b_homogeneous()).dot(&(f * pair.a_homogeneous()));
    let first = side(&pairs[0]);
    pairs.iter().all(|pair| side(pair) * first > 0.0)
}

/// The nearest matrix of rank 2, with elements whose squares sum to 1.
fn of_rank_two(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let v = null_vector(matrix)?;
    let f = matrix - matrix * v * v.transpose();
    let norm = f.norm();
    (norm > 0.0).then(|| f / norm)
}

/// The fundamental matrix of a plane's homography `h` and two matches off it, whose lines meet in the epipole.
fn from_plane_and_parallax(h: &Matrix3<f64>, first: &RayPair, second: &RayPair) -> Option<Matrix3<f64>> {
    let line = |pair: &RayPair| pair.b_homogeneous().cross(&(h * pair.a_homogeneous()));
    let epipole = line(first).cross(&line(second));
    let f = cross_matrix(&epipole) * h;
    let norm = f.norm();
    (norm.is_finite() && norm > 0.0).then(|| f / norm)
}

/// A homography from A to B and its inverse, with signs that put matches in front of the camera.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Homography {
    pub forward: Matrix3<f64>,
    pub backward: Matrix3<f64>,
}

impl Homography {
    /// With the sign for which most of `pairs` get positive third coordinates; `None` for a matrix that has no inverse.
    pub(super) fn oriented<'a>(h: &Matrix3<f64>, pairs: impl Iterator<Item = &'a RayPair>) -> Option<Self> {
        let depth = |p: &RayPair| h.m31 * p.a[0] + h.m32 * p.a[1] + h.m33;
        let sign: f64 = pairs.map(|p| if depth(p) < 0.0 { -1.0 } else { 1.0 }).sum();
        let norm = h.norm();
        let forward = h * (if sign < 0.0 { -1.0 } else { 1.0 } / norm);
        // The determinant of a matrix of norm 1 is at most 0.19; below this the plane is seen edge-on.
        if !(norm > 0.0 && forward.determinant().abs() > 1e-9) {
            return None;
        }
        // What is mapped with a third coordinate w comes back with 1/w: the inverse has the right sign too.
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

pub(super) struct HomographyProblem<'a> {
    pub pairs: &'a [RayPair],
}

impl Problem for HomographyProblem<'_> {
    type Model = Homography;
    const SAMPLE_SIZE: usize = 4;

    fn solve(&self, sample: &[usize], models: &mut Vec<Homography>) {
        let pairs: [&RayPair; 4] = std::array::from_fn(|i| &self.pairs[sample[i]]);
        // A cheap test before the solution, which many samples with outliers fail.
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

    fn squared_errors(&self, model: &Homography) -> impl Iterator<Item = f64> {
        self.pairs.iter().map(move |pair| squared_error(model, pair))
    }

    fn refit(&self, model: &Homography, weights: &[f64], _: f64) -> Option<Homography> {
        let mut normal = SMatrix::<f64, 9, 9>::zeros();
        let mut used = 0;
        let weighted = || self.pairs.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
        for (pair, &weight) in weighted() {
            let [x, y] = pair.a;
            // The algebraic error over the depth is the error in pixels.
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

/// Coefficients of H's elements in the two equations of a match: the transfer's error in u or v times its depth.
fn transfer_rows(pair: &RayPair) -> [[f64; 9]; 2] {
    let ([x, y], [u, v]) = (pair.a, pair.b);
    [[-x, -y, -1.0, 0.0, 0.0, 0.0, u * x, u * y, u], [0.0, 0.0, 0.0, -x, -y, -1.0, v * x, v * y, v]]
}

/// Whether all triples of the four points turn alike in both images, or all reversed (from behind); none on a line.
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

/// The real roots of Σ `coefficients[k]`·xᵏ, ascending; double ones may be missed. Empty for a constant, and where a
/// coefficient is not finite.
pub(super) fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    let largest = coefficients.iter().fold(0.0, |max: f64, c| max.max(c.abs()));
    if !(largest.is_finite() && largest > 0.0) || coefficients.iter().any(|c| c.is_nan()) {
        return Vec::new();
    }
    // A negligible leading coefficient would put a root near infinity.
    let degree = coefficients.iter().rposition(|c| c.abs() > 1e-14 * largest).unwrap_or(0);
    let (lower, leading) = (&coefficients[..degree], coefficients[degree]);
    // Cauchy's bound on the magnitude of the roots.
    let bound = 1.0 + lower.iter().fold(0.0, |max: f64, c| max.max((c / leading).abs()));
    // The roots of a cubic come from a division by the first one, which costs digits; a fourth degree's do not.
    let padding = (degree == 3).then_some(0.0);
    let scaled = coefficients[..=degree].iter().map(|c| c / largest);
    PolyDyn::new(scaled.chain(padding)).roots_between(-bound, bound, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn with_roots(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |c, r| {
            let mut product = vec![0.0; c.len() + 1];
            for (k, c) in c.iter().enumerate() {
                product[k + 1] += c;
                product[k] -= r * c;
            }
            product
        })
    }

    #[test]
    fn simple_cases() {
        let cases: [(&[f64], &[f64]); 8] = [
            (&[], &[]),
            (&[3.0], &[]),
            (&[0.0, 0.0], &[]),
            (&[f64::NAN, 1.0], &[]),
            (&[6.0, -2.0], &[3.0]),
            (&[1.0, 0.0, 1.0], &[]),
            (&[-4.0, 0.0, 1.0, 0.0, 0.0], &[-2.0, 2.0]),
            (&[0.0, 0.0, 0.0, 1.0], &[0.0]),
        ];
        for (coefficients, roots) in cases {
            assert_eq!(real_roots(coefficients), roots);
        }
    }

    proptest! {
        #[test]
        fn roots_that_are_apart_are_found(steps in prop::collection::vec(0.2f64..1.0, 1..10), start in -3.0f64..0.0, scale in 1e-6f64..1e6) {
            let roots: Vec<f64> = steps.iter().scan(start, |x, step| { *x += step; Some(*x) }).collect();
            let coefficients: Vec<f64> = with_roots(&roots).iter().map(|c| c * scale).collect();
            let found = real_roots(&coefficients);
            prop_assert_eq!(found.len(), roots.len(), "{:?} of {:?}", found, roots);
            for (x, root) in found.iter().zip(&roots) {
                prop_assert!((x - root).abs() < 1e-3, "{:?} of {:?}", found, roots);
            }
        }

        #[test]
        fn any_numbers_end(coefficients in prop::collection::vec(any::<f64>(), 0..12)) {
            prop_assert!(real_roots(&coefficients).len() <= 11);
        }
    }
}
