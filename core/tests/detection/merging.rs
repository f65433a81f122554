//! The merge on bursts whose motion and noiseless truth are known.

use crate::prelude::*;
use burstscope_core::{baseline::merge_burst, detect::prepare};
use std::sync::Mutex;

/// A smooth scene with structure at several scales, at any position; values about 0.2 … 0.6.
fn scene(u: f64, v: f64) -> f64 {
    let wave = |length: f64, angle: f64, phase: f64| {
        ((u * angle.cos() + v * angle.sin()) * std::f64::consts::TAU / length + phase).sin()
    };
    0.4 + 0.07 * wave(60.0, 0.3, 0.0) * wave(47.0, 1.7, 1.0)
        + 0.05 * wave(23.0, 2.5, 2.0) * wave(31.0, 0.9, 0.5)
        + 0.03 * wave(13.0, 1.2, 0.0) * wave(11.0, 2.9, 3.0)
}

const SIZE: (usize, usize) = (320, 240);

/// `frames` frames of the scene with Gaussian noise; the whole scene moves by `slope` pixels per frame.
fn moving_burst(slope: (f64, f64), sigma: f64, frames: usize, seed: u64) -> Burst {
    let middle = (frames / 2) as f64;
    let planes = (0..frames).map(|t| {
        let mut noise = Stream::new(seed, t as u64);
        let dt = t as f64 - middle;
        Plane::from_fn(SIZE.0, SIZE.1, |u, v| {
            (scene(u as f64 - dt * slope.0, v as f64 - dt * slope.1) + sigma * noise.normal()) as f32
        })
    });
    Burst::from_planes("moving", planes.collect())
}

fn merged(burst: &Burst) -> Plane {
    let merged = merge_burst(burst, 0..burst.len(), &quiet()).expect("not cancelled");
    (*merged.frames[0]).clone()
}

/// Root mean square of the difference from the noiseless middle frame, over the pixels that all frames show (`border`
/// px are left out), or over the others.
fn error(image: &Plane, border: usize, within: bool) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for v in 0..SIZE.1 {
        for u in 0..SIZE.0 {
            let inside = (border..SIZE.0 - border).contains(&u) && (border..SIZE.1 - border).contains(&v);
            if inside == within {
                sum += (f64::from(image.at(u, v)) - scene(u as f64, v as f64)).powi(2);
                count += 1.0;
            }
        }
    }
    (sum / count).sqrt()
}

#[test]
fn noise_falls_nearly_as_much_as_it_can_and_borders_are_as_good_as_the_frames_that_show_them() {
    // Per-pixel ratios of the scene's standard deviation (0.06) to the noise from 3 down to 0.6.
    for (sigma, seed) in [(0.02, 1), (0.05, 2), (0.1, 3)] {
        for slope in [(0.0, 0.0), (2.0, -1.0), (1.3, 0.7), (-2.6, 0.4)] {
            let image = merged(&moving_burst(slope, sigma, 10, seed));
            let reduction = sigma / error(&image, 16, true);
            assert!(reduction > 0.8 * 10f64.sqrt(), "sigma {sigma}, slope {slope:?}: {reduction}");
        }
    }
    // At the border about half of the frames show a place, and nothing is darkened or mirrored into it.
    let sigma = 0.05;
    let image = merged(&moving_burst((2.0, -1.0), sigma, 10, 4));
    let reduction = sigma / error(&image, 10, false);
    assert!(reduction > 0.8 * 5f64.sqrt(), "{reduction}");
}

#[test]
fn what_moves_by_itself_becomes_no_ghost_and_one_frame_stays_as_it_is() {
    // A bright square that is in another place in every frame stands once, where the middle frame has it.
    let mut burst = moving_burst((0.0, 0.0), 0.01, 7, 5);
    for (t, frame) in burst.frames.iter_mut().enumerate() {
        let mut plane = (**frame).clone();
        (100..130).for_each(|v| plane.row_mut(v)[20 + 40 * t..50 + 40 * t].fill(1.0));
        *frame = Arc::new(plane);
    }
    let image = merged(&burst);
    for t in (0..7).filter(|t| *t != 3) {
        let (u, v) = (35 + 40 * t, 115);
        assert!((f64::from(image.at(u, v)) - scene(u as f64, v as f64)).abs() < 0.06, "a ghost of frame {t}");
    }
    assert!((image.at(155, 115) - 1.0).abs() < 0.05);
    let burst = moving_burst((1.0, 0.0), 0.05, 1, 6);
    assert_eq!(merged(&burst), *burst.frames[0]);
    for (width, height) in [(1, 1), (5, 40), (17, 3)] {
        let frames = (0..3).map(|t| Plane::from_fn(width, height, |u, v| (u + v + t) as f32 * 0.01)).collect();
        assert!(merged(&Burst::from_planes("tiny", frames)).data().iter().all(|x| x.is_finite()));
    }
    let constant = Burst::from_planes("flat", vec![Plane::from_fn(40, 40, |_, _| 0.25); 4]);
    assert!(merged(&constant).data().iter().all(|x| (x - 0.25).abs() < 1e-6));
}

#[test]
fn bits_do_not_depend_on_threads_cancelling_leaves_none_and_progress_rises_to_one() {
    let burst = moving_burst((1.3, 0.7), 0.05, 5, 7);
    assert_eq!(on_threads(1, || merged(&burst)), on_threads(5, || merged(&burst)));
    let burst = moving_burst((1.0, 0.0), 0.05, 4, 8);
    assert!(merge_burst(&burst, 0..4, &cancelled()).is_err());
    let heard = Arc::new(Mutex::new(Vec::new()));
    let sink = heard.clone();
    let monitor = Monitor::with_listener(move |p| sink.lock().expect("not poisoned").push((p.stage, p.fraction)));
    merge_burst(&burst, 0..4, &monitor).expect("not cancelled");
    let heard = heard.lock().expect("not poisoned");
    assert!(heard.iter().all(|(stage, _)| *stage == Stage::Merge));
    assert!(heard.windows(2).all(|w| w[0].1 <= w[1].1) && heard.last().is_some_and(|(_, fraction)| *fraction == 1.0));
}

#[test]
fn the_merge_is_searched_as_one_image_would_be() {
    let scene = SceneParams { width: 240, height: 180, frames: 6, layers: 1, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &quiet()).expect("a scene");
    let frames = Some(FrameRange { start: 1, end: 6 });
    let params = DetectorParams { method: Method::Merge, frames, ..DetectorParams::default() };
    let found = detect(&burst, &params, &quiet()).expect("detected");
    let merged = merge_burst(&burst, 1..6, &quiet()).expect("merged");
    let sift = DetectorParams { method: Method::Sift, ..DetectorParams::default() };
    let by_hand = detect(&merged, &sift, &quiet()).expect("detected");
    assert!(!found.features.is_empty());
    assert_eq!((&found.features, &found.descriptors), (&by_hand.features, &by_hand.descriptors));
    assert_eq!((found.frames_used, found.slopes.len()), (1..6, 1));
    // The gate uses the merged image's noise: less than half of a frame's.
    let one = detect(&burst, &sift, &quiet()).expect("detected").frame_noise;
    let ideal = one / 5f32.sqrt();
    assert!((found.frame_noise / ideal - 1.0).abs() < 0.15, "{} of {one}", found.frame_noise);
    let past = DetectorParams { frames: Some(FrameRange { start: 1, end: 7 }), ..params };
    assert!(prepare(&burst, &past, &quiet()).is_err_and(|error| error.subject == "frames"));
}
