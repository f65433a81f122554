//! Tests of `detector::noise_model::high_pass`.
#![allow(unused_imports)]

use burstscope_core::detector::noise_model::contrast::contrasts;
use burstscope_core::burst::*;
use burstscope_core::detector::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::params::*;
use burstscope_core::plane::*;
use rayon::prelude::*;
use burstscope_core::synth::random::Stream;

fn noise(size: (usize, usize), sigma: f64, seed: u64) -> Plane {
    let mut stream = Stream::new(seed, 0);
    Plane::from_fn(size.0, size.1, |u, _| 1e-3 * u as f32 + (sigma * stream.normal()) as f32)
}

#[test]
fn white_noise_on_a_ramp_has_its_variance_in_every_combination() {
    let frames = [1, 2, 3].map(|seed| noise((400, 300), 0.02, seed));
    let squares = HighPass::new(&frames.iter().collect::<Vec<_>>());
    for weights in [&[(0, 1.0)][..], &[(0, 1.0), (1, -1.0)], &[(0, 1.0), (1, -2.0), (2, 1.0)]] {
        let variances = squares.variances(weights);
        let mean = variances.iter().sum::<f32>() / variances.len() as f32;
        assert!((mean / 4e-4 - 1.0).abs() < 0.03, "{mean}");
        let spread = variances.iter().map(|v| (v / mean - 1.0).powi(2)).sum::<f32>() / variances.len() as f32;
        assert!((spread * FREE_VALUES / 2.0 - 1.0).abs() < 0.2, "{spread}");
        let quiet = quiet_variance(variances, FREE_VALUES);
        assert!((quiet / 4e-4 - 1.0).abs() < 0.04, "{quiet}");
    }
    assert!(squares.same(1, 1) && !squares.same(1, 2));
    assert!(HighPass::new(&[&noise((18, 300), 0.1, 1)]).places.is_empty() && HighPass::new(&[]).places.is_empty());
}

#[test]
fn what_moves_through_the_squares_is_taken_off() {
    let mut stream = Stream::new(8, 0);
    let scene = Plane::from_fn(400, 200, |_, _| 0.3 * stream.normal() as f32);
    let frame = |t: usize| {
        let mut noise = Stream::new(9, t as u64);
        let at = |u: usize, v: usize| scene.at(u + 40 - 4 * t, v + t);
        Plane::from_fn(300, 180, |u, v| at(u, v) + 0.02 * noise.normal() as f32)
    };
    let frames = [0, 1, 2, 3, 4, 5].map(frame);
    let frames: Vec<&Plane> = frames.iter().collect();
    let squares = HighPass::new(&frames);
    let contrasts = &contrasts(6)[..2];
    let at = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|time| Offset::from(time).to_f32());
    let mean = |slope: Slope| {
        let variances = squares.still_variances(&frames, contrasts, &at, &vec![slope; squares.places.len()]);
        variances.iter().sum::<f32>() / variances.len() as f32
    };
    let still = mean(Slope::new(4.0, -1.0));
    assert!((still / 4e-4 - 1.0).abs() < 0.03, "{still}");
    assert!(mean(Slope::default()) > 0.05);
}

