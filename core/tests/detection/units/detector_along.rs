//! Tests of `detector::along`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::stack::*;
use burstscope_core::plane::*;
use burstscope_core::plane::blur::*;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::OnceLock;
use burstscope_core::burst::Burst;
use burstscope_core::detector::{DetectorParams, NoiseModelKind, SlopeGrid};
use burstscope_core::monitor::Monitor;

fn inputs(frames: Vec<Plane>, first_octave: i32) -> Inputs {
    let (slopes, noise_model) = (SlopeGrid::line(-2.0..=2.0, 3), NoiseModelKind::White);
    let params = DetectorParams { first_octave, slopes, noise_model, ..DetectorParams::default() };
    Inputs::new(&Burst::from_planes("made", frames), &params, &Monitor::default()).expect("valid parameters")
}

#[test]
fn frames_are_the_same_whoever_makes_them() {
    let inputs = inputs((0..9).map(|t| Plane::from_fn(128, 96, |u, v| (u * v + t) as f32)).collect(), 0);
    let alone = Along::new(&inputs);
    let expected = alone.of(2).planes;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().expect("a pool");
    for _ in 0..20 {
        let means = Along::no_means(&inputs);
        let are_those = |_| Along::with_means(&inputs, &means).of(2).planes == expected;
        assert!(pool.install(|| (0..100).into_par_iter().with_max_len(1).all(are_those)));
    }
    let together = Along::new(&inputs);
    pool.install(|| together.make(2));
    assert!(together.of(2).planes == expected);
}

/// Frames with a Gaussian blob of σ 6 px that moves by `slope`, at (70, 50) in the middle of the burst.
fn moving(slope: Slope) -> Vec<Plane> {
    (0..7)
        .map(|t| {
            let dt = t as f32 - 3.0;
            Plane::from_fn(160, 120, |u, v| {
                let (du, dv) = (u as f32 - 70.0 - dt * slope.u, v as f32 - 50.0 - dt * slope.v);
                (-(du * du + dv * dv) / 72.0).exp()
            })
        })
        .collect()
}

#[test]
fn every_octave_shows_a_moving_blob_sharp_and_in_its_place() {
    let slope = Slope::new(1.37, -0.61);
    for octave in [-1, 0, 1, 2] {
        let inputs = inputs(moving(slope), octave);
        let along = Along::new(&inputs);
        let of_octave = along.of(octave);
        let offsets = of_octave.offsets(slope);
        let base = of_octave.base(&of_octave.planes, &offsets);
        let pixel = 2f32.powi(octave);
        let (size, at) = (octave_size((160, 120), octave), |x: f32| (x / pixel) as i64);
        let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
        let (columns, rows) = (at(40.0)..at(100.0), at(20.0)..at(80.0));
        base.patch(size, columns.clone(), rows.clone(), &mut scratch, &mut patch);
        let middle = patch.row((rows.start + rows.end) / 2)[columns.clone().count() / 2];
        // Averages and interpolation increase σ².
        let source = of_octave.sigma_octave(&offsets).powi(2) as f32 * pixel * pixel;
        let variance = 36.0 + source - (SIGMA_INPUT as f32).powi(2);
        let truth = |du: f32, dv: f32| 36.0 / variance * (-(du * du + dv * dv) / (2.0 * variance)).exp();
        let offset = |range: &Range<i64>, at: f32| ((range.start + range.end) / 2) as f32 * pixel - at;
        let centre = truth(offset(&columns, 70.0), offset(&rows, 50.0));
        for y in rows {
            for (x, value) in columns.clone().zip(patch.row(y)) {
                let (du, dv) = (x as f32 * pixel - 70.0, y as f32 * pixel - 50.0);
                let expected = truth(du, dv) - centre + middle;
                assert!((value - expected).abs() < 8e-3, "octave {octave} ({x}, {y}): {value} {expected}");
            }
        }
    }
}

