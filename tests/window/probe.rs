//! Probe: asked by click, key and menu; the content and buttons of its panel; slices through the frames; and the places
//! of the rejected candidates, where rows of the tally are switches.

use crate::{maps::lamp, support::*};
use burstscope::app::pane::SliceAxis;
use burstscope::inspect::place::{CauseKind, ProbeOptions, ProbeSubject, SurveyOptions, probe, survey};
use burstscope::inspect::result::{DecoyStudy, decoys};
use burstscope::inspect::words::number;

fn demo() -> Window {
    Start { size: [1280.0, 800.0], ..Start::default() }.open()
}

pub fn answer(window: &Window) -> &Probed {
    assert!(window.read().probe_is_current(), "{:?} {:?}", window.document().probe, window.results().probed.problem);
    window.results().probed.answer.as_ref().unwrap()
}

#[test]
fn a_feature_says_why_it_was_kept() {
    // High enough for the whole answer.
    let mut window = Start { size: [1280.0, 1100.0], ..Start::default() }.open();
    window.key(Key::Home).click("Why?").settle();
    let fate = answer(&window).probe.subject_fate().expect("it is a candidate").clone();
    assert!(fate.features.contains(&0), "{fate:?}");
    let verdict = fate.verdict.clone();
    assert!(verdict.contains("feature 0") && window.shows(&verdict["kept as".len()..]), "{verdict}");
    for image in ["Response over slope and scale", "Patch of each frame", "Response of each frame"] {
        window.rect(Role::Image, image);
    }
    let traced = answer(&window).request.traced.cache.clone();
    assert_eq!(traced.detection().features, window.read().features(), "one search, or the same bits");
    window.snapshot("probe_feature");
    let rect = window.rect(Role::Image, "Response over slope and scale");
    window.click_at(pos2(rect.left() + 0.25 * rect.width(), rect.top() + 0.2 * rect.height())).settle();
    let (model, map) = (window.model(), &answer(&window).probe.response);
    assert!(model.document.focused().shows(ViewKind::Dog));
    assert!(map.columns.contains(&model.document.cursor().slope), "{:?}", model.document.cursor().slope);
    assert!(map.row_of(model.document.cursor().octave, model.document.cursor().level).is_some());
}

#[test]
fn a_place_is_probed_by_click_key_and_menu_and_the_probe_follows_the_pointer() {
    let mut window = demo();
    // Shown features would be probed instead of the places beside them.
    window.set().look.overlay = FeaturesShown::None;
    let ui = |window: &Window, u: f32, v: f32| window.ui_from_image(pos2(u, v)).unwrap();
    let near = |window: &Window, u: f32, v: f32| {
        let place = window.read().probed_place().expect("a place");
        assert!((place[0] - u).hypot(place[1] - v) < 1.0, "{place:?} {u} {v}");
    };
    let pos = ui(&window, 300.0, 40.0);
    window.shift_click_at(pos).settle();
    near(&window, 300.0, 40.0);
    assert!(window.shows("Place (300"), "the panel says where");
    let pos = ui(&window, 200.0, 90.0);
    window.hover(pos).steps(2).shift(Key::P).settle();
    near(&window, 200.0, 90.0);
    window.shift(Key::F);
    for u in [100.0, 140.0, 180.0] {
        window.hover(ui(&window, u, 60.0)).steps(2).settle();
        near(&window, u, 60.0);
        answer(&window);
    }
    let pos = ui(&window, 180.0, 60.0);
    window.click_at(pos);
    let pos = ui(&window, 260.0, 120.0);
    window.hover(pos).steps(2).settle();
    near(&window, 180.0, 60.0);
    // In a frame the place under the pointer has moved since mid-burst.
    window.key(Key::Num1).settle();
    let (cursor, used) = (*window.document().cursor(), window.read().frame_count());
    let later = cursor.frame as f32 - 0.5 * (used as f32 - 1.0);
    window.shift_click_at(ui(&window, 240.0, 100.0)).settle();
    near(&window, 240.0 - later * cursor.slope.u, 100.0 - later * cursor.slope.v);
    window.click("Clear probe");
    assert!(window.results().probed.answer.is_none() && !window.document().probe.is_on());
}

#[test]
fn a_place_of_either_of_two_bursts_is_probed_where_it_is_clicked() {
    let mut window = Start::two_bursts([1400.0, 900.0]).open();
    let names = |window: &Window| Side::BOTH.map(|side| window.read().burst_of(side).unwrap().burst.name.clone());
    assert_eq!(window.document().workspace, Workspace::Pair);
    assert_eq!(names(&window), ["demo", "demo-later"].map(String::from));
    for (side, u, v) in [(Side::B, 92.0, 58.0), (Side::A, 200.0, 90.0), (Side::B, 300.0, 40.0)] {
        window.shift_click_at(window.ui_from_image_of(side, pos2(u, v)).unwrap()).settle();
        let (model, answer) = (window.model(), answer(&window));
        assert_eq!((model.document.probe.side, model.document.workspace), (side, Workspace::Pair));
        assert_eq!(model.document.selected_match, None, "nothing else was clicked");
        assert_eq!(Read::of(model).asked_feature(), None, "nothing else was clicked");
        let place = answer.probe.pos_image;
        assert!((place[0] - u).hypot(place[1] - v) < 1.0, "{place:?}");
        let burst = &Read::of(model).burst_of(side).unwrap().burst;
        let cache = ProbeCache::new(burst, &Read::of(model).asked_of(side), &Monitor::default()).unwrap();
        let in_view = answer.request.in_view;
        let options = ProbeOptions { wanted: ProbeSubject::Best, in_view, ..ProbeOptions::default() };
        assert_eq!(answer.probe.fates, probe(&cache, place, &options, &Monitor::default()).unwrap().fates);
        let title = format!("Place ({}, {}) of {}", number(place[0], 1), number(place[1], 1), side.name());
        assert!(window.shows(&title) && window.shows(&answer.probe.summary), "{title}");
    }
    assert_eq!(names(&window), ["demo", "demo-later"], "nothing is swapped");
    let rect = window.rect(Role::Image, "Response over slope and scale");
    window.click_at(pos2(rect.left() + 0.25 * rect.width(), rect.top() + 0.2 * rect.height())).settle();
    let (model, map) = (window.model(), &answer(&window).probe.response);
    assert_eq!(Read::of(model).active_side(), Side::B);
    assert!(model.document.focused().shows(ViewKind::Dog));
    assert!(map.columns.contains(&model.document.panes.of(Side::B).cursor.slope));
    window.click("Match and display");
    assert!(!window.document().probe.is_open && window.shows("Selected match"));
}

#[test]
fn the_probe_is_to_be_read_on_a_light_ground_too_and_a_session_comes_back_with_the_place_and_the_slice() {
    let settings = Settings { theme: egui::ThemePreference::Light, ..given().settings };
    let startup = Startup { settings, ..given() };
    let mut window = Start { size: [1280.0, 800.0], startup, ..Start::default() }.open();
    window.key(Key::Home).click("Why?").settle();
    assert!(!window.harness.ctx.global_style().visuals.dark_mode);
    assert!(answer(&window).probe.subject_fate().expect("it is a candidate").is_kept() && window.shows("Kept as"));
    window.snapshot("probe_light");
    let (_folder, file) = folder_with("probe.burstscope.toml");
    let mut window = demo();
    let pos = window.ui_from_image(pos2(92.0, 58.0)).unwrap();
    window.shift_click_at(pos).run_action("stack and slice").settle();
    let place = window.read().probed_place();
    window.will_choose(&file).run_action("save session").settle();
    let mut other = demo();
    other.will_choose(&file).run_action("open session").settle();
    assert!(place.is_some() && other.read().probed_place() == place && other.document().probe.is_open);
    assert_eq!(answer(&other).probe.pos_image, place.unwrap());
    assert!(other.document().panes.iter().any(|(_, pane)| pane.content == Content::Slice(SliceAxis::Along)));
}

#[test]
fn where_nothing_was_found_the_strongest_candidate_is_a_click_away() {
    let mut start = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() };
    start.startup.params.peak_threshold = 0.5;
    let mut window = start.open();
    window.click("Detect").settle();
    assert!(window.read().features().is_empty());
    window.click("Probe the strongest candidate").settle();
    let fate = answer(&window).probe.subject_fate().expect("a candidate").clone();
    assert_eq!(fate.first_failed, Some(Test::PeakThreshold));
    // Without automatic detection the answer is marked as stale.
    let change = fate.remedy.expect("a lower threshold").change;
    window.click(&format!("Apply {}", change.label())).settle();
    assert!(!window.read().probe_is_stale() && !window.read().features().is_empty());
    window.change(|document| document.params.edge_threshold = 5.0).steps(2);
    assert!(window.read().probe_is_stale() && window.shows("Stale: found with other parameters"));
}

#[test]
fn the_panel_speaks_of_the_place_what_is_too_small_for_the_scales_and_what_was_found_at_another_slope() {
    let mut window = Start { size: [1280.0, 1100.0], ..Start::automatic() }.open();
    window.set().look.overlay = FeaturesShown::None;
    let probe = |window: &mut Window, u: f32, v: f32| {
        window.shift_click_at(window.ui_from_image(pos2(u, v)).unwrap()).settle();
    };
    // A star that was kept at slopes with which it does not move: a button goes to what was found.
    window.change(|document| document.focused_mut().cursor.slope = Slope::new(0.95, 0.0)).settle();
    probe(&mut window, 238.0, 36.0);
    let reasons = answer(&window).probe.reasons.clone();
    let other = reasons.iter().find(|reason| reason.kind == CauseKind::AtAnotherSlope).expect("it was found");
    assert!(window.shows(&other.sentence["found ".len()..]), "{}", other.sentence);
    assert!(!window.shows("It is shown under All"), "no features are shown at all");
    window.change(|document| document.look.overlay = FeaturesShown::ThisSlope).steps(2);
    assert!(window.shows("It is shown under All, not under This slope."));
    let feature = other.feature.expect("a feature");
    window.click(&format!("Go to feature {feature}")).settle();
    assert_eq!(window.document().selected, Some(feature));
    assert_eq!(window.document().cursor().slope, window.read().features()[feature].slope);
    // A star that is too small: the setting that finds it is a click away.
    window.change(|document| document.look.overlay = FeaturesShown::None).run_action("fit picture");
    // At its own slope, where it is to be seen.
    window.change(|document| document.focused_mut().cursor.slope = Slope::new(0.95, 0.0)).settle();
    probe(&mut window, 159.9, 23.6);
    let small = answer(&window).probe.reasons.iter().find(|r| r.kind == CauseKind::TooSmall).expect("it is").clone();
    assert!(window.shows("oo small for the smallest scale") && window.shows("first octave −1 finds it"));
    window.click(&format!("Apply {}", small.change.expect("a setting").label())).settle();
    assert_eq!(window.document().params.first_octave, -1);
    let fate = answer(&window).probe.subject_fate().expect("it was found").clone();
    assert!(fate.is_kept() && (fate.slope.u - 0.95).abs() < 0.35 && fate.sigma < 1.7, "{fate:?}");
}

#[test]
fn a_feature_that_is_drawn_as_a_dot_is_said_to_be() {
    let mut window = Start { size: [1280.0, 1100.0], ..Start::default() }.open();
    window.change(|document| document.look.overlay = FeaturesShown::All).settle();
    // Of so many features at one zoom some are dots; one of the weakest is asked about.
    let count = window.read().features().len();
    let dot = (0..count).rev().find(|&index| {
        let feature = window.read().features()[index];
        apply::probe::probe_place(&mut window.app_mut().model, Side::A, [feature.u, feature.v]);
        window.settle();
        !window.results().probed.as_dots.is_empty()
    });
    assert!(dot.is_some(), "{count} features, none a dot");
    let shown = window.results().probed.as_dots[0];
    assert!(window.shows(&format!("Feature {} was found here, but is drawn as a dot", shown)));
    apply::probe::clear_probe(&mut window.app_mut().model);
    window.settle();
    assert!(!window.shows("drawn as a dot"));
}

#[test]
fn the_slope_is_a_line_to_drag_in_a_slice_through_the_frames() {
    let mut window = demo();
    // The moon, which moves as the stars do.
    window.change(|document| document.focused_mut().cursor.slope = Slope::new(0.95, 0.0)).settle();
    let pos = window.ui_from_image(pos2(92.0, 58.0)).unwrap();
    window.shift_click_at(pos).settle().run_action("stack and slice").settle();
    let shown = window.document().panes.shown();
    let content = |window: &Window, place: usize| {
        let panes = &window.document().panes;
        panes.get(panes.shown()[place]).unwrap().content
    };
    assert_eq!(shown.len(), 2);
    assert_eq!(content(&window, 0), Content::Cursor);
    assert_eq!(content(&window, 1), Content::Slice(SliceAxis::Along));
    window.snapshot("probe_slice");
    let rect = window.rect(Role::Image, "Slice along the motion");
    // The first drag focuses the pane; the pointer is then where the line crosses the last row.
    window.click_at(rect.center());
    assert_eq!(window.document().panes.focus(), shown[1]);
    let slopes = |window: &Window| -> Vec<Slope> {
        shown.iter().map(|id| window.document().panes.get(*id).unwrap().cursor.slope).collect()
    };
    let before = slopes(&window);
    let (from, to) = (rect.center() + vec2(0.0, 60.0), rect.center() + vec2(60.0, 60.0));
    window.drag(from, to);
    let after = slopes(&window);
    // The slice runs along the subject's motion, to the right.
    assert!(after[1].u > before[1].u + 0.5, "{before:?} {after:?}");
    let moved = [0, 1].map(|i| after[i].u - before[i].u);
    assert!((moved[0] - moved[1]).abs() < 1e-3, "the stack follows: {moved:?}");
    window.ctrl(Key::Z);
    assert_eq!(slopes(&window), before);
    // A key moves the line too, and the pane stays a slice.
    window.key(Key::ArrowRight);
    assert_eq!(content(&window, 1), Content::Slice(SliceAxis::Along));
    assert_ne!(slopes(&window)[1], before[1]);
}

fn open() -> Window {
    let mut window = Start::at_slopes(&lamp(&folder()), SlopeGrid::line(-2.0..=2.0, 5)).open();
    window.run_action("detect").settle().open_tab("Tally").settle();
    window
}

#[test]
fn a_row_of_the_tally_shows_its_candidates_in_the_picture() {
    let mut window = open();
    assert!(window.read().survey_counts().is_none() && window.shows("Click a test"));
    window.click(Test::NoiseGate.reason()).settle();
    let shown = window.read().survey().unwrap().clone();
    let burst = &window.opened().burst;
    let cache = ProbeCache::new(burst, &window.read().asked(), &Monitor::default()).unwrap();
    let options = SurveyOptions { test: Some(Test::NoiseGate), ..SurveyOptions::default() };
    assert_eq!(*shown, survey(&cache.trail, &options, &Monitor::default()).unwrap());
    assert!(!shown.marks.is_empty() && shown.marks.iter().all(|m| m.first_failed == Some(Test::NoiseGate)));
    let count = shown.counts[Test::NoiseGate as usize];
    assert!(count.candidates < count.samples && window.shows("candidates: below the noise gate"));
    // Hovering shows by how much the test failed, a click keeps the numbers.
    window.run_action("fit picture");
    let mark = *shown.marks.iter().find(|m| m.pos_image[0] > 20.0 && m.pos_image[1] > 40.0).expect("one");
    let at = window.ui_from_image(pos2(mark.pos_image[0], mark.pos_image[1])).unwrap();
    window.hover(at).steps(3);
    assert!(window.shows("below the noise gate: by "), "the pointer says by how much");
    window.click_at(at);
    let chosen = *window.read().selected_candidate().expect("a click selects it");
    assert_eq!(chosen.pos_image, mark.pos_image);
    assert!(window.shows("Candidate at ("));
    window.snapshot("candidates").click("Go to candidate").settle();
    let cursor = *window.document().cursor();
    assert_eq!((cursor.octave, cursor.level), (chosen.sample.octave, chosen.sample.level));
    switch(&mut window, Test::Edge);
    let edge = window.read().survey().unwrap().clone();
    assert!(edge.marks.iter().all(|m| m.first_failed == Some(Test::Edge)));
    assert_eq!(edge.counts, shown.counts);
    switch(&mut window, Test::Edge);
    assert!(window.read().survey().is_none() && !window.shows("candidates: on an edge"));
}

fn switch(window: &mut Window, test: Test) {
    press(window, test.reason());
}

/// Clicks a row or button of the tally, which may have to be scrolled to.
fn press(window: &mut Window, label: &str) {
    window.harness.get_by_role_and_label(Role::Button, label).click_accesskit();
    window.steps(2).settle();
}

#[test]
fn decoys_are_searched_when_asked_for_and_are_those_of_the_detection_on_show() {
    let mut window = open();
    assert!(window.read().decoys().is_none() && !window.shows("Decoys: "), "nobody asked for them");
    press(&mut window, "False rate…");
    let shown = window.read().decoys().expect("they were asked for").clone();
    let burst = &window.opened().burst;
    let cache = ProbeCache::new(burst, &window.read().asked(), &Monitor::default()).unwrap();
    assert_eq!(shown.report, decoys(&cache.trail, &DecoyStudy::default(), false, &Monitor::default()).unwrap().report);
    assert!(shown.report.rates[0].found > 0 && window.shows(&format!("Decoys: {}", shown.report.sentence())));
    // Other parameters are another search, whose decoys nobody asked for.
    window.change(|document| document.params.slopes = SlopeGrid::line(-2.0..=2.0, 9).into()).settle();
    assert!(window.read().stale().is_some() && !window.shows("Decoys: "));
    press(&mut window, "False rate…");
    assert!(window.read().decoys().is_none(), "there is nothing to compare with");
    window.run_action("detect").settle();
    assert!(window.read().decoys().is_none() && !window.shows("Decoys: "));
    press(&mut window, "False rate…");
    assert_ne!(*window.read().decoys().expect("they were asked for"), shown);
}

#[test]
fn a_burst_too_short_for_decoys_says_why_each_time_and_candidates_follow_the_parameters() {
    let mut window = open();
    window.change(|document| document.params.frames = Some(FrameRange { start: 0, end: 3 })).run_action("detect");
    window.settle();
    for _ in 0..2 {
        press(&mut window, "False rate…");
        let errors = window.errors();
        assert!(errors.iter().any(|error| format!("{error:?}").contains("4 or more")), "{errors:?}");
        assert!(window.read().decoys().is_none());
    }
    let mut window = open();
    window.click(Test::NoiseGate.reason()).settle();
    let before = window.read().survey().unwrap().clone();
    window.change(|document| document.params.octaves = 2).run_action("detect").settle();
    let after = window.read().survey().unwrap().clone();
    assert!(after.candidates < before.candidates, "they are those of the new detection");
    assert!(window.harness.query_by_label_contains("candidates: below the noise gate").is_some());
}
