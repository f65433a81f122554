//! Reasons why features have no match, and the numbers lost at each stage.

use crate::support::{Start, Window, given};
use burstscope::Monitor;
use burstscope::app::Startup;
use burstscope::app::project::pair::Side;
use burstscope::app::project::workspace::Workspace;
use burstscope::inspect::unmatched::{Losses, Lost};
use burstscope::requests::BurstSource;
use egui::Key;
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

fn two_bursts() -> Window {
    let startup = Startup { second: Some(BurstSource::DemoLater), ..given() };
    let mut window = Start { size: [1280.0, 900.0], startup, ..Start::default() }.open();
    window.app_mut().model.workspace = Workspace::Pair;
    window.settle();
    window
}

#[test]
fn the_pair_says_what_was_lost_where_and_a_feature_says_why() {
    let mut window = two_bursts();
    let found = window.app().model.losses().expect("the losses are known").clone();
    let losses = Losses::new(found.request.pair(), &Monitor::default()).unwrap();
    let expected = losses.counts(&Monitor::default()).unwrap();
    assert_eq!(found.counts, expected);
    let count = |lost: Lost| expected.iter().find(|(at, _)| *at == lost).unwrap().1;
    assert!(window.shows(&format!("ratio test {}", count(Lost::RatioTest))));
    assert!(window.shows(&format!("no keypoint {}", count(Lost::NoKeypoint))));
    let index = found.lost.iter().position(|lost| *lost != Lost::Not).expect("some have no match");
    window.click("Unmatched features of A");
    window.harness.get_by_role_and_label(Role::Row, &format!("Unmatched feature {}", index + 1)).click();
    window.settle();
    assert_eq!(window.app().model.asked_feature(), Some(index));
    let why = losses.of(index, 5);
    let words: String = why.sentence.chars().skip(1).collect();
    assert!(window.shows(&words), "{}", why.sentence);
    assert!(window.harness.query_by_role_and_label(Role::Image, "Patch of candidate 1").is_some());
    window.snapshot("unmatched_feature");
    window.key(Key::Escape);
    assert_eq!(window.app().model.asked_feature(), None);
}

#[test]
fn a_click_on_a_feature_without_a_match_asks_about_it() {
    let mut window = two_bursts();
    let found = window.app().model.losses().expect("the losses are known").clone();
    let a = found.request.request.a.clone();
    // A feature far from the others, so that the click is unambiguous.
    let apart = |i: usize, j: usize| (a.features[i].u - a.features[j].u).hypot(a.features[i].v - a.features[j].v);
    let alone = |i: usize| (0..a.features.len()).filter(|&j| j != i).map(|j| apart(i, j)).fold(f32::MAX, f32::min);
    let lost = (0..a.features.len()).filter(|&i| matches!(found.lost[i], Lost::RatioTest | Lost::NoKeypoint));
    let index = lost.max_by(|&i, &j| alone(i).total_cmp(&alone(j))).expect("some have no match");
    let f = a.features[index];
    window.app_mut().model.match_look.inliers = false;
    window.app_mut().model.match_look.outliers = false;
    let pane = burstscope::app::pane::PaneId::of(burstscope::app::project::pair::Side::A);
    window.app_mut().model.panes.get_mut(pane).unwrap().view.look_at(egui::pos2(f.u, f.v), 8.0);
    window.settle();
    let side = burstscope::app::project::pair::Side::A;
    let pos = window.app().ui_from_image_of(side, egui::pos2(f.u, f.v)).unwrap();
    window.click_at(pos);
    window.settle();
    let asked = window.app().model.asked_feature().expect("a feature is asked about");
    assert_eq!((a.features[asked].u, a.features[asked].v), (f.u, f.v));
    assert!(window.app().model.selected_match.is_none());
}

#[test]
fn where_b_has_no_keypoint_its_place_is_probed_with_one_click() {
    let mut window = two_bursts();
    // The strongest of A are not all among the strongest of B.
    window.app_mut().model.params.max_features = 300;
    window.run_action("detect");
    window.settle();
    let found = window.app().model.losses().expect("the losses are known").clone();
    let losses = Losses::new(found.request.pair(), &Monitor::default()).unwrap();
    let missing = (0..found.lost.len())
        .find(|&index| found.lost[index] == Lost::NoKeypoint && !losses.of(index, 5).expected.is_empty())
        .expect("the geometry puts one where no keypoint is");
    let names = |window: &Window| Side::BOTH.map(|side| window.app().model.burst_of(side).unwrap().burst.name.clone());
    let before = names(&window);
    assert_eq!(before, ["demo", "demo-later"]);
    window.app_mut().model.ask_feature(Some(missing));
    window.settle();
    let place = window.app().model.expected_place().expect("a place in B");
    window.click("Probe its place in B");
    window.settle();
    assert_eq!((window.app().model.workspace, names(&window)), (Workspace::Pair, before.clone()), "nothing is swapped");
    let probed = |window: &Window| {
        let model = &window.app().model;
        assert!(model.probe_is_current() && model.probe.is_open, "{:?}", model.probed.problem);
        let answer = model.probed.answer.as_ref().unwrap();
        assert_eq!(answer.probe.pos_image, place);
        (model.probe.side, answer.request.traced.cache.burst.name.clone())
    };
    assert_eq!(probed(&window), (Side::B, before[1].clone()));
    assert!(window.shows(" of B"), "the panel says of which burst");
    // When the sides are swapped, the place stays one of its burst.
    window.run_action("swap a and b");
    window.settle();
    assert_eq!((names(&window), probed(&window)), ([1, 0].map(|i| before[i].clone()), (Side::A, before[1].clone())));
}

#[test]
fn a_match_tells_its_second_best() {
    let mut window = two_bursts();
    // The nearest descriptor of all is the match of the ratio test; a predicted one is the nearest where it is expected.
    window.app_mut().model.matching.predict = false;
    window.settle();
    window.key(Key::Home);
    window.settle();
    let model = &window.app().model;
    let row = model.pair.matches.as_ref().unwrap().row(model.selected_match.unwrap()).unwrap();
    let why = model.pair.lost.why.as_ref().expect("it is known why");
    assert_eq!(why.feature, row.found.a);
    assert_eq!(why.unmatched.candidates[0].feature, row.found.b);
    let second = why.unmatched.candidates[1];
    assert!(window.shows(&format!("#{}", second.feature + 1)));
}
