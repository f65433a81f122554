//! Tests of `detector::noise_model::examine`.
#![allow(unused_imports)]

use burstscope_core::burst::Burst;
use burstscope_core::burst::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::params::SlopeGrid;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use burstscope_core::synth::NoiseCase;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

fn slopes() -> Vec<Slope> {
    SlopeGrid::line(-3.0..=3.0, 13).slopes().collect()
}

fn examined(burst: &Burst, flicker: Flicker) -> Examined {
    let space = ScaleSpace::new(4, 0, 4.0);
    let slopes = slopes();
    let positions = &Positions::even(burst.len());
    let search = ForSearch { space: &space, octaves: 0..4, slopes: &slopes, flicker, positions };
    examine(&burst.frames, burst.quantisation_step, &search, &Monitor::default())
        .expect("not cancelled")
        .expect("there is enough")
}

fn case(case: NoiseCase) -> (Burst, Examined) {
    let burst = case.burst((480, 360), 10, 0.02, 3, &Monitor::default()).expect("not cancelled");
    let examined = examined(&burst, Flicker::Auto);
    (burst, examined)
}

#[test]
fn flicker_is_evened_out_unless_it_is_wanted() {
    let case = NoiseCase::GainFlicker;
    let burst = case.burst((320, 240), 8, 0.02, 3, &Monitor::default()).expect("not cancelled");
    let spread = |frames: &[Arc<Plane>]| {
        let means = frames.iter().map(|f| f.data().iter().sum::<f32>() / f.data().len() as f32);
        let (min, max) = means.fold((f32::INFINITY, 0.0f32), |(a, b), x| (a.min(x), b.max(x)));
        max / min - 1.0
    };
    let (even, as_they_are) = (examined(&burst, Flicker::Auto), examined(&burst, Flicker::Off));
    assert!(spread(&even.frames) < 0.002 && spread(&burst.frames) > 0.05, "{}", spread(&even.frames));
    assert!(as_they_are.frames.iter().zip(&burst.frames).all(|(a, b)| Arc::ptr_eq(a, b)));
    for (examined, words) in [(even, "were brought"), (as_they_are, "were left")] {
        let warning = &examined.model.warnings[0];
        assert!(warning.kind == WarningKind::GainFlicker && warning.text.contains(words), "{warning:?}");
    }
}

#[test]
fn a_weak_pattern_is_measured_in_the_mean_of_the_frames() {
    for (percent, share) in [(20u8, 0.038), (40, 0.138)] {
        let (_, found) = case(NoiseCase::FixedPattern(percent));
        assert!((found.model.pattern_share / share - 1.0).abs() < 0.35, "{percent}: {}", found.model.pattern_share);
    }
    for noise in [NoiseCase::White, NoiseCase::Correlated, NoiseCase::NoisyHalf, NoiseCase::Jpeg(60)] {
        assert_eq!(case(noise).1.model.pattern_share, 0.0, "{noise:?}");
    }
}

#[test]
fn too_little_to_tell_is_no_model() {
    let space = ScaleSpace::new(4, 0, 4.0);
    let slopes = slopes();
    let (flicker, positions) = (Flicker::Auto, Positions::even(1));
    let search = ForSearch { space: &space, octaves: 0..1, slopes: &slopes, flicker, positions: &positions };
    let examine = |frames: &[Arc<Plane>]| examine(frames, 0.0, &search, &Monitor::default());
    let frame = Arc::new(Plane::from_fn(40, 40, |u, v| ((u * 7 + v * 13) % 11) as f32));
    assert!(examine(&[frame]).expect("not cancelled").is_none());
    let small = [(); 3].map(|()| Arc::new(Plane::zeros(12, 40))).to_vec();
    assert!(examine(&small).expect("not cancelled").is_none());
}
