//! Found, missed, repeated and other features, where the truth is known.

use crate::support::{Start, noisy_stack};
use burstscope::app::project::against::{Kind, With};
use burstscope::app::project::side::Side;
use burstscope::inspect::ProbeCache;
use burstscope::inspect::truth::{against_truth, truth_of};
use burstscope::{Detection, Monitor};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

#[test]
fn the_demo_knows_what_was_found_and_why_the_rest_was_missed() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    window.run_action("compare with the truth");
    window.settle();
    let model = &window.app().model;
    let burst = &model.slots.a.burst.as_ref().unwrap().burst;
    let cache = ProbeCache::new(burst, &model.slots.a.found.as_ref().unwrap().asked, &Monitor::default()).unwrap();
    let truth = truth_of(burst).unwrap().expect("the demo's truth is known");
    let expected = against_truth(&cache, &truth, &Monitor::default()).unwrap();
    let detection: &Detection = &model.slots.a.found.as_ref().unwrap().detection;
    assert_eq!(cache.detection().features, detection.features, "the truth is held against the features on show");
    let shown = model.shown_comparison(Side::A).expect("a comparison");
    assert_eq!(shown.with, With::Truth);
    let counts = [Kind::Same, Kind::Theirs, Kind::Repeated, Kind::Ours].map(|kind| shown.count(kind));
    let sizes = [expected.found.len(), expected.missed.len(), expected.repeated.len(), expected.elsewhere.len()];
    assert_eq!(counts, sizes);
    assert!(counts[0] > 0 && counts[1] > 0, "{counts:?}");
    // The truth of a scene lists only some of its features.
    assert!(expected.summary().ends_with("elsewhere") && window.shows(&expected.summary()));
    assert!(!shown.is_whole_truth && !window.app().model.slots.a.against.shows(Kind::Ours));
    // A miss tells its reason.
    assert_eq!(shown.rows[0].note, expected.missed[0].why);
    window.harness.get_by_role_and_label(Role::Row, "Missed 1").click();
    window.settle();
    assert!(window.shows(&expected.missed[0].why));
    window.snapshot("truth");
    window.click("Why here?");
    window.settle();
    let place = window.app().model.probe.place().expect("the place is probed");
    let miss = &truth.features[expected.missed[0].disc];
    assert!((f64::from(place[0]) - miss.u).abs() < 0.01 && (f64::from(place[1]) - miss.v).abs() < 0.01);
}

#[test]
fn a_burst_of_the_camera_has_no_truth_to_compare_with() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Start::of(&noisy_stack(folder.path(), 4, 60, 80)).open();
    window.click("Detect");
    window.settle();
    assert!(!window.app().model.slots.a.against.has(With::Truth));
    window.run_action("compare with the truth");
    window.settle();
    assert_eq!(window.app().model.slots.a.against.with, None);
}
