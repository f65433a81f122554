//! Tests of `detector::refine::ascent`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::scale_space::*;
use nalgebra::{Cholesky, Matrix3, Vector3};
use std::cell::RefCell;
use std::ops::Range;
use burstscope_core::plane::Plane;

fn space() -> ScaleSpace {
    ScaleSpace::new(5, 0, 4.0)
}


/// A dark blob of height 0.2 and standard deviation `sigma`, which includes the first level's.
fn blob(sigma: f64, x: f64, y: f64) -> Plane {
    Plane::from_fn(80, 70, |u, v| {
        let r2 = (u as f64 - x).powi(2) + (v as f64 - y).powi(2);
        (0.3 - 0.2 * (-r2 / (2.0 * sigma * sigma)).exp()) as f32
    })
}

#[test]
fn a_blob_has_its_place_scale_and_value_wherever_the_samples_fall() {
    let k = 2f64.powf(0.2);
    for sigma in [2.6, 3.1, 3.7] {
        let own2 = sigma * sigma - 1.6 * 1.6;
        let (expected_sigma, expected) = ((own2 / k).sqrt(), 0.2 * sigma * sigma / own2 * (k - 1.0) / (k + 1.0));
        let level = 1.0 + 5.0 * (expected_sigma / space().sigma_octave(0.0)).log2();
        for (x, y) in [(40.0, 35.0), (40.5, 35.5), (40.3, 34.6), (39.51, 35.49)] {
            for start_level in [level - 0.6, level, level + 0.6] {
                let found = ascend(&blob(sigma, x, y), (40.0, 35.0), start_level, 1.0).expect("a clean blob");
                assert!((found.x - x).abs() < 0.01 && (found.y - y).abs() < 0.01, "{found:?} for {x} {y}");
                assert!((found.level - level).abs() < 0.06, "{found:?} for level {level}");
                assert!((found.value / expected - 1.0).abs() < 0.01, "{found:?} for {expected}");
                let [uu, uv, vv] = found.curvature;
                assert!(uu < 0.0 && (uu / vv - 1.0).abs() < 0.01 && (uv / uu).abs() < 0.01, "{found:?}");
            }
        }
    }
}

#[test]
fn a_blob_finer_than_the_octave_is_placed_below_its_first_level() {
    let found = ascend(&blob(2.1, 40.2, 34.9), (40.0, 35.0), 1.0, 1.0).expect("a clean blob");
    assert!(found.level < 0.5, "{found:?}");
}

#[test]
fn there_is_no_peak_of_the_other_sign_on_a_ramp_or_far_away() {
    let ramp = Plane::from_fn(80, 70, |u, v| (u + 2 * v) as f32 * 0.003);
    assert_eq!(ascend(&ramp, (40.0, 35.0), 2.0, 1.0), None);
    assert_eq!(ascend(&blob(3.0, 40.0, 35.0), (40.0, 35.0), 2.0, -1.0), None);
    assert_eq!(ascend(&blob(3.0, 45.0, 35.0), (40.5, 35.0), 2.0, 1.0), None);
}

