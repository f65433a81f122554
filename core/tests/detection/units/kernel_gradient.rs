//! Tests of `kernel::gradient`.
#![allow(unused_imports)]

use std::f32::consts::{LN_2, LOG2_E};
use std::ops::Range;
use std::f32::consts::TAU;

#[test]
fn polar_coordinates_are_exact_to_a_few_millionths() {
    for i in 0..10_000 {
        let angle = i as f32 / 10_000.0 * TAU;
        let (length, eighths) = polar(0.01 * angle.cos(), 0.01 * angle.sin());
        let d = (eighths / 8.0 * TAU - angle).rem_euclid(TAU);
        assert!(d.min(TAU - d) < 4e-6, "{angle}: {eighths}");
        assert!((length / 0.01 - 1.0).abs() < 3e-6, "{angle}: {length}");
    }
    assert_eq!(polar(0.0, 0.0), (0.0, 0.0));
    assert!(polar(1.0, -1e-30).1 < 8.0);
}

#[test]
fn windows_are_gaussian() {
    let mut found = Vec::new();
    window(-30..31, 0.3, 7.0, &mut found);
    for (i, value) in (-30..31).zip(&found) {
        let expected = (-0.5 * ((f64::from(i) - 0.3) / 7.0).powi(2)).exp();
        assert!((f64::from(*value) / expected - 1.0).abs() < 1e-5, "{i}: {value} {expected}");
    }
    assert_eq!(exp_of_negative(0.0), 1.0);
    assert!(exp_of_negative(-80.0) > 0.0 && exp_of_negative(-1e6) == 0.0);
}

