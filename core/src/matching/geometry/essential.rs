//! The essential matrix E of two views with known intrinsics, and their relative pose, up to the translation's length.
//!
//! Directions d = (x, y, 1) satisfy d_bᵀ·E·d_a = 0 with E = `[t]×·R`. Five matches leave E = x·X + y·Y + z·Z + W, on
//! which det E = 0 and 2·E·Eᵀ·E = tr(E·Eᵀ)·E are ten cubic equations. Elimination leaves a polynomial of the tenth
//! degree in z (Nistér, "An Efficient Solution to the Five-Point Relative Pose Problem", PAMI 2004). More matches are
//! fitted by the Levenberg–Marquardt method over rotation and direction of translation, which also works for planes.
//! Errors are Sampson distances in pixels, by way of the focal lengths.
//!
//! Of the four poses of E one alone has points in front of both cameras (Hartley and Zisserman, "Multiple View
//! Geometry", 2nd ed., 9.6.2; the poses after Horn, "Recovering Baseline and Orientation from 'Essential' Matrix").

use super::linear::{epipolar_row, equation};
use super::points::{RayPair, Vector9, cross_matrix, matrix_of, null_space};
use super::{consensus::Problem, linear::real_roots};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use std::sync::LazyLock;

pub(super) struct EssentialProblem<'a> {
    /// Matched directions (x, y, 1).
    pub pairs: &'a [RayPair],
    /// Focal lengths (fx, fy) of image A, and of B, pixels.
    pub focal_px: [[f64; 2]; 2],
}

impl Problem for EssentialProblem<'_> {
    type Model = Matrix3<f64>;
    const SAMPLE_SIZE: usize = 5;

    fn solve(&self, sample: &[usize], models: &mut Vec<Matrix3<f64>>) {
        let mut equations: [[f64; 9]; 5] = std::array::from_fn(|i| epipolar_row(&self.pairs[sample[i]]));
        let Some(basis) = null_space::<4>(&mut equations) else { return };
        let Some(reduced) = eliminated(&basis) else { return };
        let rows = polynomial_rows(&reduced);
        models.extend(real_roots(&determinant(&rows)).into_iter().filter_map(|z| solution(&rows, &basis, z)));
    }

    fn squared_errors(&self, model: &Matrix3<f64>) -> impl Iterator<Item = f64> {
        self.pairs.iter().map(move |pair| {
            let (value, squared_gradient) = equation(model, pair, self.focal_px);
            if squared_gradient > 0.0 { value * value / squared_gradient } else { f64::INFINITY }
        })
    }

    const IS_DAMPED: bool = true;

    fn refit(&self, model: &Matrix3<f64>, weights: &[f64], damping: f64) -> Option<Matrix3<f64>> {
        // All four poses of E give the same E and the same derivatives.
        let pose = poses_of(model)?[0];
        let [along_1, along_2] = tangents(&pose.translation);
        let e = pose.essential();
        // Derivatives of E for rotations about each axis, and for moves of the translation.
        let turn = |axis| cross_matrix(&pose.translation) * cross_matrix(&axis) * pose.rotation;
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(turn);
        let changes = [x, y, z, cross_matrix(&along_1) * pose.rotation, cross_matrix(&along_2) * pose.rotation];
        let mut normal = SMatrix::<f64, 5, 5>::zeros();
        let mut right = SVector::<f64, 5>::zeros();
        let mut used = 0;
        for (pair, &weight) in self.pairs.iter().zip(weights) {
            let (value, squared_gradient) = equation(&e, pair, self.focal_px);
            if weight > 0.0 && squared_gradient > 0.0 {
                let (a, b) = (pair.a_homogeneous(), pair.b_homogeneous());
                let slopes = SVector::<f64, 5>::from(changes.map(|change| b.dot(&(change * a))));
                // Divided by its gradient, the equation's value is the Sampson distance.
                let weight = weight / squared_gradient;
                normal += slopes * slopes.transpose() * weight;
                right += slopes * (weight * value);
                used += 1;
            }
        }
        if used < 5 {
            return None;
        }
        // Levenberg–Marquardt damping: parameters that the matches hardly determine move least.
        let damped = normal + SMatrix::<f64, 5, 5>::identity() * (damping * normal.trace() / 5.0);
        let step = damped.cholesky()?.solve(&-right);
        // A small turn as a quaternion, which normalising makes a rotation again.
        let half = nalgebra::Quaternion::new(1.0, 0.5 * step[0], 0.5 * step[1], 0.5 * step[2]);
        let turn = nalgebra::UnitQuaternion::new_normalize(half);
        let rotation = turn.to_rotation_matrix().into_inner() * pose.rotation;
        let translation = (pose.translation + along_1 * step[3] + along_2 * step[4]).try_normalize(0.0)?;
        let e = RelativePose { rotation, translation }.essential();
        e.iter().all(|x| x.is_finite()).then_some(e)
    }
}

fn tangents(v: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let axis = if v.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let first = v.cross(&axis).normalize();
    [first, v.cross(&first)]
}

/// Monomials by the exponents of x, y and z, as digits; the first ten are eliminated.
const MONOMIALS: [usize; 20] = [300, 30, 210, 120, 201, 200, 21, 20, 111, 110, 102, 101, 100, 12, 11, 10, 3, 2, 1, 0];

/// Coefficients in the order of [`MONOMIALS`].
type Cubic = [f64; 20];

/// Index in [`MONOMIALS`] of the product of two of them; 20 beyond the third degree.
static PRODUCT: LazyLock<[[usize; 20]; 20]> = LazyLock::new(|| {
    let index = |exponents: usize| MONOMIALS.iter().position(|of| *of == exponents).unwrap_or(20);
    MONOMIALS.map(|p| MONOMIALS.map(|q| index(p + q)))
});

/// Indices of x, y, z and 1 in `MONOMIALS`.
const LINEAR: [usize; 4] = [12, 15, 18, 19];
/// Indices of the monomials up to the second degree.
const QUADRATIC: [usize; 10] = [5, 7, 9, 11, 12, 14, 15, 17, 18, 19];

/// Adds `factor` times the product of `p` (whose monomials are at `p_places`) and the linear `q` to `sum`.
fn add_product(sum: &mut Cubic, factor: f64, p: &Cubic, p_places: &[usize], q: &Cubic) {
    let product = &*PRODUCT;
    for &i in p_places {
        for j in LINEAR {
            sum[product[i][j]] += factor * p[i] * q[j];
        }
    }
}

/// The ten equations in reduced row echelon form: the coefficients of each in the last ten monomials.
fn eliminated(basis: &[Vector9; 4]) -> Option<[[f64; 10]; 10]> {
    // E's elements as linear polynomials.
    let mut e = [[[0.0; 20]; 3]; 3];
    for (place, vector) in LINEAR.iter().zip(basis) {
        for (index, value) in vector.iter().enumerate() {
            e[index / 3][index % 3][*place] = *value;
        }
    }
    // E·Eᵀ, symmetric, quadratic.
    let mut squares = [[[0.0; 20]; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            for (p, q) in e[i].iter().zip(&e[j]) {
                add_product(&mut squares[i][j], 1.0, p, &LINEAR, q);
            }
        }
    }
    // E·Eᵀ − ½·trace, so that the equations are its product with E.
    let half_trace: Cubic = std::array::from_fn(|m| 0.5 * (squares[0][0][m] + squares[1][1][m] + squares[2][2][m]));
    for (i, row) in squares.iter_mut().enumerate() {
        row[i].iter_mut().zip(&half_trace).for_each(|(x, t)| *x -= t);
    }
    let mut equations = [[0.0; 20]; 10];
    for i in 0..3 {
        for j in 0..3 {
            for (square, row) in squares[i].iter().zip(&e) {
                add_product(&mut equations[3 * i + j], 1.0, square, &QUADRATIC, &row[j]);
            }
        }
    }
    for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        let mut minor = [0.0; 20];
        add_product(&mut minor, 1.0, &e[1][j], &LINEAR, &e[2][k]);
        add_product(&mut minor, -1.0, &e[1][k], &LINEAR, &e[2][j]);
        add_product(&mut equations[9], 1.0, &minor, &QUADRATIC, &e[0][i]);
    }
    // Gauss–Jordan elimination; without a pivot the five matches are degenerate.
    for step in 0..10 {
        let pivot = (step..10).max_by(|&i, &j| equations[i][step].abs().total_cmp(&equations[j][step].abs()))?;
        equations.swap(step, pivot);
        let lead = equations[step][step];
        if lead.abs() <= 1e-14 || lead.is_nan() {
            return None;
        }
        equations[step].iter_mut().for_each(|x| *x /= lead);
        let row = equations[step];
        for (other, values) in equations.iter_mut().enumerate() {
            let factor = values[step];
            if other != step && factor != 0.0 {
                values.iter_mut().zip(&row).for_each(|(x, r)| *x -= factor * r);
            }
        }
    }
    Some(equations.map(|row| std::array::from_fn(|m| row[10 + m])))
}

/// Coefficients of a polynomial in z of at most the tenth degree, the constant first.
type InZ = [f64; 11];

/// Equations b₀(z)·x + b₁(z)·y + b₂(z) = 0: for m = x², y², xy the row led by m·z less z times the row led by m.
fn polynomial_rows(reduced: &[[f64; 10]; 10]) -> [[InZ; 3]; 3] {
    [(4, 5), (6, 7), (8, 9)].map(|(with_z, without)| {
        let (p, q) = (&reduced[with_z], &reduced[without]);
        // The columns are x·(z², z, 1), y·(z², z, 1), (z³, z², z, 1).
        [(0, 3), (3, 3), (6, 4)].map(|(start, terms)| {
            let mut polynomial = [0.0; 11];
            for power in 0..terms {
                let column = start + terms - 1 - power;
                polynomial[power] += p[column];
                polynomial[power + 1] -= q[column];
            }
            polynomial
        })
    })
}

/// The product `p`·`q` without terms beyond the tenth degree, which are 0 here.
fn product(p: &InZ, q: &InZ) -> InZ {
    let mut out = [0.0; 11];
    for (i, x) in p.iter().enumerate() {
        for (j, y) in q.iter().enumerate().take(11 - i) {
            out[i + j] += x * y;
        }
    }
    out
}

fn determinant(rows: &[[InZ; 3]; 3]) -> InZ {
    let mut sum = [0.0; 11];
    for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        let (first, second) = (product(&rows[1][j], &rows[2][k]), product(&rows[1][k], &rows[2][j]));
        let minor: InZ = std::array::from_fn(|m| first[m] - second[m]);
        let term = product(&rows[0][i], &minor);
        sum.iter_mut().zip(&term).for_each(|(s, t)| *s += t);
    }
    sum
}

/// The essential matrix of a root `z`: x and y come from the null vector of the equations at z.
fn solution(rows: &[[InZ; 3]; 3], basis: &[Vector9; 4], z: f64) -> Option<Matrix3<f64>> {
    let at_z = |p: &InZ| p.iter().rev().fold(0.0, |sum, c| sum * z + c);
    let vectors = rows.each_ref().map(|row| Vector3::from(row.each_ref().map(at_z)));
    // The null vector is perpendicular to all rows; the longest cross product of two is the most exact.
    let crosses = [vectors[0].cross(&vectors[1]), vectors[1].cross(&vectors[2]), vectors[2].cross(&vectors[0])];
    let null = crosses.into_iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
    let (x, y) = (null.x / null.z, null.y / null.z);
    let e = basis[0] * x + basis[1] * y + basis[2] * z + basis[3];
    let norm = e.norm();
    (norm.is_finite() && norm > 0.0).then(|| matrix_of(&(e / norm)))
}

/// Pose of camera B relative to camera A: a point X in A's frame is at R·X + t in B's; t has the length 1.
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

    /// The depths along both axes at which the rays of `pair` come closest. `None` for parallel directions.
    pub(super) fn depths(&self, pair: &RayPair) -> Option<(f64, f64)> {
        // depth_b·d_b = depth_a·R·d_a + t, by least squares.
        let (a, b) = (self.rotation * pair.a_homogeneous(), pair.b_homogeneous());
        let (aa, ab, bb) = (a.norm_squared(), a.dot(&b), b.norm_squared());
        let (at, bt) = (a.dot(&self.translation), b.dot(&self.translation));
        let determinant = aa * bb - ab * ab;
        // Directions less than 10⁻⁵ rad apart do not determine a depth.
        (determinant > 1e-10 * aa * bb).then(|| ((ab * bt - bb * at) / determinant, (aa * bt - ab * at) / determinant))
    }
}

/// The four poses of an essential matrix, (R₁, t), (R₂, t), (R₁, −t), (R₂, −t); `None` for a degenerate matrix.
fn poses_of(e: &Matrix3<f64>) -> Option<[RelativePose; 4]> {
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

fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let mut r = *matrix;
    // The mean of a matrix and its inverse transposed converges to the nearest rotation.
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

/// The pose for which most of `pairs`, matched directions, lie in front of both cameras, and their number.
pub(super) fn pose_in_front<'a>(
    e: &Matrix3<f64>,
    pairs: impl Iterator<Item = &'a RayPair> + Clone,
) -> Option<(RelativePose, usize)> {
    let is_in_front =
        |pose: &RelativePose, pair: &RayPair| pose.depths(pair).is_some_and(|(in_a, in_b)| in_a > 0.0 && in_b > 0.0);
    let counted = poses_of(e)?.map(|pose| (pose, pairs.clone().filter(|pair| is_in_front(&pose, pair)).count()));
    // The first of several with equal numbers.
    counted.into_iter().reduce(|best, other| if other.1 > best.1 { other } else { best })
}
