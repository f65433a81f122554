//! Tests of `matching::geometry::points`.
#![allow(unused_imports)]

use burstscope_core::matching::*;
use burstscope_core::matching::geometry::*;
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, DimDiff, DimSub, Matrix3, OMatrix, OVector, SVector, SymmetricEigen, Vector3};
use nalgebra::SMatrix;

#[test]
fn equal_points_are_no_division_by_zero() {
    let pairs = [RayPair { a: [3.0, 4.0], b: [5.0, 6.0] }; 4];
    assert_eq!(Normalisation::of(&pairs).1, [RayPair { a: [0.0; 2], b: [0.0; 2] }; 4]);
    assert!(Normalisation::of(&[]).0.scale.is_finite());
}

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
    assert!(min_eigenvector(&Matrix3::from_element(f64::NAN)).is_none());
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

