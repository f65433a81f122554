//! Matched points, the normalised coordinates in which models are estimated, and the solvers' small linear algebra.
//!
//! In pixels the terms of an epipolar equation differ by factors of 10⁵, and linear fits lose digits. So coordinates
//! are around the points' centre and of about unit size (Hartley, "In Defense of the Eight-Point Algorithm", PAMI
//! 1997), with one scale for both images, so that an error is one in pixels up to a factor.

use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, DimDiff, DimSub, Matrix3, OMatrix, OVector, SVector, SymmetricEigen, Vector3};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RayPair {
    pub a: [f64; 2],
    pub b: [f64; 2],
}

impl RayPair {
    pub(super) fn a_homogeneous(&self) -> Vector3<f64> {
        Vector3::new(self.a[0], self.a[1], 1.0)
    }

    pub(super) fn b_homogeneous(&self) -> Vector3<f64> {
        Vector3::new(self.b[0], self.b[1], 1.0)
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Normalisation {
    /// Normalised units per pixel.
    pub scale: f64,
    /// Normalised coordinates of pixels of A, and of B.
    pub to: [Matrix3<f64>; 2],
    /// The inverses of these.
    pub back: [Matrix3<f64>; 2],
}

impl Normalisation {
    /// Makes the centre of `pairs` 0 and their mean squared distance from it 2; and the normalised pairs.
    pub(super) fn of(pairs: &[RayPair]) -> (Self, Vec<RayPair>) {
        let count = pairs.len().max(1) as f64;
        let mean = |point: fn(&RayPair) -> [f64; 2]| {
            pairs.iter().map(point).fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]).map(|x| x / count)
        };
        let (centre_a, centre_b) = (mean(|p| p.a), mean(|p| p.b));
        let off = |p: [f64; 2], c: [f64; 2]| (p[0] - c[0]) * (p[0] - c[0]) + (p[1] - c[1]) * (p[1] - c[1]);
        let spread = pairs.iter().map(|p| off(p.a, centre_a) + off(p.b, centre_b)).sum::<f64>() / (2.0 * count);
        // Points that all coincide have no size.
        let scale = if spread > 0.0 { (2.0 / spread).sqrt() } else { 1.0 };
        let normal = |p: [f64; 2], c: [f64; 2]| [(p[0] - c[0]) * scale, (p[1] - c[1]) * scale];
        let pairs = pairs.iter().map(|pair| RayPair { a: normal(pair.a, centre_a), b: normal(pair.b, centre_b) });
        let (s, px) = (scale, 1.0 / scale);
        let to = |[x, y]: [f64; 2]| Matrix3::new(s, 0.0, -s * x, 0.0, s, -s * y, 0.0, 0.0, 1.0);
        let back = |[x, y]: [f64; 2]| Matrix3::new(px, 0.0, x, 0.0, px, y, 0.0, 0.0, 1.0);
        let centres = [centre_a, centre_b];
        (Self { scale, to: centres.map(to), back: centres.map(back) }, pairs.collect())
    }
}

pub(super) type Vector9 = SVector<f64, 9>;

pub(super) fn matrix_of(vector: &Vector9) -> Matrix3<f64> {
    Matrix3::from_row_iterator(vector.iter().copied())
}

/// An orthonormal basis of the vectors perpendicular to all `9 − D` rows; `None` for (nearly) dependent rows.
pub(super) fn null_space<const D: usize>(rows: &mut [[f64; 9]]) -> Option<[Vector9; D]> {
    let count = rows.len();
    debug_assert_eq!(count + D, 9, "each row takes away one dimension");
    let mut columns: [usize; 9] = std::array::from_fn(|i| i);
    let largest = rows.iter().flatten().fold(0.0f64, |max, x| max.max(x.abs()));
    // With full pivoting a small pivot shows that the rows are dependent.
    for step in 0..count {
        let (mut row, mut column, mut max) = (step, step, 0.0);
        for (r, values) in rows.iter().enumerate().skip(step) {
            for (c, &at) in columns.iter().enumerate().skip(step) {
                if values[at].abs() > max {
                    (row, column, max) = (r, c, values[at].abs());
                }
            }
        }
        // Also false for NaN.
        let is_independent = max > 1e-11 * largest;
        if !is_independent {
            return None;
        }
        rows.swap(step, row);
        columns.swap(step, column);
        let pivot = rows[step];
        for (r, values) in rows.iter_mut().enumerate() {
            let factor = values[columns[step]] / pivot[columns[step]];
            if r != step && factor != 0.0 {
                values.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= factor * p);
            }
        }
    }
    let mut basis = [Vector9::zeros(); D];
    for free in 0..D {
        let mut vector = Vector9::zeros();
        vector[columns[count + free]] = 1.0;
        for (step, values) in rows.iter().enumerate() {
            vector[columns[step]] = -values[columns[count + free]] / values[columns[step]];
        }
        // Twice, because once is inexact where vectors are nearly parallel.
        for _ in 0..2 {
            for earlier in &basis[..free] {
                vector -= earlier * earlier.dot(&vector);
            }
            vector /= vector.norm();
        }
        basis[free] = vector;
    }
    Some(basis)
}

/// The unit vector x that minimises xᵀ·`matrix`·x; `None` for a matrix that is not finite.
pub(super) fn min_eigenvector<D>(matrix: &OMatrix<f64, D, D>) -> Option<OVector<f64, D>>
where
    D: DimSub<Const<1>>,
    DefaultAllocator: Allocator<D, D> + Allocator<D> + Allocator<DimDiff<D, Const<1>>>,
{
    let matrix = Some(matrix).filter(|matrix| matrix.iter().all(|x| x.is_finite()))?.clone_owned();
    let eigen = SymmetricEigen::try_new(matrix, f64::EPSILON, 500)?;
    let (min, _) = eigen.eigenvalues.iter().enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b))?;
    Some(eigen.eigenvectors.column(min).into_owned())
}

/// The unit vector x that minimises |`matrix`·x|: for a matrix of rank 2 its right null vector.
pub(super) fn null_vector(matrix: &Matrix3<f64>) -> Option<Vector3<f64>> {
    min_eigenvector(&(matrix.transpose() * matrix))
}

/// [v]×, the matrix of the cross product with `v` from the left.
pub(super) fn cross_matrix(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::random::Stream;
    use nalgebra::SMatrix;

    #[test]
    fn equal_points_are_no_division_by_zero() {
        let pairs = [RayPair { a: [3.0, 4.0], b: [5.0, 6.0] }; 4];
        assert_eq!(Normalisation::of(&pairs).1, [RayPair { a: [0.0; 2], b: [0.0; 2] }; 4]);
        assert!(Normalisation::of(&[]).0.scale.is_finite());
    }

    #[test]
    fn null_spaces_are_perpendicular_and_orthonormal() {
        let mut random = Stream::new(1, 0);
        let mut number = || random.within(-1.0, 1.0);
        for _ in 0..50 {
            let rows: [[f64; 9]; 5] = std::array::from_fn(|_| std::array::from_fn(|_| number()));
            let basis: [Vector9; 4] = null_space(&mut rows.clone()).expect("independent rows");
            for (i, x) in basis.iter().enumerate() {
                assert!(rows.iter().all(|row| x.dot(&Vector9::from_row_slice(row)).abs() < 1e-12));
                for (j, y) in basis.iter().enumerate() {
                    assert!((x.dot(y) - f64::from(u8::from(i == j))).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn dependent_rows_and_nonsense_have_none() {
        let mut random = Stream::new(2, 0);
        let mut number = || random.within(-1.0, 1.0);
        let mut rows: [[f64; 9]; 7] = std::array::from_fn(|_| std::array::from_fn(|_| number()));
        rows[6] = rows[2];
        assert!(null_space::<2>(&mut rows.clone()).is_none());
        rows[6][3] = f64::NAN;
        assert!(null_space::<2>(&mut rows).is_none());
        assert!(null_space::<2>(&mut [[0.0; 9]; 7]).is_none());
        assert!(min_eigenvector(&Matrix3::from_element(f64::NAN)).is_none());
        assert!(null_vector(&Matrix3::from_element(f64::INFINITY)).is_none());
    }

    #[test]
    fn min_eigenvectors_are_those_of_the_null_space() {
        let mut random = Stream::new(3, 0);
        let mut number = || random.within(-1.0, 1.0);
        let mut rows: [[f64; 9]; 8] = std::array::from_fn(|_| std::array::from_fn(|_| number()));
        let normal: SMatrix<f64, 9, 9> =
            rows.iter().map(|row| Vector9::from_row_slice(row)).map(|row| row * row.transpose()).sum();
        let [exact] = null_space::<1>(&mut rows).expect("independent rows");
        assert!((min_eigenvector(&normal).expect("finite").dot(&exact).abs() - 1.0).abs() < 1e-12);
    }
}
