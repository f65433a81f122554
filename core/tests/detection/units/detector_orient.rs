//! Tests of `detector::orient`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use multiversion::multiversion;
use std::f32::consts::TAU;
use burstscope_core::detector::scale_space::Base;
use burstscope_core::plane::Plane;


#[test]
fn a_ramp_has_the_direction_in_which_it_rises() {
    for degrees in [3.0f32, 47.0, 95.0, 181.0, 275.0, 344.0, 359.5] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let found = found(|u, v| 0.01 * (cos * u + sin * v));
        assert_eq!(found.len(), 1);
        assert!((found[0].to_degrees() - degrees).abs() < 0.5, "{degrees}: {}", found[0].to_degrees());
    }
}

#[test]
fn a_saddle_has_several_and_nothing_has_none() {
    assert_eq!(found(|u, v| 1e-3 * (u * u - v * v)).len(), 4);
    assert_eq!(found(|_, _| 0.4), vec![0.0]);
}

