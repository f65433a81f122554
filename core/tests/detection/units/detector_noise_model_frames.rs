//! Tests of `detector::noise_model::frames`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::noise_model::*;
use rayon::prelude::*;
use serde::Serialize;
use burstscope_core::monitor::Monitor;
use burstscope_core::plane::Plane;
use burstscope_core::plane::blur::{GaussianKernel, gaussian_blur};
use burstscope_core::synth::random::Stream;
use burstscope_core::synth::{NoiseCase, SceneParams, synth_scene};



#[test]
fn good_frames_all_take_part_unchanged() {
    for case in
        [NoiseCase::White, NoiseCase::Correlated, NoiseCase::Jpeg(60), NoiseCase::NoisyHalf, NoiseCase::Constant]
    {
        let survey = survey(case);
        assert_eq!(survey.kept().len(), 10, "{case:?} {survey:?}");
        assert!(survey.frames.iter().all(|f| f.gain == 1.0 && f.relative_variance == 1.0), "{case:?} {survey:?}");
        assert_eq!((survey.flicker, survey.correlations.clone()), (0.0, Vec::new()), "{case:?}");
    }
}

#[test]
fn black_empty_and_noisy_frames_are_left_out() {
    let without_5 = [0, 1, 2, 3, 4, 6, 7, 8, 9];
    let black = survey(NoiseCase::BlackFrame);
    assert_eq!(black.kept(), without_5);
    assert!(matches!(black.frames[5].left_out, Some(LeftOut::Black | LeftOut::Empty)), "{:?}", black.frames[5]);
    let empty = survey(NoiseCase::ConstantFrame);
    assert_eq!((empty.kept(), empty.frames[5].left_out), (without_5.to_vec(), Some(LeftOut::Empty)));
    let noisy = survey(NoiseCase::NoisyFrame);
    assert_eq!(noisy.kept(), without_5);
    match noisy.frames[5].left_out {
        Some(LeftOut::Noisy(times)) => assert!((times / 25.0 - 1.0).abs() < 0.1, "{times}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_change_that_all_places_share_is_drift() {
    for (case, range) in [(NoiseCase::Fading(10), 0.1), (NoiseCase::Breathing(3), 0.03)] {
        let survey = survey(case);
        assert!((survey.drift / range - 1.0).abs() < 0.15 && survey.flicker == 0.0, "{case:?}: {survey:?}");
        let gains = survey.frames.iter().map(|f| f.gain);
        let (min, max) = gains.fold((f32::INFINITY, 0.0f32), |(a, b), gain| (a.min(gain), b.max(gain)));
        assert!(((max / min).ln() / range - 1.0).abs() < 0.15, "{min} {max}");
    }
    // A lit and a dark half, and a border between them that moves: places change, but each in its own way.
    let frames: Vec<Plane> =
        (0..6).map(|t| Plane::from_fn(320, 240, |u, _| if u < 40 + 40 * t { 0.6 } else { 0.3 })).collect();
    assert_eq!(survey_of(&frames.iter().collect::<Vec<_>>()).drift, 0.0);
}

#[test]
fn smoothing_over_time_shows_as_correlation() {
    let burst = NoiseCase::White.burst((320, 240), 12, 0.02, 5, &Monitor::default()).expect("not cancelled");
    let mut smooth: Vec<Plane> = vec![(*burst.frames[0]).clone()];
    for frame in &burst.frames[1..] {
        let before = smooth.last().expect("one").data();
        let values = frame.data().iter().zip(before).map(|(x, y)| 0.5 * x + 0.5 * y).collect();
        smooth.push(Plane::from_vec(320, 240, values));
    }
    let survey = survey_of(&smooth.iter().skip(3).collect::<Vec<_>>());
    assert!((survey.correlations[0] - 0.5).abs() < 0.05, "{:?}", survey.correlations);
}

#[test]
fn a_blurred_frame_is_left_out_where_its_texture_can_be_seen() {
    let scene = SceneParams { width: 320, height: 240, frames: 8, snr: f64::INFINITY, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("a scene");
    let mut frames: Vec<Plane> = burst.frames.iter().map(|f| (**f).clone()).collect();
    frames[3] = gaussian_blur(&frames[3], &GaussianKernel::new(2.0));
    for (sigma, is_seen) in [(0.01, true), (0.5, false)] {
        let mut stream = Stream::new(3, 0);
        let mut noisy = |f: &Plane| Plane::from_fn(320, 240, |u, v| f.at(u, v) + sigma * stream.normal() as f32);
        let noisy: Vec<Plane> = frames.iter().map(&mut noisy).collect();
        let survey = survey_of(&noisy.iter().collect::<Vec<_>>());
        let left_out: Vec<usize> = (0..8).filter(|&t| survey.frames[t].left_out.is_some()).collect();
        assert_eq!(left_out, if is_seen { vec![3] } else { vec![] }, "{survey:?}");
        assert!(!is_seen || matches!(survey.frames[3].left_out, Some(LeftOut::Blurred(share)) if share < 0.4));
    }
}

