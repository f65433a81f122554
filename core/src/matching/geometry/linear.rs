//! Small linear algebra for the solvers: null spaces and smallest eigenvectors.

use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};

/// A 3×3 matrix as the vector of its rows.
pub(super) type Vector9 = SVector<f64, 9>;

/// The matrix whose rows, one after the other, are `vector`.
pub(super) fn matrix_of(vector: &Vector9) -> Matrix3<f64> {
    Matrix3::from_row_iterator(vector.iter().copied())
}

/// An orthonormal basis of the `D` dimensions of vectors that are perpendicular to all `9 − D` rows; `None` where the
/// rows are (nearly) dependent, so that there are more such dimensions. Elimination with full pivoting, which for so
/// small a system is as exact as a decomposition and much faster.
pub(super) fn null_space<const D: usize>(rows: &mut [[f64; 9]]) -> Option<[Vector9; D]> {
    let count = rows.len();
    debug_assert_eq!(count + D, 9, "each row takes away one dimension");
    let mut columns: [usize; 9] = std::array::from_fn(|i| i);
    let largest = rows.iter().flatten().fold(0.0f64, |max, x| max.max(x.abs()));
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
pub(super) fn min_eigenvector(matrix: &SMatrix<f64, 9, 9>) -> Option<Vector9> {
    if !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let eigen = SymmetricEigen::try_new(*matrix, f64::EPSILON, 500)?;
    let min = (0..9).min_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]))?;
    Some(eigen.eigenvectors.column(min).into_owned())
}

/// The unit vector x that minimises |`matrix`·x|: for a matrix of rank 2 its right null vector.
pub(super) fn null_vector(matrix: &Matrix3<f64>) -> Option<Vector3<f64>> {
    let normal = matrix.transpose() * matrix;
    if !normal.iter().all(|x| x.is_finite()) {
        return None;
    }
    let eigen = SymmetricEigen::try_new(normal, f64::EPSILON, 500)?;
    let min = (0..3).min_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]))?;
    Some(eigen.eigenvectors.column(min).into_owned())
}

/// [v]×, the matrix of the cross product with `v` from the left.
pub(super) fn cross_matrix(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Arbitrary numbers in −1 … 1.
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    #[test]
    fn null_spaces_are_perpendicular_and_orthonormal() {
        let mut number = numbers(1);
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
        let mut number = numbers(2);
        let mut rows: [[f64; 9]; 7] = std::array::from_fn(|_| std::array::from_fn(|_| number()));
        rows[6] = rows[2];
        assert!(null_space::<2>(&mut rows.clone()).is_none());
        rows[6][3] = f64::NAN;
        assert!(null_space::<2>(&mut rows).is_none());
        assert!(null_space::<2>(&mut [[0.0; 9]; 7]).is_none());
        assert!(min_eigenvector(&SMatrix::from_element(f64::NAN)).is_none());
        assert!(null_vector(&Matrix3::from_element(f64::INFINITY)).is_none());
    }

    #[test]
    fn min_eigenvectors_are_those_of_the_null_space() {
        let mut number = numbers(3);
        let mut rows: [[f64; 9]; 8] = std::array::from_fn(|_| std::array::from_fn(|_| number()));
        let normal: SMatrix<f64, 9, 9> =
            rows.iter().map(|row| Vector9::from_row_slice(row)).map(|row| row * row.transpose()).sum();
        let [exact] = null_space::<1>(&mut rows).expect("independent rows");
        assert!((min_eigenvector(&normal).expect("finite").dot(&exact).abs() - 1.0).abs() < 1e-12);
    }
}
