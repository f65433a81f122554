//! Tests of `detect`.
#![allow(unused_imports)]

use burstscope_core::baseline::*;
use burstscope_core::burst::*;
use burstscope_core::detect::*;
use burstscope_core::detector::*;
use burstscope_core::detector::slopes::*;
use burstscope_core::error::*;
use burstscope_core::monitor::*;
use std::path::PathBuf;
use std::time::Instant;
use burstscope_core::detector::FrameRange;
use burstscope_core::synth::{SceneParams, synth_scene};

#[test]
fn the_merge_is_searched_as_one_image_would_be() {
    let scene = SceneParams { width: 240, height: 180, frames: 6, layers: 1, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("a scene");
    let frames = Some(FrameRange { start: 1, end: 6 });
    let params = DetectorParams { method: Method::Merge, frames, ..DetectorParams::default() };
    let found = detect(&burst, &params, &Monitor::default()).expect("detected");
    let merged = merge_burst(&burst, 1..6, &Monitor::default()).expect("merged");
    let sift = DetectorParams { method: Method::Sift, ..DetectorParams::default() };
    let by_hand = pipeline::search(&merged, &sift, &Monitor::default()).expect("detected");
    assert!(!found.features.is_empty());
    assert_eq!((&found.features, &found.descriptors), (&by_hand.features, &by_hand.descriptors));
    assert_eq!((found.frames_used, found.slopes.len()), (1..6, 1));
    // The gate uses the merged image's noise: less than half of a frame's.
    let one = detect(&burst, &sift, &Monitor::default()).expect("detected").frame_noise;
    let ideal = one / 5f32.sqrt();
    assert!((found.frame_noise / ideal - 1.0).abs() < 0.15, "{} of {one}", found.frame_noise);
    let past = DetectorParams { frames: Some(FrameRange { start: 1, end: 7 }), ..params };
    assert!(prepare(&burst, &past, &Monitor::default()).is_err_and(|error| error.subject == "frames"));
}

