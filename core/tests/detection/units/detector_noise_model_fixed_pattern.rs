//! Tests of `detector::noise_model::fixed_pattern`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::plane::*;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::sync::Arc;
use burstscope_core::burst::Burst;
use burstscope_core::monitor::Monitor;
use burstscope_core::synth::random::Stream;
use burstscope_core::synth::{NoiseCase, SceneParams, synth_scene};

fn turned(plane: &Plane) -> Plane {
    Plane::from_fn(plane.height(), plane.width(), |u, v| plane.at(v, u))
}

fn planes(burst: &Burst) -> Vec<Plane> {
    burst.frames.iter().map(|f| (**f).clone()).collect()
}


fn case(case: NoiseCase) -> Vec<Plane> {
    planes(&case.burst((320, 240), 10, 0.02, 5, &Monitor::default()).expect("not cancelled"))
}

fn scene(max_slope: f64) -> Vec<Plane> {
    let scene = SceneParams { width: 320, height: 240, layers: 1, max_slope, ..SceneParams::default() };
    planes(&synth_scene(&scene, &Monitor::default()).expect("a scene").0)
}

fn deviation(plane: &Plane) -> f32 {
    let n = plane.data().len() as f32;
    let mean = plane.data().iter().sum::<f32>() / n;
    (plane.data().iter().map(|x| (x - mean).powi(2)).sum::<f32>() / n).sqrt()
}

#[test]
fn nothing_is_found_where_there_is_no_pattern() {
    for noise in [NoiseCase::White, NoiseCase::Correlated, NoiseCase::NoisyFrame] {
        assert_eq!(find(&case(noise), 0.02), FixedPattern::default(), "{noise:?}");
    }
    assert_eq!(find(&scene(3.0), 0.04), FixedPattern::default());
}

#[test]
fn pixels_that_flicker_are_found_and_objects_that_cross_are_not() {
    let frames = case(NoiseCase::FlickeringPixels);
    let found = find(&frames, 0.02).hot_pixels.len();
    // Of 76 pixels some are weak, or bright in too few frames.
    assert!((55..=76).contains(&found), "{found}");
    // Stars, a pixel wide, that move by a third of a pixel and by a pixel a frame.
    let star = |t: usize, u: usize, v: usize, speed: f32| {
        let (x, y) = (u as f32 - 30.0 - speed * t as f32, v as f32 - 40.0);
        0.4 * (-2.0 * (x * x + y * y)).exp()
    };
    for speed in [0.3, 1.0] {
        let sky: Vec<Plane> = (0..10)
            .map(|t| {
                let mut noise = Stream::new(6, t as u64);
                Plane::from_fn(80, 80, |u, v| 0.3 + star(t, u, v, speed) + 0.02 * noise.normal() as f32)
            })
            .collect();
        assert_eq!(find(&sky, 0.02).hot_pixels, [], "{speed}");
    }
}


#[test]
fn columns_and_rows_are_taken_off() {
    let upright = case(NoiseCase::ColumnStripes);
    let lying: Vec<Plane> = upright.iter().map(turned).collect();
    for (frames, is_upright) in [(upright, true), (lying, false)] {
        let pattern = find(&frames, 0.02);
        assert_eq!((pattern.columns.is_some(), pattern.rows.is_some()), (is_upright, !is_upright));
        let stripes = pattern.columns.as_ref().or(pattern.rows.as_ref()).expect("found");
        assert!((stripes.deviation / 0.02 - 1.0).abs() < 0.15, "{}", stripes.deviation);
        let mut clean = frames[0].clone();
        pattern.remove_from(&mut clean);
        assert!(deviation(&frames[0]) > 0.026 && deviation(&clean) < 0.0215, "{}", deviation(&clean));
    }
}

#[test]
fn a_pattern_is_found_under_a_moving_scene_and_not_on_a_tripod() {
    let mut chance = Stream::new(3, 0);
    let hot: Vec<(usize, usize)> = (0..40).map(|_| (chance.below(320), chance.below(240))).collect();
    let with_hot = |mut frames: Vec<Plane>| {
        frames.iter_mut().for_each(|f| hot.iter().for_each(|&(u, v)| f.row_mut(v)[u] += 0.5));
        frames
    };
    let moving = find(&with_hot(scene(3.0)), 0.04);
    assert!((36..=42).contains(&moving.hot_pixels.len()), "{}", moving.hot_pixels.len());
    assert_eq!(moving.inseparable, 0);
    // One scene with new noise in each frame: the pattern may be a part of the scene.
    let picture = scene(3.0).swap_remove(0);
    let still = (0..10)
        .map(|t| {
            let mut noise = Stream::new(4, t);
            Plane::from_fn(320, 240, |u, v| picture.at(u, v) + 0.01 * noise.normal() as f32)
        })
        .collect();
    let still = find(&with_hot(still), 0.01);
    assert!(still.hot_pixels.is_empty() && still.inseparable >= 30, "{still:?}");
}


