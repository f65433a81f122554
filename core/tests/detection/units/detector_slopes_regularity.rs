//! Tests of `detector::slopes::regularity`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::slopes::*;
use serde::Serialize;
use burstscope_core::detector::params::Slope;

const SIZE: Size = Size { gaps: 9.0, pixels: (640, 480) };
const STEPS: Steps = Steps { search: 0.4, same: 0.4 };

/// Evidence of slopes that are `slope` of the place, in pixels from the middle.
fn evidence(slope: impl Fn(f64, f64) -> (f64, f64)) -> Vec<SlopeEvidence> {
    let window = |i: usize| {
        let (u, v) = ((i % 6) as f64 * 100.0 + 60.0, (i / 6) as f64 * 90.0 + 60.0);
        let (along_u, along_v) = slope(u - 319.5, v - 239.5);
        burstscope_core::detector::slopes::evidence::tests::window(Slope::new(along_u as f32, along_v as f32), [u as f32, v as f32])
    };
    (0..30).map(window).collect()
}

#[test]
fn a_turn_and_growth_are_named_with_their_size() {
    let turn = 1.2f64.to_radians() / 9.0;
    let grow = -0.015 / 9.0;
    let warnings = of_places(&evidence(|u, v| (2.0 + grow * u, 0.5 + grow * v)), STEPS, SIZE);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].text.contains("shrinks by 1.5 %"), "{warnings:?}");
    // An object that moves by itself changes nothing.
    let with_object = |u: f64, v: f64| if u.abs() < 100.0 { (-3.0, 1.0) } else { (1.0 - turn * v, turn * u) };
    let warnings = of_places(&evidence(with_object), STEPS, SIZE);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!((warnings[0].number - 1.2).abs() < 0.01 && warnings[0].text.contains("turn by 1.2°"), "{warnings:?}");
}

#[test]
fn parallax_and_uniform_motion_neither_turn_nor_grow() {
    assert_eq!(of_places(&evidence(|_, _| (2.0, 0.0)), STEPS, SIZE), []);
    assert_eq!(of_places(&evidence(|_, v| (2.0 + 0.004 * v, 0.0)), STEPS, SIZE), [], "a floor, seen at an angle");
    assert_eq!(of_places(&evidence(|u, _| (if u > 0.0 { 3.0 } else { 1.0 }, 0.0)), STEPS, SIZE), [], "two depths");
    assert_eq!(of_places(&evidence(|_, _| (2.0, 0.0))[..5], STEPS, SIZE), []);
}

