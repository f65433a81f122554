//! Tests of the pair: B supports the same work as A, linked cursors follow, and matches are requested, marked stale and
//! selected again.

use crate::app::results::pair::*;
use crate::app::results::tests::{detected, feature, open};
use crate::detector::{Detection, FrameRange};
use crate::matching::MatchParams;
use crate::monitor::Monitor;
use crate::requests::Detected;
use crate::teach::Workspace;
use std::sync::Arc;
use std::time::Duration;

/// A model with two bursts and the features of both; B's are A's, moved by (2, 0).
pub(in crate::app::results) fn pair() -> Model {
    let mut model = Model::default();
    model.document.workspace = Workspace::Pair;
    let (a, b) = (open((64, 48), 5), open((64, 48), 5));
    model.take_burst(a.clone());
    model.take_second_burst(b.clone());
    let grid = model.document.params.slopes;
    let at = |du: f32| -> Vec<_> {
        (0..4).map(|i| feature(8.0 + 12.0 * i as f32 + du, 10.0 + 7.0 * i as f32, i, &grid)).collect()
    };
    let with_descriptors = |mut found: Detected| {
        let mut detection = Detection::clone(&found.detection);
        for (i, descriptor) in detection.descriptors.iter_mut().enumerate() {
            descriptor[10 * i] = 200;
        }
        found.detection = Arc::new(detection);
        found
    };
    let params = model.document.params.clone();
    model.take_detection(Side::A, with_descriptors(detected(&a, &params, at(0.0))), Duration::ZERO);
    model.take_detection(Side::B, with_descriptors(detected(&b, &params, at(2.0))), Duration::ZERO);
    model
}

fn matched(model: &Model) -> Matches {
    let request = model.wanted_matches().expect("both sides have features");
    Matches::new(request.matched(&Monitor::default()).expect("valid"), Duration::ZERO)
}

#[test]
fn a_second_burst_has_the_parameters_as_far_as_it_can_use_them() {
    let mut model = pair();
    model.document.params.frames = Some(FrameRange { start: 1, end: 5 });
    assert_eq!(model.params_of(Side::B).frames, model.document.params.frames);
    model.take_second_burst(open((64, 48), 3));
    assert_eq!(model.params_of(Side::B).frames, None);
    model.take_second_burst(open((64, 48), 1));
    model.check_params();
    assert_eq!(model.params_of(Side::B).method, Method::Sift);
    assert_eq!(model.results.slots.b.param_error, None, "a single sharp image can be B");
    assert_eq!(model.params_of(Side::A).method, Method::Buff);
}

#[test]
fn panes_begin_alike_whichever_burst_is_opened_last() {
    let opened = |last: Side| {
        let mut model = Model::default();
        model.document.workspace = Workspace::Pair;
        for side in [last.other(), last] {
            let burst = open((150, 60), 5);
            if side == Side::A { model.take_burst(burst) } else { model.take_second_burst(burst) }
        }
        model.document.panes.clone()
    };
    assert!(opened(Side::A) == opened(Side::B));
}

#[test]
fn matches_are_wanted_until_they_are_there_and_again_when_something_changed() {
    let mut model = pair();
    assert!(model.needs_matches());
    model.take_made_matches(matched(&model));
    model.refresh_listed_matches();
    assert!(!model.needs_matches());
    assert_eq!((model.results.pair.listed.len(), model.stale_matches()), (4, None));
    model.document.matching.ratio = 0.7;
    assert!(model.needs_matches());
    assert!(model.stale_matches().is_some_and(|why| why.contains("matching")));
    model.document.matching.ratio = 2.0;
    model.check_params();
    assert!(!model.needs_matches(), "parameters that make no sense are not tried");
    assert_eq!(model.results.pair.param_error.as_ref().map(|e| e.subject.as_str()), Some("ratio"));
    model.document.matching = MatchParams::default();
    model.check_params();
    model.document.params.edge_threshold *= 2.0;
    assert!(model.stale_matches().is_some_and(|why| why.contains("detector")));
    model.take_burst(open((64, 48), 5));
    assert!(model.results.pair.matches.is_none(), "the matches were with another burst");
}

#[test]
fn the_same_match_stays_selected_when_it_is_made_again() {
    let mut model = pair();
    model.take_made_matches(matched(&model));
    model.document.selected_match = Some(2);
    let place = model.read().saved_match().expect("selected");
    model.document.matching.geometry = crate::matching::Geometry::None;
    model.take_made_matches(matched(&model));
    assert_eq!(model.document.selected_match, Some(2));
    assert_eq!(model.read().saved_match(), Some(place));
    let moved = SavedMatch { a: [place.a[0] + 3.0, place.a[1]], ..place };
    assert_eq!(model.results.pair.matches.as_ref().and_then(|m| m.find_again(&moved)), None);
}

#[test]
fn sides_are_swapped_with_everything_that_is_theirs() {
    let mut model = pair();
    model.take_made_matches(matched(&model));
    let ids = [Side::A, Side::B].map(|side| model.burst_of(side).expect("open").id);
    let found = model.found_of(Side::B).expect("found").detection.clone();
    model.swap_sides();
    assert_eq!([Side::B, Side::A].map(|side| model.burst_of(side).expect("open").id), ids);
    assert!(Arc::ptr_eq(&model.found_of(Side::A).expect("found").detection, &found));
    assert!(model.results.pair.matches.is_none() && model.needs_matches());
}
