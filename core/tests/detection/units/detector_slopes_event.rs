//! Tests of `detector::slopes::event`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::slopes::*;
use burstscope_core::plane::*;
use serde::Serialize;

#[test]
fn events_are_told_with_their_frames() {
    let told = |event: Event| {
        event.warning_of(&[0, 1, 2, 3, 4, 5]).map(|w| (w.kind, w.frames, w.number, w.text)).expect("told")
    };
    let (kind, frames, number, text) = told(Event::Order(vec![0, 1, 2, 4, 3, 5]));
    assert_eq!((kind, frames, number), (MotionWarningKind::OutOfOrder, vec![3, 4], 2.0));
    assert!(text.starts_with("frames 3 and 4, counted from 0, are exchanged"), "{text}");
    let (_, frames, _, text) = told(Event::Order(vec![0, 2, 3, 1, 4]));
    assert!(frames == [1, 2, 3] && text.contains("in the order 0, 2, 3, 1, 4"), "{text}");
    let (kind, frames, number, text) = told(Event::Missing { after: 2, count: 1 });
    assert_eq!((kind, frames, number), (MotionWarningKind::MissingFrames, vec![2], 1.0));
    assert!(text.starts_with("1 frame is missing between frames 2 and 3"), "{text}");
    let (kind, frames, number, text) = told(Event::Late { frame: 3, by: -0.5 });
    assert_eq!((kind, frames, number), (MotionWarningKind::Late, vec![3], -0.5));
    assert!(text.ends_with("0.5 frame intervals early"), "{text}");
    assert_eq!(Event::Nothing.warning_of(&[0, 1]), None);
}

#[test]
fn every_event_is_tried_once_and_has_times_of_its_own() {
    for frames in [4, 5, 7, 9, 12] {
        let all = Event::all(frames);
        let mut times: Vec<Vec<i64>> =
            all.iter().map(|event| event.times(frames).iter().map(|time| (4.0 * time) as i64).collect()).collect();
        times.sort();
        times.dedup();
        assert_eq!(times.len(), all.len(), "{frames}");
        assert!(!times.contains(&(0..frames as i64).map(|t| 4 * t).collect()), "{frames}");
    }
    // Of 24 orders of four frames half are the others the other way round, and one is their own.
    assert_eq!(Event::all(4).iter().filter(|event| event.is_order()).count(), 11);
}

#[test]
fn frames_are_sorted_by_their_times() {
    let found = UniformTimes::of(&Event::Order(vec![0, 2, 3, 1]), &[0, 1, 2, 4]);
    assert_eq!(found, UniformTimes { frames: vec![0, 2, 4, 1], times: vec![0.0, 1.0, 2.0, 3.0] });
    let found = UniformTimes::of(&Event::Late { frame: 0, by: -0.5 }, &[0, 1, 2, 3]);
    assert_eq!(found.times, [0.0, 1.5, 2.5, 3.5]);
}

#[test]
fn copies_are_told_unless_everything_is_one() {
    let planes: Vec<Plane> = (0..6).map(|t| Plane::from_fn(3, 2, |u, _| (u + t / 2) as f32)).collect();
    let of = |which: &[usize]| copies(&which.iter().map(|t| &planes[*t]).collect::<Vec<_>>());
    assert_eq!(of(&[0, 2, 4, 0, 0]), [4]);
    assert_eq!(of(&[0, 1, 2, 3, 4, 5]), [] as [usize; 0], "three are left");
    assert_eq!(of(&[0, 0, 0, 0, 0]), [] as [usize; 0]);
    let told = copies_warning(vec![1, 4]).expect("told");
    assert_eq!((told.kind, told.number), (MotionWarningKind::Doubled, 2.0));
    assert_eq!(copies_warning(Vec::new()), None);
}

