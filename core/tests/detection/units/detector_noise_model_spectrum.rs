//! Tests of `detector::noise_model::spectrum`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::*;
use burstscope_core::detector::noise::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::stack::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use burstscope_core::plane::blur::*;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::Range;
use burstscope_core::detector::params::SlopeGrid;
use burstscope_core::plane::blur::gaussian_blur;
use burstscope_core::synth::random::Stream;
use burstscope_core::synth::{NoiseCase, SceneParams, synth_scene};


fn line() -> SlopeGrid {
    SlopeGrid::line(-3.0..=3.0, 13)
}


#[test]
fn white_noise_passes_as_white_noise() {
    for (first, frames) in [(0, 10), (-1, 10), (0, 2), (1, 10)] {
        let space = ScaleSpace::new(3, first, 4.0);
        let noise = of_case(NoiseCase::White, frames, &space, first..4);
        for (octave, levels) in (first..).zip(&noise) {
            for (level, noise) in levels.iter().enumerate() {
                // Coarse octaves of so small an image have few places, mostly near its border.
                let tolerance = if octave < 2 { 0.1 } else { 0.5 };
                let off = noise.over_white - 1.0;
                assert!(off.abs() < tolerance, "first {first}, octave {octave}, level {level}: {noise:?}");
                assert_eq!(noise.excess_kurtosis, 0.0);
            }
        }
    }
}

#[test]
fn shared_noise_passes_more_at_coarse_levels() {
    // The weights 1, 2, 1 over √6 let 16/6 of the variance pass per axis at low frequencies.
    let noise = of_case(NoiseCase::Correlated, 10, &ScaleSpace::new(3, 0, 4.0), 0..4);
    let [fine, _, coarse] = [0, 1, 2].map(|octave| {
        noise[octave].iter().map(|level| level.over_white / (16.0f32 / 6.0).powi(2)).collect::<Vec<_>>()
    });
    assert!(coarse.iter().all(|part| (part - 1.0).abs() < 0.15), "{noise:?}");
    assert!(fine.is_sorted() && fine[0] < 0.8 && fine[0] > 0.4, "{noise:?}");
}




