//! Places of the rejected candidates: rows of the tally are switches.

use crate::maps::lamp;
use crate::support::{Start, Window};
use burstscope::Monitor;
use burstscope::detector::{DetectorParams, SlopeGrid, Test};
use burstscope::inspect::ProbeCache;
use burstscope::inspect::candidates::{SurveyOptions, survey};
use egui::accesskit::Role;
use egui::pos2;
use egui_kittest::kittest::Queryable;
use std::path::Path;

fn open(folder: &Path) -> Window {
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
    let mut window = open(folder.path());
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
    let mut window = open(folder.path());
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
