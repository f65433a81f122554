//! Tests of trails: a detection that keeps its trail finds the same features, and later requests do not search again.

use super::{answer_of, engine};
use crate::detect::{Searched, search};
use crate::detector::{DetectorParams, Distinct, Method, NoiseGate, SearchParams, SlopeGrid, Slopes};
use crate::engine::Engine;
use crate::inspect::ProbeCache;
use crate::inspect::place::SurveyOptions;
use crate::monitor::Monitor;
use crate::requests::{
    BurstSource, ComparisonRequest, DetectRequest, Detected, DetectionSource, ExplainQuestion, ExplainRequest,
    OpenBurst, PictureKind, PictureRequest, ReferenceSource, Trails, ViewKind,
};
use crate::synth::{Example, demo_burst};
use std::sync::Arc;

fn burst() -> OpenBurst {
    OpenBurst::new(Example::LowContrast.burst(), BurstSource::Example(Example::LowContrast))
}

fn with(method: Method, slopes: SlopeGrid) -> SearchParams {
    DetectorParams { method, slopes, octaves: 2, ..DetectorParams::default() }.into()
}

fn line(count: usize) -> SlopeGrid {
    SlopeGrid::line(-1.0..=1.0, count)
}

fn source(burst: &OpenBurst, params: &SearchParams) -> DetectionSource {
    DetectionSource { burst: burst.clone(), asked: params.clone(), params: params.at_given(), finding: None }
}

fn detected(engine: &Engine, burst: &OpenBurst, params: &SearchParams) -> Detected {
    answer_of(engine, DetectRequest { burst: burst.clone(), params: params.clone() })
}

#[test]
fn a_detection_that_keeps_its_trail_is_the_plain_one() {
    let (engine, burst) = (engine(), burst());
    let auto = SearchParams { slopes: Slopes::AUTO, ..with(Method::Buff, line(3)) };
    let asked = [
        with(Method::Buff, line(5)),
        with(Method::Buff, SlopeGrid::plane(-1.0..=1.0, 3, -1.0..=1.0, 3)),
        with(Method::Merge, line(5)),
        with(Method::Sift, line(5)),
        auto,
    ];
    for params in asked {
        let found = detected(&engine, &burst, &params);
        let Searched { detection: plain, params: made_with, finding, .. } =
            search(&burst.burst, &params, &Monitor::default()).expect("valid");
        assert!(!plain.features.is_empty(), "{params:?}");
        assert_eq!(found.detection.features, plain.features);
        assert_eq!(found.detection.descriptors, plain.descriptors);
        assert_eq!(found.detection.tally, plain.tally);
        assert_eq!(found.detection.slopes, plain.slopes);
        assert_eq!(found.detection.frames_used, plain.frames_used);
        assert_eq!((&found.params, &found.asked, &found.finding), (&made_with, &params, &finding));
        let Detected { asked, params, finding, .. } = found;
        let kept = engine.caches.trails.get(&DetectionSource { burst: burst.clone(), asked, params, finding });
        assert_eq!(kept.expect("it fits").detection().features, plain.features);
    }
}

#[test]
fn a_change_of_thresholds_is_judged_from_what_the_last_search_left() {
    let (engine, burst) = (engine(), burst());
    let first = with(Method::Buff, line(5));
    let changed = |change: fn(&mut SearchParams)| {
        let mut params = first.clone();
        change(&mut params);
        params
    };
    let all = detected(&engine, &burst, &first);
    for params in [
        changed(|detector| detector.max_features = 5),
        changed(|detector| detector.distinct = Distinct::Off),
        changed(|detector| detector.noise_gate = NoiseGate::Factor(7.0)),
        changed(|detector| detector.peak_threshold = 0.002),
        // Back, and less strict than the judgement before.
        first.clone(),
    ] {
        let found = detected(&engine, &burst, &params);
        let plain = search(&burst.burst, &params, &Monitor::default()).expect("valid").detection;
        assert!(!plain.features.is_empty(), "{params:?}");
        assert_eq!((&found.detection.features, &found.params), (&plain.features, &params.at_given()));
        assert!(found.detection.descriptors == plain.descriptors);
        assert_eq!(found.detection.times.noise_secs, 0.0, "it was not searched again: {params:?}");
        assert_eq!(engine.caches.trails.held().0, 1, "one stands for all");
    }
    // A trail that was replaced is judged again where somebody asks for it.
    let trail = engine.caches.trails.get_or_make(&source(&burst, &first), &Monitor::default()).expect("valid");
    assert_eq!(trail.detection().features, all.detection.features);
    // What the search did not leave is searched anew.
    let found = detected(&engine, &burst, &changed(|detector| detector.noise_gate = NoiseGate::Factor(3.0)));
    assert!(found.detection.features.len() > all.detection.features.len());
    assert!(found.detection.times.noise_secs > 0.0);
    assert_eq!(detected(&engine, &burst, &first).detection.features, all.detection.features);
}

#[test]
fn nobody_who_asks_after_a_detection_searches_again() {
    let engine = engine();
    // The truth of the demo is known.
    let burst = OpenBurst::new(demo_burst(), BurstSource::Demo);
    let params = with(Method::Buff, line(5));
    let found = detected(&engine, &burst, &params);
    let of = source(&burst, &params);
    let answer = |question| {
        answer_of(&engine, ExplainRequest { of: of.clone(), question });
    };
    answer(ExplainQuestion::Slopes);
    answer(ExplainQuestion::Candidates(SurveyOptions::default()));
    let traced = answer_of(&engine, of.clone());
    assert!(Arc::ptr_eq(&traced.cache, &engine.caches.trails.get(&of).expect("kept")));
    let truth = ReferenceSource::Truth { burst: burst.clone(), params: params.at_given() };
    answer_of(&engine, ComparisonRequest { detection: found.detection.clone(), with: truth });
    let motion = PictureKind::Map { map: ViewKind::Motion, octave: 0, level: 0, slope: line(5).slope(0) };
    answer_of(&engine, PictureRequest::new(burst.clone(), motion, params.at_given()));
    assert_eq!(engine.caches.trails.repeated(), 0);
    // A repeated detection takes the kept trail.
    let again = detected(&engine, &burst, &params);
    assert_eq!(again.detection.times, found.detection.times, "it was not searched again");
    engine.keep_trails_of(&[burst.id]);
    assert!(engine.caches.trails.get(&of).is_some());
    engine.keep_trails_of(&[self::burst().id]);
    assert!(engine.caches.trails.get(&of).is_none());
    answer(ExplainQuestion::Slopes);
    assert_eq!(engine.caches.trails.repeated(), 1);
}

#[test]
fn the_same_search_in_other_words_is_the_same_search() {
    let (trails, burst, monitor) = (Trails::default(), burst(), Monitor::default());
    let given = with(Method::Buff, line(3));
    trails.get_or_make_for(&burst, &given.at_given(), &monitor).expect("valid");
    let auto = SearchParams { slopes: Slopes::AUTO, ..given.clone() };
    let of = DetectionSource { asked: auto.clone(), ..source(&burst, &given) };
    let cache = trails.get_or_make(&of, &monitor).expect("valid");
    assert_eq!((&cache.asked, trails.repeated()), (&auto, 1));
    assert!(Arc::ptr_eq(&cache, &trails.get(&of).expect("kept")), "of the same words it stays the same one");
    assert!(trails.asked(&burst, &auto).is_some());
    // Another opening of the same files may have other pixels.
    assert!(trails.get(&source(&self::burst(), &given)).is_none());
}

#[test]
fn those_who_ask_at_once_have_it_made_once() {
    let (trails, burst) = (Trails::default(), burst());
    let of = source(&burst, &with(Method::Buff, line(3)));
    let caches: Vec<Arc<ProbeCache>> = std::thread::scope(|scope| {
        let ask = || trails.get_or_make(&of, &Monitor::default()).expect("valid");
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(ask)).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    assert_eq!(trails.repeated(), 1);
    assert!(caches.iter().all(|cache| Arc::ptr_eq(cache, &caches[0])));
    // A cancelled search leaves no mark for which others would wait.
    let other = source(&burst, &with(Method::Buff, line(4)));
    let cancelled = Monitor::default();
    cancelled.cancel();
    trails.get_or_make(&other, &cancelled).expect_err("cancelled");
    trails.get_or_make(&other, &Monitor::default()).expect("valid");
}

#[test]
fn what_was_not_used_for_longest_goes_and_what_is_asked_for_stays() {
    let (burst, monitor) = (burst(), Monitor::default());
    let params: Vec<SearchParams> = (3..6).map(|count| with(Method::Buff, line(count))).collect();
    let made = |params| Arc::new(ProbeCache::new(&burst.burst, params, &monitor).expect("valid"));
    let caches: Vec<Arc<ProbeCache>> = params.iter().map(made).collect();
    let bytes: Vec<usize> = caches.iter().map(|cache| cache.bytes_beside(&burst.burst)).collect();
    // The coarser octave of three slopes and more, four bytes a pixel.
    let (width, height) = burst.burst.size();
    assert!(bytes[0] > 3 * (width / 2) * (height / 2) * 4 && bytes[2] > bytes[0], "{bytes:?}");
    assert!(bytes[2] < Trails::default().budget_bytes(), "{bytes:?}");
    let kept = |trails: &Trails| params.iter().map(|p| trails.asked(&burst, p).is_some()).collect::<Vec<_>>();

    let two = Trails::new(bytes[0] + bytes[2]);
    two.put(&burst, &caches[0]);
    two.put(&burst, &caches[1]);
    assert!(two.asked(&burst, &params[0]).is_some(), "used last");
    two.put(&burst, &caches[2]);
    assert_eq!(kept(&two), [true, false, true]);

    let none = Trails::new(bytes[0] - 1);
    none.put(&burst, &caches[0]);
    assert_eq!(kept(&none), [false; 3], "nobody asked for it");
    none.get_or_make(&source(&burst, &params[0]), &monitor).expect("valid");
    none.put(&burst, &caches[1]);
    assert_eq!(kept(&none), [true, false, false], "whoever asks mostly asks again");
    none.get_or_make(&source(&burst, &params[1]), &monitor).expect("valid");
    assert_eq!((kept(&none), none.repeated()), (vec![false, true, false], 2));
}
