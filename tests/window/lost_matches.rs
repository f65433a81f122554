//! Reasons why features have no match, and the numbers lost at each stage.

use crate::support::*;
use burstscope::inspect::pair::{Losses, Lost};

fn two_bursts() -> Window {
    let mut window = Start::two_bursts([1280.0, 900.0]).open();
    window.change(|document| document.workspace = Workspace::Pair).settle();
    window
}

#[test]
fn the_pair_says_what_was_lost_where_and_a_feature_that_is_clicked_says_why() {
    let mut window = two_bursts();
    let found = window.read().losses().expect("the losses are known").clone();
    let losses = Losses::new(found.request.pair(), &Monitor::default()).unwrap();
    let expected = losses.counts(&Monitor::default()).unwrap();
    assert_eq!(found.counts, expected);
    let count = |lost: Lost| expected.iter().find(|(at, _)| *at == lost).unwrap().1;
    window.click("Unmatched").settle();
    // Other orientations of a keypoint are told with the first one.
    let lost = &window.results().pair.lost;
    let told = |step: Lost| lost.count(step);
    assert!(told(Lost::RatioTest) <= count(Lost::RatioTest) && told(Lost::MutualCheck) < count(Lost::MutualCheck));
    assert!(window.shows(&format!("ratio test {}", told(Lost::RatioTest))));
    assert!(window.shows(&format!("no keypoint {}", told(Lost::NoKeypoint))));
    let is_listed = |index: &usize| found.lost[*index] != Lost::Not && lost.twin(*index).is_none();
    let index = (0..found.lost.len()).find(is_listed).expect("some have no match");
    let outliers = found.request.result.counts.putative - found.request.result.counts.inliers.unwrap();
    assert_eq!((count(Lost::Geometry), window.results().pair.lost.count(Lost::Geometry)), (outliers, outliers));
    window.click_on(Role::Row, &format!("Unmatched feature {index}")).settle();
    assert_eq!(window.read().asked_feature(), Some(index));
    let why = losses.of(index, 5);
    let words: String = why.sentence.chars().skip(1).collect();
    assert!(window.shows(&words), "{}", why.sentence);
    assert!(window.has(Role::Image, "Patch of candidate 1"));
    window.snapshot("unmatched_feature").key(Key::Escape);
    assert_eq!(window.read().asked_feature(), None);
    let a = found.request.request.a.clone();
    // A feature far from the others, so that the click is unambiguous.
    let apart = |i: usize, j: usize| (a.features[i].u - a.features[j].u).hypot(a.features[i].v - a.features[j].v);
    let alone = |i: usize| (0..a.features.len()).filter(|&j| j != i).map(|j| apart(i, j)).fold(f32::MAX, f32::min);
    let lost = (0..a.features.len()).filter(|&i| matches!(found.lost[i], Lost::RatioTest | Lost::NoKeypoint));
    let index = lost.max_by(|&i, &j| alone(i).total_cmp(&alone(j))).expect("some have no match");
    let f = a.features[index];
    window.set().match_look.inliers = false;
    window.set().match_look.outliers = false;
    let pane = burstscope::app::pane::PaneId::of(burstscope::app::document::side::Side::A);
    window.change(|document| document.panes.get_mut(pane).unwrap().view.look_at(pos2(f.u, f.v), 8.0)).settle();
    let side = burstscope::app::document::side::Side::A;
    window.click_at(window.ui_from_image_of(side, pos2(f.u, f.v)).unwrap()).settle();
    let asked = window.read().asked_feature().expect("a feature is asked about");
    assert_eq!((a.features[asked].u, a.features[asked].v), (f.u, f.v));
    assert!(window.document().selected_match.is_none());
}

#[test]
fn where_b_has_no_keypoint_its_place_is_probed_with_one_click() {
    let mut window = two_bursts();
    // The strongest of A are not all among the strongest of B.
    window.change(|document| document.params.max_features = 300).run_action("detect").settle();
    let found = window.read().losses().expect("the losses are known").clone();
    let losses = Losses::new(found.request.pair(), &Monitor::default()).unwrap();
    let missing = (0..found.lost.len())
        .find(|&index| found.lost[index] == Lost::NoKeypoint && !losses.of(index, 5).expected.is_empty())
        .expect("the geometry puts one where no keypoint is");
    let names = |window: &Window| Side::BOTH.map(|side| window.read().burst_of(side).unwrap().burst.name.clone());
    let before = names(&window);
    assert_eq!(before, ["demo", "demo-later"]);
    apply::pair::ask_feature(&mut window.app_mut().model, Some(missing));
    window.settle();
    let place = window.read().expected_place().expect("a place in B");
    window.click("Probe its place in B").settle();
    assert_eq!((window.document().workspace, names(&window)), (Workspace::Pair, before.clone()), "nothing is swapped");
    let probed = |window: &Window| {
        assert!(window.read().probe_is_current(), "{:?}", window.results().probed.problem);
        assert!(window.document().probe.is_open, "{:?}", window.results().probed.problem);
        let answer = window.results().probed.answer.as_ref().unwrap();
        assert_eq!(answer.probe.pos_image, place);
        (window.document().probe.side, answer.request.traced.cache.burst.name.clone())
    };
    assert_eq!(probed(&window), (Side::B, before[1].clone()));
    assert!(window.shows(" of B"), "the panel says of which burst");
    // When the sides are swapped, the place stays one of its burst.
    window.run_action("swap a and b").settle();
    assert_eq!((names(&window), probed(&window)), ([1, 0].map(|i| before[i].clone()), (Side::A, before[1].clone())));
}

#[test]
fn a_feature_without_a_match_has_a_remedy_that_keeps_what_it_promises() {
    let mut window = two_bursts();
    let found = window.read().losses().expect("the losses are known").clone();
    let mut kept = 0;
    let candidates = (0..found.lost.len()).filter(|&i| matches!(found.lost[i], Lost::RatioTest | Lost::Geometry));
    for index in candidates.step_by(5).take(12) {
        apply::pair::ask_feature(&mut window.app_mut().model, Some(index));
        window.settle();
        let Some(params) = window.read().remedy() else { continue };
        let price = window.read().price_of_remedy(&params).expect("it was tried");
        assert!(window.shows(&price), "{price}");
        let Some(others) = price.strip_prefix("matches it and ") else { continue };
        let others: usize = others.split(' ').next().unwrap().parse().unwrap();
        let inliers = |window: &Window| window.matches().result.counts.inliers.unwrap();
        let before = inliers(&window);
        let apply = window.harness.get_by_label_contains("Apply ").rect().center();
        window.click_at(apply).settle();
        assert_eq!(inliers(&window), before + 1 + others, "{price}");
        assert_eq!(window.read().losses().expect("known").lost[index], Lost::Not);
        window.ctrl(Key::Z).settle();
        assert_eq!(inliers(&window), before);
        kept += 1;
        if kept == 2 {
            return;
        }
    }
    assert!(kept > 0, "none of the features could be matched");
}

#[test]
fn an_outlier_says_the_limit_motions_filter_the_matches_and_a_match_tells_its_second_best() {
    let mut window = two_bursts();
    let pair = &window.results().pair;
    let matches = pair.matches.as_ref().unwrap();
    let outlier = matches.rows().find(|row| row.inlier == Some(false)).expect("some do not fit").index;
    let limits = matches.rows().map(|row| (row.inlier, row.error_px, matches.passed_limit(&row)));
    for (inlier, error, limit) in limits {
        assert_eq!(limit.is_some(), inlier == Some(false));
        assert!(inlier != Some(true) || error.unwrap() <= matches.max_error_px());
    }
    let contradicted = &matches.result.alignment.as_ref().unwrap().contradicted;
    let said = |index: &usize| matches.passed_limit(&matches.row(*index).unwrap()).unwrap();
    assert!(!contradicted.is_empty());
    contradicted.keys().for_each(|index| assert!(said(index).starts_with("All matches around put it "), "{index}"));
    let expected = matches.passed_limit(&matches.row(outlier).unwrap()).unwrap();
    window.change(|document| document.selected_match = Some(outlier)).settle();
    assert!(window.shows(&expected), "{expected}");
    window.change(|document| document.match_look.max_motion = Some(0.2)).settle();
    let pair = &window.results().pair;
    let apart = pair.listed.iter().map(|&i| pair.matches.as_ref().unwrap().row(i).unwrap().motion_apart());
    let (count, largest) = apart.fold((0, 0.0f32), |(count, largest), apart| (count + 1, largest.max(apart)));
    assert!(count > 20 && count < pair.matches.as_ref().unwrap().len() && largest <= 0.2, "{count} {largest}");
    // The nearest descriptor of all is the match of the ratio test; a predicted one is the nearest where it is
    // expected.
    window.change(|document| document.matching.predict = false).settle().key(Key::Home).settle();
    let row = window.matches().row(window.document().selected_match.unwrap()).unwrap();
    let why = window.results().pair.lost.why.as_ref().expect("it is known why");
    assert_eq!(why.feature, row.found.a);
    assert_eq!(why.unmatched.candidates[0].feature, row.found.b);
    assert!(window.shows(&format!("#{}", why.unmatched.candidates[1].feature)));
}
