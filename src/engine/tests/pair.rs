//! A second burst, and the matches between the two.

use super::{PATIENCE, nobody, small_burst, stack_request, wait_for};
use crate::detector::{Detection, DetectorParams, Feature, SlopeGrid};
use crate::engine::{DEFAULT_CACHE_BYTES, Engine, PairJobs, PairUpdate};
use crate::monitor::Monitor;
use crate::requests::{BurstSource, DetectRequest, JobError, MatchRequest, PatchesRequest};
use std::sync::Arc;
use std::time::Duration;

/// A detection of `count` features with descriptors that are all different.
fn detection(count: usize, moved: f32) -> Arc<Detection> {
    let slopes = SlopeGrid::line(-1.0..=1.0, 3);
    let feature = |i: usize| Feature {
        u: (37 * i % 101) as f32 + moved,
        v: (53 * i % 89) as f32,
        sigma: 2.0,
        orientation: 0.0,
        slope: slopes.slope(1),
        response: 0.1,
        snr: 9.0,
        octave: 0,
        level: 0,
        slope_index: 1,
        at_slope_limit: false,
    };
    let mut descriptors = vec![[0u8; 128]; count];
    for (i, descriptor) in descriptors.iter_mut().enumerate() {
        for (j, element) in descriptor.iter_mut().enumerate() {
            *element = ((i * 7919 + j * 104_729) % 251) as u8;
        }
    }
    Arc::new(Detection {
        features: (0..count).map(feature).collect(),
        descriptors,
        tally: Default::default(),
        frame_noise: 0.01,
        noise: std::sync::Arc::default(),
        noise_gate_factor: 4.5,
        slopes,
        frames_used: 0..3,
        octaves: 0..1,
        times: Default::default(),
    })
}

fn pair_update<T>(engine: &Engine, pick: impl Fn(PairUpdate) -> Option<T>) -> T {
    wait_for(|| engine.pair().poll().into_iter().find_map(&pick))
}

#[test]
fn matches_are_those_of_the_library() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let request = MatchRequest { a: detection(40, 0.0), b: detection(40, 3.0), params: Default::default() };
    engine.pair().match_features(request.clone());
    let matched = pair_update(&engine, |u| match u {
        PairUpdate::Matched(answer) => Some(answer.result.expect("valid")),
        _ => None,
    });
    let expected = crate::matching::match_detections(&request.a, &request.b, &request.params, &Monitor::default());
    assert_eq!(Ok(&*matched.result), expected.as_ref());
    assert!(matched.request.same_matches(&request));
    assert_eq!(matched.result.matches.len(), 40);
    assert!(!matched.request.same_matches(&MatchRequest { a: detection(40, 0.0), ..request }));
}

#[test]
fn a_long_matching_can_be_cancelled() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let request = MatchRequest { a: detection(60_000, 0.0), b: detection(60_000, 3.0), params: Default::default() };
    engine.pair().match_features(request);
    wait_for(|| engine.pair().running(PairJobs::Match).filter(|r| r.started.elapsed() > Duration::from_millis(20)));
    engine.pair().cancel(PairJobs::Match);
    // It tells how far it is until it ends.
    let mut done = 0.0f32;
    let result = wait_for(|| {
        let progress = engine.pair().running(PairJobs::Match).and_then(|running| running.progress);
        done = progress.map_or(done, |progress| done.max(progress.fraction));
        engine.pair().poll().into_iter().find_map(|update| match update {
            PairUpdate::Matched(answer) => Some(answer.result),
            _ => None,
        })
    });
    assert!(matches!(result, Err(JobError::Cancelled)), "{:?}", result.map(|m| m.result.counts));
    assert!(done < 0.5, "{done} of it was done all the same");
}

#[test]
fn patches_come_together_and_from_the_cache() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let (a, b) = (small_burst(), small_burst());
    let request = PatchesRequest { a: stack_request(&a, 0.5), b: stack_request(&b, -0.5) };
    let patches = |engine: &Engine| {
        engine.pair().request_patches(request.clone());
        pair_update(engine, |u| match u {
            PairUpdate::Patches(answer) => Some(answer.result.expect("valid")),
            _ => None,
        })
    };
    let (first, second) = (patches(&engine), patches(&engine));
    assert!(Arc::ptr_eq(&first.a.plane, &second.a.plane) && Arc::ptr_eq(&first.b.plane, &second.b.plane));
    assert_eq!((first.a.request.burst.id, first.b.request.burst.id), (a.id, b.id));
    assert!(engine.wait_idle(PATIENCE));
}

#[test]
fn the_second_burst_is_opened_and_searched_beside_the_first() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    engine.pair().open(BurstSource::DemoLater);
    let burst = pair_update(&engine, |u| match u {
        PairUpdate::Opened(answer) => Some(answer.result.expect("built in")),
        _ => None,
    });
    assert_eq!(burst.burst.name, "demo-later");
    engine.pair().detect(DetectRequest { burst: burst.clone(), params: DetectorParams::default().into() });
    let detected = pair_update(&engine, |u| match u {
        PairUpdate::Detected(answer) => Some(answer.result.expect("valid")),
        _ => None,
    });
    let expected =
        crate::detector::detect(&burst.burst, &DetectorParams::default(), &Monitor::default()).expect("valid");
    assert_eq!(detected.detection.features, expected.features);
}
