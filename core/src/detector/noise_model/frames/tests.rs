//! Tests of which frames are left out, and of the measurements of the others.

use super::*;
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::blur::{GaussianKernel, gaussian_blur};
use crate::synth::random::Stream;
use crate::synth::{NoiseCase, SceneParams, synth_scene};

fn survey_of(frames: &[&Plane]) -> FrameSurvey {
    FrameSurvey::new(&HighPass::new(frames))
}

fn survey(case: NoiseCase) -> FrameSurvey {
    let burst = case.burst((320, 240), 10, 0.02, 5, &Monitor::default()).expect("not cancelled");
    survey_of(&burst.frames.iter().map(|f| &**f).collect::<Vec<_>>())
}

#[test]
fn good_frames_all_take_part_unchanged() {
    for case in
        [NoiseCase::White, NoiseCase::Correlated, NoiseCase::Jpeg(60), NoiseCase::NoisyHalf, NoiseCase::Constant]
    {
        let survey = survey(case);
        assert_eq!(survey.kept().len(), 10, "{case:?} {survey:?}");
        assert!(survey.frames.iter().all(|f| f.gain == 1.0 && f.relative_variance == 1.0), "{case:?} {survey:?}");
        assert_eq!((survey.flicker, survey.correlation), (0.0, 0.0), "{case:?}");
    }
}

#[test]
fn a_frame_that_repeats_another_does_not_count() {
    let survey = survey(NoiseCase::Doubled);
    assert_eq!(survey.kept(), [0, 2, 4, 6, 8]);
    assert_eq!(survey.frames[7].left_out, Some(LeftOut::Duplicate(6)));
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
fn flicker_is_measured_and_a_steady_change_is_none() {
    let burst = NoiseCase::GainFlicker.burst((320, 240), 10, 0.02, 5, &Monitor::default()).expect("not cancelled");
    let survey = survey(NoiseCase::GainFlicker);
    assert!((0.04..0.2).contains(&survey.flicker), "{}", survey.flicker);
    let mean = |t: usize| burst.frames[t].data().iter().sum::<f32>() / burst.frames[t].data().len() as f32;
    for t in 1..10 {
        let ratio = survey.frames[t].gain / survey.frames[0].gain;
        assert!((ratio / (mean(t) / mean(0)) - 1.0).abs() < 2e-3, "{t}: {ratio}");
    }
    let steady: Vec<Plane> = (0..6).map(|t| Plane::from_fn(100, 100, |_, _| 0.5 + 0.02 * t as f32)).collect();
    assert_eq!(survey_of(&steady.iter().collect::<Vec<_>>()).flicker, 0.0);
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
    assert!((survey.correlation - 0.5).abs() < 0.05, "{}", survey.correlation);
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

#[test]
fn a_moving_scene_has_nothing_to_be_left_out() {
    let scene = SceneParams { width: 240, height: 180, frames: 6, layers: 1, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("a scene");
    let survey = survey_of(&burst.frames.iter().map(|f| &**f).collect::<Vec<_>>());
    assert_eq!((survey.kept().len(), survey.flicker, survey.correlation), (6, 0.0, 0.0), "{survey:?}");
}
