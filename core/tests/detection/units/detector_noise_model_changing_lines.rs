//! Tests of `detector::noise_model::changing_lines`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::plane::*;
use serde::Serialize;
use burstscope_core::monitor::Monitor;
use burstscope_core::synth::{NoiseCase, SceneParams, demo_burst, synth_scene};

const SLOPES: [f32; 5] = [-3.0, -0.3, 0.0, 0.3, 3.0];


fn case(case: NoiseCase) -> Vec<Plane> {
    let burst = case.burst((480, 360), 8, 0.02, 5, &Monitor::default()).expect("not cancelled");
    burst.frames.iter().map(|f| (**f).clone()).collect()
}

#[test]
fn noise_and_scenes_have_no_such_lines() {
    for noise in [NoiseCase::White, NoiseCase::Correlated, NoiseCase::Varying(6), NoiseCase::Jpeg(60)] {
        assert_eq!(found(&case(noise)), [None, None], "{noise:?}");
    }
    let scene = SceneParams { width: 320, height: 240, layers: 2, ..SceneParams::default() };
    let (scene, _) = synth_scene(&scene, &Monitor::default()).expect("a scene");
    for burst in [scene, demo_burst()] {
        assert_eq!(found(&burst.frames.iter().map(|f| (**f).clone()).collect::<Vec<_>>()), [None, None]);
    }
}

#[test]
fn stripes_columns_and_bands_are_found_and_taken_off() {
    for (noise, axis, extent, deviation, lasts) in [
        (NoiseCase::DriftingStripes(3), 0, Extent::Sharp, 0.0165, true),
        (NoiseCase::DriftingStripes(26), 0, Extent::Sharp, 0.0165, true),
        (NoiseCase::NoisyColumns, 0, Extent::Sharp, 0.0028, false),
        (NoiseCase::Banding, 1, Extent::Wide, 0.0071, false),
        (NoiseCase::StillBanding, 1, Extent::Wide, 0.0071, true),
    ] {
        let mut frames = case(noise);
        let lines = found(&frames);
        let of_axis = lines[axis].unwrap_or_else(|| panic!("{noise:?}: {lines:?}"));
        assert!(lines[1 - axis].is_none() && of_axis.extent == extent, "{noise:?}: {lines:?}");
        assert!((of_axis.deviation / deviation - 1.0).abs() < 0.3, "{noise:?}: {of_axis:?}");
        assert_eq!(of_axis.lasting > 0.5, lasts, "{noise:?}: {of_axis:?}");
        frames.iter_mut().for_each(|frame| of_axis.remove_from(frame, axis));
        assert_eq!(found(&frames), [None, None], "{noise:?}");
        let n = frames[3].data().len() as f32;
        let left = (frames[3].data().iter().map(|x| (x - 0.5).powi(2)).sum::<f32>() / n).sqrt();
        assert!((left / 0.02 - 1.0).abs() < 0.06, "{noise:?}: {left}");
    }
}

