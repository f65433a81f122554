//! Tests of `matching::align::chip`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::stack::*;
use burstscope_core::matching::*;
use burstscope_core::matching::align::*;
use burstscope_core::matching::align::chip::*;
use burstscope_core::plane::*;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

/// Frames with a Gaussian blob of standard deviation `blob` px that moves by `slope`, at (90.3, 70.6) at mid-burst.
fn moving(slope: Slope, blob: f32) -> Vec<Plane> {
    (0..5)
        .map(|t| {
            let dt = t as f32 - 2.0;
            Plane::from_fn(181, 139, |u, v| {
                let (du, dv) = (u as f32 - 90.3 - dt * slope.u, v as f32 - 70.6 - dt * slope.v);
                (-(du * du + dv * dv) / (2.0 * blob * blob)).exp()
            })
        })
        .collect()
}

fn chip(frames: &[Plane], at: (f32, f32), sigma: f32, slope: Slope) -> Chip {
    let planes: Vec<&Plane> = frames.iter().collect();
    ChipSource::new(&planes, &FrameTimes::all(burstscope_core::burst::Positions::even(frames.len())), 20.0)
        .chip(at, sigma, slope)
        .expect("inside")
}

#[test]
fn samples_are_the_moving_thing_blurred_at_every_scale() {
    let slope = Slope::new(1.37, -0.61);
    for (sigma, blob) in [(1.7f32, 2.5f32), (3.0, 4.0), (5.0, 5.0), (12.0, 14.0)] {
        let chip = chip(&moving(slope, blob), (88.0, 72.5), sigma, slope);
        let variance = blob * blob + (BLUR as f32 * sigma).powi(2);
        let peak = blob * blob / variance;
        for (i, j) in (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j))) {
            let at = |k: usize, middle: f32| middle + (k as f32 - REACH as f32) * STEP * sigma;
            let (u, v) = (at(i, 88.0), at(j, 72.5));
            let inside = (-0.5..=180.5).contains(&u) && (-0.5..=138.5).contains(&v);
            assert_eq!(chip.sample(i, j).is_some(), inside, "σ {sigma} ({u}, {v})");
            // Nearer to the border the blur ends there.
            let reach = 3.0 * sigma;
            if let Some(value) = chip.sample(i, j).filter(|_| u > reach && v > reach && u < 180.0 - reach) {
                let squared = (u - 90.3).powi(2) + (v - 70.6).powi(2);
                let truth = peak * (-squared / (2.0 * variance)).exp();
                assert!((value - truth).abs() < 0.02, "σ {sigma} ({u}, {v}): {value} {truth}");
            }
        }
    }
}

