//! Comparison with a pinned result, with the features of a file, and with the truth.

use crate::support::{Start, noisy_stack};
use burstscope::app::project::against::{Kind, With};
use burstscope::export::{write_colmap, write_csv};
use burstscope::inspect::ProbeCache;
use burstscope::inspect::changes::{Spot, compare};
use burstscope::inspect::truth::{against_truth, truth_of};
use burstscope::{Detection, Monitor};
use egui::Key;
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

#[test]
fn what_a_change_gained_lost_and_moved_is_marked_counted_and_listed() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let before: Vec<Spot> = window.app().model.features().iter().map(Spot::from).collect();
    window.run_action("pin this result");
    window.app_mut().model.params.edge_threshold = 8.0;
    window.app_mut().model.params.noise_gate = burstscope::detector::NoiseGate::Factor(5.5);
    window.app_mut().model.params.levels = 4;
    window.settle();
    let after: Vec<Spot> = window.app().model.features().iter().map(Spot::from).collect();
    let expected = compare(&before, &after);
    assert!(!expected.lost.is_empty() && !expected.same.is_empty());
    let shown = window.app().model.shown_comparison().expect("a comparison");
    assert_eq!((shown.with, shown.count(Kind::Theirs)), (With::Pinned, expected.lost.len()));
    assert_eq!((shown.count(Kind::Ours), shown.count(Kind::Moved)), (expected.gained.len(), expected.moved().count()));
    assert!(window.shows(&expected.summary()), "the counts in a line");
    window.harness.get_by_role_and_label(Role::Row, "Lost 1").click();
    window.settle();
    assert_eq!(window.app().model.against.selected, Some(0));
    assert_eq!(window.app().model.selected, None, "what is lost is none of ours");
    window.snapshot("compared_with_pinned");
    window.key(Key::Escape);
    assert_eq!(window.app().model.against.selected, None);
    window.run_action("unpin");
    window.settle();
    assert!(window.app().model.shown_comparison().is_none() && !window.shows("as before"));
}

#[test]
fn pinning_a_result_and_changing_nothing_shows_no_change() {
    let mut window = Start::default().open();
    let count = window.app().model.features().len();
    window.harness.key_press_modifiers(egui::Modifiers::SHIFT, Key::D);
    window.settle();
    let shown = window.app().model.shown_comparison().expect("a comparison");
    assert!([Kind::Theirs, Kind::Ours, Kind::Moved].into_iter().all(|kind| shown.count(kind) == 0));
    // All orientations of one keypoint count as one.
    assert!(shown.count(Kind::Same) > 0 && shown.count(Kind::Same) <= count);
}

#[test]
fn features_of_others_are_laid_over_the_burst_and_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let mut detection = (*window.app().model.slots.a.found.as_ref().unwrap().detection).clone();
    // The other features lack our strongest one, and have one where we have none.
    let lonely = burstscope::Feature { u: 5.0, v: 352.0, sigma: 1.7, ..detection.features[0] };
    detection.features.remove(0);
    detection.descriptors.remove(0);
    detection.features.push(lonely);
    detection.descriptors.push([0; 128]);
    let (csv, txt) = (folder.path().join("theirs.csv"), folder.path().join("theirs.txt"));
    write_csv(&csv, &detection.features).unwrap();
    write_colmap(&txt, &detection.features, &detection.descriptors).unwrap();
    for path in [csv, txt] {
        window.dialogs.will_choose(&path);
        window.run_action("open features");
        window.settle();
        let shown = window.app().model.shown_comparison().expect("a comparison");
        assert_eq!((shown.with, shown.count(Kind::Theirs)), (With::File, 1), "{}", path.display());
        let row = &shown.rows[0];
        assert!((row.pos_image[0] - 5.0).abs() < 0.01 && row.feature.is_none(), "{row:?}");
        assert!(window.shows("1 only theirs"));
    }
    window.snapshot("compared_with_theirs");
    window.run_action("close opened features");
    window.settle();
    assert!(window.app().model.shown_comparison().is_none());
}

#[test]
fn a_file_that_holds_no_features_is_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notes.txt");
    std::fs::write(&path, "nothing of the kind\n").unwrap();
    let mut window = Start::default().open();
    window.dialogs.will_choose(&path);
    window.run_action("open features");
    window.settle();
    assert!(window.shows("is neither the header of a feature table"));
}

#[test]
fn a_session_comes_back_with_what_the_features_are_compared_with() {
    let folder = tempfile::tempdir().unwrap();
    let (session, theirs) = (folder.path().join("compared.burstscope.toml"), folder.path().join("theirs.csv"));
    let mut window = Start::default().open();
    write_csv(&theirs, &window.app().model.features()[5..]).unwrap();
    window.run_action("pin this result");
    window.app_mut().model.params.noise_gate = burstscope::detector::NoiseGate::Factor(6.0);
    window.settle();
    let pinned = window.app().model.shown_comparison().expect("a comparison").clone();
    assert!(pinned.count(Kind::Theirs) > 0);
    window.dialogs.will_choose(&theirs);
    window.run_action("open features");
    window.settle();
    let laid_over = window.app().model.shown_comparison().expect("a comparison").summary.clone();
    window.dialogs.will_choose(&session);
    window.run_action("save session");
    window.settle();

    let reopen = || {
        let mut window = Start::default().open();
        window.dialogs.will_choose(&session);
        window.run_action("open session");
        window.settle();
        window
    };
    let shows_pinned = |window: &mut crate::support::Window| {
        window.click("Pinned result");
        window.settle();
        let shown = window.app().model.shown_comparison().expect("a comparison");
        // The features were found again, with equal bits.
        assert_eq!((&shown.rows, &shown.summary), (&pinned.rows, &pinned.summary));
    };
    let mut window = reopen();
    let shown = window.app().model.shown_comparison().expect("a comparison");
    assert_eq!((shown.with, &shown.summary), (With::File, &laid_over));
    shows_pinned(&mut window);
    // A missing file is reported where it belongs, and nothing else is lost.
    std::fs::remove_file(&theirs).unwrap();
    let mut window = reopen();
    assert!(window.app().model.shown_comparison().is_none() && window.shows("theirs.csv"));
    assert_eq!(window.app().model.params.noise_gate, burstscope::detector::NoiseGate::Factor(6.0));
    shows_pinned(&mut window);
}

#[test]
fn what_is_seen_is_copied_as_a_command() {
    let mut window = Start::default().open();
    window.app_mut().model.params.max_features = 25;
    window.settle();
    window.harness.key_press_modifiers(egui::Modifiers::COMMAND | egui::Modifiers::SHIFT, Key::K);
    window.harness.run_steps(1);
    let line = burstscope::cli::detect_line(&["demo".to_owned()], &window.app().model.asked(), &Default::default());
    assert!(line.starts_with("burstscope detect demo --out ") && line.contains("--max-features 25"), "{line}");
    window.harness.run_steps(1);
    assert!(window.shows(&format!("Copied {line}")));
}

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
    let shown = model.shown_comparison().expect("a comparison");
    assert_eq!(shown.with, With::Truth);
    let counts = [Kind::Same, Kind::Theirs, Kind::Repeated, Kind::Ours].map(|kind| shown.count(kind));
    let sizes = [expected.found.len(), expected.missed.len(), expected.repeated.len(), expected.elsewhere.len()];
    assert_eq!(counts, sizes);
    assert!(counts[0] > 0 && counts[1] > 0, "{counts:?}");
    // The truth of a scene lists only some of its features.
    assert!(expected.summary().ends_with("elsewhere") && window.shows(&expected.summary()));
    assert!(!shown.is_whole_truth && !window.app().model.against.shows(Kind::Ours));
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
    assert!(!window.app().model.against.has(With::Truth));
    window.run_action("compare with the truth");
    window.settle();
    assert_eq!(window.app().model.against.with, None);
}
