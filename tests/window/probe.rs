//! Probe: asked by click, key and menu; its panel and buttons; slices through the frames; rejected candidates, and a
//! burst that moves along both axes.

use crate::maps::lamp;
use crate::support::{Start, Window, given};
use burstscope::app::Startup;
use burstscope::app::pane::{Content, SliceAxis};
use burstscope::app::project::cursor::ViewKind;
use burstscope::app::settings::Settings;
use burstscope::detector::{DetectorParams, Slope, SlopeGrid, Test};
use burstscope::inspect::ProbeCache;
use burstscope::inspect::candidates::{SurveyOptions, survey, winning_slopes};
use burstscope::requests::{MapKind, Probed};
use burstscope::synth::random::Stream;
use burstscope::{Feature, Monitor};
use egui::accesskit::Role;
use egui::{Key, Modifiers, Rect, pos2, vec2};
use egui_kittest::kittest::Queryable;
use ndarray::Array3;
use std::path::{Path, PathBuf};

fn demo() -> Window {
    Start { size: [1280.0, 800.0], ..Start::default() }.open()
}

pub fn answer(window: &Window) -> &Probed {
    let probe = &window.app().model.probe;
    assert!(probe.is_current(), "{:?} {:?}", probe.question, probe.problem);
    probe.answer.as_ref().unwrap()
}

fn shift(window: &mut Window, key: Key) {
    window.harness.key_press_modifiers(Modifiers::SHIFT, key);
    window.harness.run_steps(2);
}

/// Rectangle of an image in the panel.
fn rect_of(window: &Window, label: &str) -> egui::Rect {
    window.harness.get_by_role_and_label(Role::Image, label).rect()
}

#[test]
fn a_feature_says_why_it_was_kept() {
    let mut window = demo();
    window.key(Key::Home);
    window.click("Why?");
    window.settle();
    let fate = answer(&window).probe.subject_fate().expect("it is a candidate").clone();
    assert!(fate.features.contains(&0), "{fate:?}");
    // The window counts features from 1.
    let verdict = burstscope::inspect::words::counted_from_one(&fate.verdict);
    assert!(verdict.contains("feature 1") && window.shows(&verdict["kept as".len()..]), "{verdict}");
    for image in ["Response over slope and scale", "Patch of each frame", "Response of each frame"] {
        rect_of(&window, image);
    }
    let traced = answer(&window).request.traced.cache.clone();
    assert_eq!(traced.detection().features, window.app().model.features(), "one search, or the same bits");
    window.snapshot("probe_feature");
    // A click in the map sets that slope and scale.
    let rect = rect_of(&window, "Response over slope and scale");
    window.click_at(pos2(rect.left() + 0.25 * rect.width(), rect.top() + 0.2 * rect.height()));
    window.settle();
    let (model, map) = (&window.app().model, &answer(&window).probe.response);
    assert!(model.focused().shows(ViewKind::Dog));
    assert!(map.columns.contains(&model.cursor().slope), "{:?}", model.cursor().slope);
    assert!(map.row_of(model.cursor().octave, model.cursor().level).is_some());
}

#[test]
fn a_place_is_probed_by_click_key_and_menu_and_the_probe_follows_the_pointer() {
    let mut window = demo();
    // Shown features would be probed instead of the places beside them.
    window.app_mut().model.look.overlay = false;
    let ui = |window: &Window, u: f32, v: f32| window.app().ui_from_image(pos2(u, v)).unwrap();
    let near = |window: &Window, u: f32, v: f32| {
        let place = window.app().model.probe.place().expect("a place");
        assert!((place[0] - u).hypot(place[1] - v) < 1.0, "{place:?} {u} {v}");
    };
    let pos = ui(&window, 300.0, 40.0);
    window.shift_click_at(pos);
    window.settle();
    near(&window, 300.0, 40.0);
    assert!(window.shows("Place (300"), "the panel says where");
    let pos = ui(&window, 200.0, 90.0);
    window.harness.hover_at(pos);
    window.harness.run_steps(2);
    shift(&mut window, Key::P);
    window.settle();
    near(&window, 200.0, 90.0);
    shift(&mut window, Key::F);
    for u in [100.0, 140.0, 180.0] {
        let pos = ui(&window, u, 60.0);
        window.harness.hover_at(pos);
        window.harness.run_steps(2);
        window.settle();
        near(&window, u, 60.0);
        answer(&window);
    }
    // A click ends following, and the place stays.
    let pos = ui(&window, 180.0, 60.0);
    window.click_at(pos);
    let pos = ui(&window, 260.0, 120.0);
    window.harness.hover_at(pos);
    window.harness.run_steps(2);
    window.settle();
    near(&window, 180.0, 60.0);
    // In a frame the place under the pointer has moved since mid-burst.
    window.key(Key::Num1);
    window.settle();
    let (cursor, used) = (*window.app().model.cursor(), window.app().model.frame_count());
    let later = cursor.frame as f32 - 0.5 * (used as f32 - 1.0);
    let pos = ui(&window, 240.0, 100.0);
    window.shift_click_at(pos);
    window.settle();
    near(&window, 240.0 - later * cursor.slope.u, 100.0 - later * cursor.slope.v);
    window.click("Clear probe");
    assert!(window.app().model.probe.answer.is_none() && !window.app().model.probe.is_on());
}

#[test]
fn the_probe_is_to_be_read_on_a_light_ground_too() {
    let settings = Settings { theme: egui::ThemePreference::Light, ..Settings::default() };
    let startup = Startup { settings, ..given() };
    let mut window = Start { size: [1280.0, 800.0], startup, ..Start::default() }.open();
    window.key(Key::Home);
    window.click("Why?");
    window.settle();
    assert!(!window.harness.ctx.global_style().visuals.dark_mode);
    assert!(answer(&window).probe.subject_fate().expect("it is a candidate").is_kept() && window.shows("Kept as"));
    window.snapshot("probe_light");
}

#[test]
fn where_nothing_was_found_the_strongest_candidate_is_a_click_away() {
    let mut start = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() };
    start.startup.params.detector.peak_threshold = 0.5;
    let mut window = start.open();
    window.click("Detect");
    window.settle();
    assert!(window.app().model.features().is_empty());
    window.click("Probe the strongest candidate");
    window.settle();
    let fate = answer(&window).probe.subject_fate().expect("a candidate").clone();
    assert_eq!(fate.first_failed, Some(Test::PeakThreshold));
    // Without automatic detection the answer is marked as stale.
    let change = fate.remedy.expect("a lower threshold").change;
    window.click(&format!("Apply {}", change.label()));
    window.settle();
    assert!(!window.app().model.probe_is_stale() && !window.app().model.features().is_empty());
    window.app_mut().model.params.edge_threshold = 5.0;
    window.harness.run_steps(2);
    assert!(window.app().model.probe_is_stale() && window.shows("Stale: found with other parameters"));
}

#[test]
fn the_slope_is_a_line_to_drag_in_a_slice_through_the_frames() {
    let mut window = demo();
    // The moon, which does not move.
    let pos = window.app().ui_from_image(pos2(92.0, 58.0)).unwrap();
    window.shift_click_at(pos);
    window.settle();
    window.run_action("stack and slice");
    window.settle();
    let shown = window.app().model.panes.shown();
    let content = |window: &Window, place: usize| {
        let panes = &window.app().model.panes;
        panes.get(panes.shown()[place]).unwrap().content
    };
    assert_eq!(
        (shown.len(), content(&window, 0), content(&window, 1)),
        (2, Content::Cursor, Content::Slice(SliceAxis::Along))
    );
    window.snapshot("probe_slice");
    let rect = rect_of(&window, "Slice along the motion");
    // The first drag focuses the pane; the pointer is then where the line crosses the last row.
    window.click_at(rect.center());
    assert_eq!(window.app().model.panes.focus(), shown[1]);
    let slopes = |window: &Window| -> Vec<Slope> {
        shown.iter().map(|id| window.app().model.panes.get(*id).unwrap().cursor.slope).collect()
    };
    let before = slopes(&window);
    let (from, to) = (rect.center() + egui::vec2(0.0, 60.0), rect.center() + egui::vec2(60.0, 60.0));
    window.drag(from, to);
    let after = slopes(&window);
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

#[test]
fn a_session_comes_back_with_the_place_and_the_slice() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("probe.burstscope.toml");
    let mut window = demo();
    let pos = window.app().ui_from_image(pos2(92.0, 58.0)).unwrap();
    window.shift_click_at(pos);
    window.run_action("stack and slice");
    window.settle();
    let place = window.app().model.probe.place();
    window.dialogs.will_choose(&file);
    window.run_action("save session");
    window.settle();
    let mut other = demo();
    other.dialogs.will_choose(&file);
    other.run_action("open session");
    other.settle();
    let model = &other.app().model;
    assert!(place.is_some() && model.probe.place() == place && model.probe.is_open);
    assert_eq!(answer(&other).probe.pos_image, place.unwrap());
    assert!(model.panes.iter().any(|(_, pane)| pane.content == Content::Slice(SliceAxis::Along)));
}

fn open_lamps(folder: &Path) -> Window {
    let mut start = Start { size: [1280.0, 800.0], ..Start::of(&lamp(folder)) };
    start.startup.params =
        DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 5), ..DetectorParams::default() }.into();
    let mut window = start.open();
    window.run_action("detect");
    window.settle();
    window.click("Tally");
    window.settle();
    window
}

#[test]
fn a_row_of_the_tally_shows_its_candidates_in_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open_lamps(folder.path());
    assert!(window.app().model.survey_counts().is_none() && window.shows("Click a test"));
    window.click(Test::NoiseGate.reason());
    window.settle();
    let model = &window.app().model;
    let shown = model.survey().unwrap().clone();
    // The marks are those of the library.
    let burst = &model.slots.a.burst.as_ref().unwrap().burst;
    let cache = ProbeCache::new(burst, &model.asked(), &Monitor::default()).unwrap();
    let options = SurveyOptions { test: Some(Test::NoiseGate), ..SurveyOptions::default() };
    assert_eq!(*shown, survey(&cache.trail, &options, &Monitor::default()).unwrap());
    assert!(!shown.marks.is_empty() && shown.marks.iter().all(|m| m.first_failed == Some(Test::NoiseGate)));
    let count = shown.counts[Test::NoiseGate as usize];
    assert!(count.candidates < count.samples && window.shows("candidates: below the noise gate"));
    // Hovering shows by how much the test failed, a click keeps the numbers.
    window.run_action("fit picture");
    let mark = *shown.marks.iter().find(|m| m.pos_image[0] > 20.0 && m.pos_image[1] > 40.0).expect("one");
    let at = window.app().ui_from_image(pos2(mark.pos_image[0], mark.pos_image[1])).unwrap();
    window.harness.hover_at(at);
    window.harness.run_steps(3);
    assert!(window.shows("below the noise gate: by "), "the pointer says by how much");
    window.click_at(at);
    let chosen = *window.app().model.selected_candidate().expect("a click selects it");
    assert_eq!(chosen.pos_image, mark.pos_image);
    assert!(window.shows("Candidate at ("));
    window.snapshot("candidates");
    window.click("Go to candidate");
    window.settle();
    let cursor = *window.app().model.cursor();
    assert_eq!((cursor.octave, cursor.level), (chosen.octave, chosen.level));
    // Another row replaces it; the same row again hides them.
    switch(&mut window, Test::Edge);
    let edge = window.app().model.survey().unwrap().clone();
    assert!(edge.marks.iter().all(|m| m.first_failed == Some(Test::Edge)));
    assert_eq!(edge.counts, shown.counts);
    switch(&mut window, Test::Edge);
    assert!(window.app().model.survey().is_none() && !window.shows("candidates: on an edge"));
}

/// Clicks a row of the tally, which may have to be scrolled to.
fn switch(window: &mut Window, test: Test) {
    window.harness.get_by_role_and_label(Role::Button, test.reason()).click_accesskit();
    window.harness.run_steps(2);
    window.settle();
}

#[test]
fn candidates_follow_the_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open_lamps(folder.path());
    window.click(Test::NoiseGate.reason());
    window.settle();
    let before = window.app().model.survey().unwrap().clone();
    window.app_mut().model.params.octaves = 2;
    window.run_action("detect");
    window.settle();
    let after = window.app().model.survey().unwrap().clone();
    assert!(after.candidates < before.candidates, "they are those of the new detection");
    assert!(window.harness.query_by_label_contains("candidates: below the noise gate").is_some());
}

/// Discs on the left move by (1, −1), those on the right by (−1, 0.5); a `.npy` stack.
const LEFT: Slope = Slope { u: 1.0, v: -1.0 };
const RIGHT: Slope = Slope { u: -1.0, v: 0.5 };
const SIZE: (usize, usize) = (240, 160);
const FRAMES: usize = 7;

fn two_motions(folder: &Path) -> PathBuf {
    let mut stream = Stream::new(17, 0);
    let discs = [
        (LEFT, 40.0, 40.0),
        (LEFT, 74.0, 92.0),
        (LEFT, 34.0, 120.0),
        (RIGHT, 160.0, 50.0),
        (RIGHT, 206.0, 84.0),
        (RIGHT, 168.0, 124.0),
    ];
    let array = Array3::from_shape_fn((FRAMES, SIZE.1, SIZE.0), |(t, v, u)| {
        let dt = t as f32 - 0.5 * (FRAMES as f32 - 1.0);
        let light = |(slope, x, y): (Slope, f32, f32)| {
            let d2 = (u as f32 - x - dt * slope.u).powi(2) + (v as f32 - y - dt * slope.v).powi(2);
            (-d2 / (2.0 * 3.0 * 3.0)).exp()
        };
        0.1 + 0.12 * discs.into_iter().map(light).sum::<f32>() + 0.02 * stream.normal() as f32
    });
    let path = folder.join("two_motions.npy");
    ndarray_npy::write_npy(&path, &array).unwrap();
    path
}

fn open_plane(folder: &Path) -> Window {
    let mut start = Start { size: [1280.0, 800.0], ..Start::of(&two_motions(folder)) };
    let slopes = SlopeGrid::plane(-2.0..=2.0, 5, -2.0..=2.0, 5);
    start.startup.params = DetectorParams { slopes, ..DetectorParams::default() }.into();
    let mut window = start.open();
    window.key(Key::D);
    window.settle();
    window
}

/// Selects the strongest feature and probes it.
fn probe_strongest(window: &mut Window) -> Feature {
    window.key(Key::Home);
    window.click("Why?");
    window.settle();
    let feature = *window.app().model.selected_feature().expect("there is one");
    let near = |slope: Slope| (feature.slope.u - slope.u).hypot(feature.slope.v - slope.v) < 0.3;
    assert!(near(LEFT) || near(RIGHT), "{feature:?}");
    feature
}

fn part_rect(window: &Window, label: &str) -> Rect {
    window.harness.get_by_role_and_label(Role::Image, label).rect()
}

#[test]
fn the_probe_shows_the_response_over_both_slopes() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open_plane(folder.path());
    let feature = probe_strongest(&mut window);
    // Makes space for the widgets below.
    window.harness.get_by_label("Candidates here").click();
    window.settle();
    let rect = part_rect(&window, "Response over both slopes");
    assert!(window.harness.ctx.content_rect().contains_rect(rect), "{rect:?}");
    let plane = window.app().model.probe.answer.as_ref().unwrap().probe.response.plane.clone().expect("two axes");
    let (columns, rows) = plane.snr.size();
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let (column, row) =
        cells.max_by(|a, b| plane.snr.at(a.0, a.1).abs().total_cmp(&plane.snr.at(b.0, b.1).abs())).unwrap();
    let peak = (plane.u.values[column], plane.v.values[row]);
    assert!((peak.0 - feature.slope.u).abs() < 0.5 && (peak.1 - feature.slope.v).abs() < 0.5, "{peak:?} {feature:?}");
    window.snapshot("probe_both_slopes");
    // A click sets that slope, at the scale of the map. The centre of the range is slope 0.
    window.click_at(rect.center());
    window.settle();
    let (model, scale) = (&window.app().model, plane.scale);
    let cursor = *model.cursor();
    let near_zero = |x: f32| x.abs() < 0.4; // A cell of the map is a third of a slope wide.
    assert!(near_zero(cursor.slope.u) && near_zero(cursor.slope.v), "{:?}", cursor.slope);
    assert!(model.focused().shows(ViewKind::Dog));
    assert_eq!((cursor.octave, cursor.level), (scale.octave, scale.level));
    // A click in a row of the upper map sets the scale of the lower one.
    let above = part_rect(&window, "Response over slope and scale");
    window.click_at(pos2(above.center().x, above.top() + 0.7 * above.height()));
    window.settle();
    let coarser = window.app().model.probe.answer.as_ref().unwrap().probe.response.plane.clone().expect("two axes");
    assert!(coarser.scale.sigma > scale.sigma, "{} {}", coarser.scale.sigma, scale.sigma);
}

#[test]
fn across_the_motion_a_slice_shows_what_is_left_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open_plane(folder.path());
    let feature = probe_strongest(&mut window);
    window.run_action("stack and slice");
    window.settle();
    let shown = window.app().model.panes.shown();
    let contents: Vec<Content> = shown.iter().map(|id| window.app().model.panes.get(*id).unwrap().content).collect();
    let slices = [Content::Slice(SliceAxis::Along), Content::Slice(SliceAxis::Across)];
    assert_eq!(contents, [Content::Cursor, slices[0], slices[1]]);
    let probe = &window.app().model.probe.answer.as_ref().unwrap().probe;
    let [along, across] = [0, 1].map(|axis| probe.slices[axis].direction);
    assert!((along[0] * across[0] + along[1] * across[1]).abs() < 1e-5, "at right angles");
    let on = |direction: [f32; 2], slope: Slope| slope.u * direction[0] + slope.v * direction[1];
    assert!(on(across, feature.slope).abs() < 0.02, "along its own motion nothing moves across");
    window.snapshot("probe_slice_across");
    // The line of the slope is dragged sideways: only the slope's component across the motion changes.
    let rect = part_rect(&window, "Slice across the motion");
    window.click_at(rect.center());
    let slope = |window: &Window| window.app().model.panes.get(shown[2]).unwrap().cursor.slope;
    let before = slope(&window);
    // The slice has space for numbers on its left.
    let from = rect.center() + vec2(13.0, 45.0);
    window.drag(from, from + vec2(11.0, 0.0));
    let after = slope(&window);
    assert!(on(across, after) > on(across, before) + 0.3, "{before:?} {after:?}");
    assert!((on(along, after) - on(along, before)).abs() < 1e-3, "{before:?} {after:?}");
}

#[test]
fn the_winning_slope_is_a_picture_of_the_motion() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open_plane(folder.path());
    let feature = probe_strongest(&mut window);
    window.app_mut().model.focused_mut().cursor.octave = feature.octave;
    window.app_mut().model.focused_mut().cursor.level = feature.level;
    // The features would cover it.
    window.key(Key::O);
    window.harness.key_press_modifiers(Modifiers::SHIFT, Key::V);
    window.harness.run_steps(2);
    window.settle();
    let model = &window.app().model;
    assert_eq!(model.focused().content, Content::Map(MapKind::Motion));
    let picture = model.picture().unwrap();
    let motion = picture.motion.clone().expect("a map of the motion");
    // It equals the library's map of this detection.
    let trail = &model.probe.answer.as_ref().unwrap().request.traced.cache.trail;
    let expected = winning_slopes(trail, feature.octave, feature.level, &Monitor::default()).unwrap();
    assert_eq!(motion.winning, expected);
    let step = picture.request.kind.input_px_per_pixel();
    let at = |u: f32, v: f32| motion.at(((u / step).round() as usize, (v / step).round() as usize));
    for (slope, u, v) in [(LEFT, 74.0, 92.0), (RIGHT, 206.0, 84.0)] {
        let (wins, sure) = at(u, v);
        assert!((wins.u - slope.u).hypot(wins.v - slope.v) < 0.8 && sure > 0.0, "{wins:?} {slope:?} {sure}");
    }
    assert_eq!(at(120.0, 20.0).1, 0.0, "where nothing is, nothing is sure");
    // The value under the pointer is the slope.
    let place = window.app().ui_from_image(pos2(74.0, 92.0)).unwrap();
    window.harness.hover_at(place);
    window.harness.run_steps(3);
    assert!(window.shows("px/frame, ") && window.shows("sure "));
    window.snapshot("winning_slope_map");
}
