//! A second burst, and the matches between the two.

use super::{PATIENCE, answer_of, end_of, engine, small_burst, stack_request, wait_for};
use crate::burst::OpenOptions;
use crate::detector::{Detection, DetectorParams, Feature, SlopeGrid};
use crate::engine::Wanted;
use crate::monitor::Monitor;
use crate::requests::{BurstSource, DetectRequest, JobError, MatchRequest, OpenRequest, PicturesRequest, Request};
use std::sync::Arc;
use std::time::Duration;

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

#[test]
fn matches_are_those_of_the_library() {
    let request = MatchRequest { a: detection(40, 0.0), b: detection(40, 3.0), params: Default::default() };
    let matched = answer_of(&engine(), request.clone());
    let expected = crate::matching::match_detections(&request.a, &request.b, &request.params, &Monitor::default());
    assert_eq!(Ok(&*matched.result), expected.as_ref());
    assert!(matched.request.is_same(&request));
    assert_eq!(matched.result.matches.len(), 40);
    assert!(!matched.request.is_same(&MatchRequest { a: detection(40, 0.0), ..request }));
}

#[test]
fn a_long_matching_can_be_cancelled() {
    let (engine, mut matching) = (engine(), Wanted::default());
    let request = MatchRequest { a: detection(60_000, 0.0), b: detection(60_000, 3.0), params: Default::default() };
    matching.ask(&engine, request);
    // It tells how far it is until it ends.
    let mut done = 0.0f32;
    let mut look = |matching: &mut Wanted<MatchRequest>| {
        let ended = matching.take().into_iter().next();
        let progress = matching.running().and_then(|running| running.progress);
        done = progress.map_or(done, |progress| done.max(progress.fraction));
        (ended, done)
    };
    wait_for(|| {
        let (ended, _) = look(&mut matching);
        assert!(ended.is_none(), "it takes long");
        matching.running().filter(|running| running.started.elapsed() > Duration::from_millis(20))
    });
    matching.cancel();
    let result = wait_for(|| look(&mut matching).0).result;
    assert!(matches!(result, Err(JobError::Cancelled)), "{:?}", result.map(|m| m.result.counts));
    assert!(done < 0.5, "{done} of it was done all the same");
}

#[test]
fn patches_come_together_and_from_the_cache() {
    let (engine, a, b) = (engine(), small_burst(), small_burst());
    let request = PicturesRequest(vec![stack_request(&a, 0.5), stack_request(&b, -0.5)]);
    let (first, second) = (answer_of(&engine, request.clone()), answer_of(&engine, request));
    assert!(first.iter().zip(&second).all(|(first, second)| Arc::ptr_eq(&first.plane, &second.plane)));
    assert!(first.iter().map(|picture| picture.request.burst.id).eq([a.id, b.id]));
    assert!(engine.wait_idle(PATIENCE));
}

#[test]
fn two_bursts_are_opened_and_searched_side_by_side() {
    let engine = engine();
    let mut opening: [Wanted<OpenRequest>; 2] = Default::default();
    for (wanted, source) in opening.iter_mut().zip([BurstSource::Demo, BurstSource::DemoLater]) {
        wanted.ask(&engine, OpenRequest { source, options: OpenOptions::default() });
    }
    let bursts = opening.each_mut().map(|wanted| end_of(wanted).result.expect("built in"));
    assert_eq!(bursts.each_ref().map(|open| open.burst.name.as_str()), ["demo", "demo-later"]);
    let params = DetectorParams::default();
    let mut detecting: [Wanted<DetectRequest>; 2] = Default::default();
    for (wanted, burst) in detecting.iter_mut().zip(&bursts) {
        wanted.ask(&engine, DetectRequest { burst: burst.clone(), params: params.clone().into() });
    }
    for (wanted, open) in detecting.iter_mut().zip(&bursts) {
        let detected = end_of(wanted).result.expect("valid");
        let expected = crate::detect(&open.burst, &params, &Monitor::default()).expect("valid");
        assert_eq!(detected.detection.features, expected.features);
    }
}
