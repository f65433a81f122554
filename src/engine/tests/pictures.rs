//! Pictures: which are the same, how they are made, and how many are kept.

use super::{PATIENCE, answer_of, end_of, engine, small_burst, stack_request};
use crate::detector::{DetectorParams, FrameRange, Slope};
use crate::engine::{PictureCache, Wanted};
use crate::monitor::Monitor;
use crate::requests::{PictureKind, PictureRequest, Request, Work};
use std::sync::Arc;
use std::time::Duration;

#[test]
fn the_cache_keeps_its_budget_and_drops_the_least_recently_used() {
    let burst = small_burst();
    let one = 40 * 32 * 4;
    let mut cache = PictureCache::new(3 * one);
    let requests: Vec<_> = (0..4).map(|i| stack_request(&burst, i as f32)).collect();
    let monitor = Monitor::default();
    for request in &requests[..3] {
        cache.insert(&request.clone().compute(&Work::alone(&monitor)).expect("not cancelled"));
    }
    assert_eq!(cache.bytes(), 3 * one);
    assert!(cache.get(&requests[0]).is_some());
    cache.insert(&requests[3].clone().compute(&Work::alone(&monitor)).expect("not cancelled"));
    assert_eq!((cache.len(), cache.bytes()), (3, 3 * one));
    assert!(cache.get(&requests[1]).is_none(), "the one not used for longest went");
    assert!(cache.get(&requests[0]).is_some() && cache.get(&requests[3]).is_some());
    let mut tiny = PictureCache::new(one - 1);
    tiny.insert(&requests[0].clone().compute(&Work::alone(&monitor)).expect("not cancelled"));
    assert!(tiny.is_empty());
}

#[test]
fn only_what_decides_a_picture_makes_it_another() {
    let burst = small_burst();
    let request = stack_request(&burst, 1.0);
    let mut other = request.clone();
    other.params.peak_threshold = 0.5;
    other.params.levels = 5;
    assert!(request.is_same(&other));
    other.params.frames = Some(FrameRange { start: 0, end: 2 });
    assert!(!request.is_same(&other));
    let reopened = PictureRequest::new(small_burst(), request.kind, request.params.clone());
    assert!(!request.is_same(&reopened), "another opening may have other pixels");
}

#[test]
fn a_picture_asked_for_again_comes_from_the_cache() {
    let (engine, burst, mut wanted) = (engine(), small_burst(), Wanted::default());
    wanted.ask(&engine, stack_request(&burst, 0.5));
    let first = end_of(&mut wanted).result.expect("valid");
    // Whoever asks for it.
    let mut other = Wanted::default();
    other.ask(&engine, stack_request(&burst, 0.5));
    let second = end_of(&mut other);
    assert_eq!(second.elapsed, Duration::ZERO);
    assert!(Arc::ptr_eq(&first.plane, &second.result.expect("valid").plane));
    assert!(engine.wait_idle(PATIENCE));
}

#[test]
fn a_difference_is_one_picture_less_the_other_on_the_pixels_of_the_first() {
    let (burst, monitor) = (small_burst(), Monitor::default());
    let (a, b) = (stack_request(&burst, 0.5), stack_request(&burst, -1.0));
    let wanted = a.clone().less(&b);
    assert!(!wanted.is_same(&a) && !wanted.is_same(&b.clone().less(&a)));
    let answer = answer_of(&engine(), wanted.clone());
    assert!(answer.request.is_same(&wanted));
    let planes = [&a, &b].map(|request| request.clone().compute(&Work::alone(&monitor)).expect("not cancelled").plane);
    for (i, value) in answer.plane.data().iter().enumerate() {
        assert_eq!(*value, planes[0].data()[i] - planes[1].data()[i]);
    }
    // Half the pixels: the first picture's, whichever it is.
    let dog = PictureKind::Dog { octave: 1, level: 0, slope: Slope::new(0.5, 0.0) };
    let coarse = PictureRequest::new(burst, dog, DetectorParams::default());
    let size = coarse.clone().compute(&Work::alone(&monitor)).expect("not cancelled").plane.size();
    assert_eq!(coarse.less(&a).compute(&Work::alone(&monitor)).expect("not cancelled").plane.size(), size);
}

#[test]
fn the_merged_frames_are_those_of_the_baseline() {
    let burst = small_burst();
    let request = PictureRequest::new(burst.clone(), PictureKind::Merge, DetectorParams::default());
    let merged = crate::baseline::merge_burst(&burst.burst, 0..3, &Monitor::default()).expect("merged");
    assert_eq!(request.compute(&Work::alone(&Monitor::default())).expect("merged").plane, merged.frames[0]);
}
