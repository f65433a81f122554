//! Opening of bursts and its failures: examples, long films, calibration.

use crate::datasets::{dataset, few_slopes, start, walk};
use crate::probe::answer;
use crate::support::{Start, Window, noisy_stack};
use burstscope::app::project::datasets::BurstState;
use burstscope::detector::{NoiseGate, SlopeChoice, Test};
use burstscope::inspect::suspicion::Kind;
use burstscope::requests::BurstSource;
use burstscope::synth::Example;
use burstscope::synth::examples::{ALIASING_SLOPE, GARLAND_PERIOD};
use egui::Key;
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use image::{ImageBuffer, Luma};
use std::io::Write;
use std::path::Path;

#[test]
fn the_demo_opens_and_its_features_are_found_at_the_slope_that_reveals_most() {
    let window = Start::default().open();
    let model = &window.app().model;
    assert_eq!(model.frame_count(), 10);
    assert!(model.features().len() > 5, "{}", model.features().len());
    assert!(
        model.cursor().slope.magnitude() > 0.5,
        "the slope with the most features is shown: {:?}",
        model.cursor().slope
    );
    assert!(window.shows("features in"));
    assert!(window.shows("10 frames"));
}

#[test]
fn with_nothing_open_the_first_page_leads_on() {
    let mut window = Start::nothing_open().open();
    assert!(window.app().model.slots.a.burst.is_none());
    assert!(window.shows("or drop a folder"));
    window.click("Open demo burst");
    window.settle();
    assert_eq!(window.app().model.frame_count(), 10);
}

#[test]
fn a_stack_is_opened_with_the_dialog_and_is_then_a_recent_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = noisy_stack(folder.path(), 4, 48, 64);
    let mut window = Start::without_auto_detect().open();
    window.dialogs.will_choose(&path);
    window.click("Open…");
    window.settle();
    assert_eq!((window.app().model.frame_count(), window.app().model.size()), (4, (64, 48)));
    assert_eq!(window.app().recent(), [BurstSource::Paths(vec![path])]);
}

#[test]
fn a_broken_file_is_named_and_the_burst_that_was_open_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken-frame.png");
    std::fs::File::create(&path).unwrap().write_all(b"this is no picture").unwrap();
    let mut window = Start::without_auto_detect().open();
    let before = window.app().model.slots.a.burst.as_ref().unwrap().id;
    let plane = window.app().model.picture().cloned().unwrap().plane;
    window.dialogs.will_choose(&path);
    window.click("Open…");
    window.wait("a message", |app| !app.model.messages.errors().is_empty());
    assert!(window.shows("broken-frame.png"));
    assert_eq!(window.app().model.slots.a.burst.as_ref().unwrap().id, before);
    assert_eq!(window.app().model.picture().unwrap().plane, plane);
    window.click("Dismiss: Open");
    assert!(!window.shows("broken-frame.png"));
}

#[test]
fn where_the_system_has_no_dialog_a_path_can_be_typed() {
    let folder = tempfile::tempdir().unwrap();
    let path = noisy_stack(folder.path(), 3, 40, 40);
    let mut window = Start::without_auto_detect().open();
    // The script is empty, so the dialog returns "nothing" at once, as rfd does without a portal.
    window.click("Open…");
    window.wait("the dialog's answer", |app| app.is_settled());
    assert!(window.shows("This system shows no file dialog"));
    type_path(&mut window, &path.display().to_string());
    window.settle();
    assert_eq!(window.app().model.frame_count(), 3);
}

#[test]
fn files_that_are_dropped_are_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = noisy_stack(folder.path(), 5, 40, 40);
    let mut window = Start::without_auto_detect().open();
    window.drop_file(path);
    window.settle();
    assert_eq!(window.app().model.frame_count(), 5);
}

/// Types into the path field and accepts.
pub fn type_path(window: &mut crate::support::Window, text: &str) {
    use egui::accesskit::Role;
    let field = window.harness.get_by_role_and_label(Role::TextInput, "Path");
    field.focus();
    field.type_text(text);
    window.harness.run_steps(2);
    window.key(egui::Key::Enter);
}

#[test]
fn the_failures_to_look_at_open_from_the_help_menu_and_are_kept_in_sessions() {
    use burstscope::synth::Example;
    for example in Example::ALL {
        let mut window = Start::without_auto_detect().open();
        window.run_action(example.label());
        window.settle();
        let source = BurstSource::Example(example);
        assert_eq!(window.app().model.slots.a.burst.as_ref().map(|open| &open.source), Some(&source));
        assert_eq!(window.app().model.frame_count(), burstscope::synth::examples::EXAMPLE_FRAMES);
        assert!(window.shows(example.name()), "the status line names it");
        let text = toml::to_string(&std::collections::BTreeMap::from([("source", &source)])).expect("TOML");
        let read: std::collections::BTreeMap<String, BurstSource> = toml::from_str(&text).expect("the same");
        assert_eq!(read["source"], source);
    }
}

/// Writes frames of an even light of 1200 behind a lens that dims the right half by one half, on stripes of 100 and
/// 300.
fn frames(home: &Path) {
    let bias = |v: u32| if v.is_multiple_of(2) { 100u16 } else { 300 };
    let light = |u: u32| if u < 48 { 1200u16 } else { 600 };
    let save = |name: &str, value: &dyn Fn(u32, u32) -> u16| {
        ImageBuffer::<Luma<u16>, _>::from_fn(96, 64, |u, v| Luma([value(u, v)])).save(home.join(name)).unwrap();
    };
    std::fs::create_dir(home.join("night")).unwrap();
    for t in 0..4u16 {
        save(&format!("night/{t}.png"), &|u, v| bias(v) + light(u) + (u as u16 * 7 + v as u16 * 5 + t) % 3);
    }
    save("bias.png", &|_, v| bias(v));
    save("flat.png", &|u, v| bias(v) + 3 * light(u));
}

#[test]
fn calibration_is_dropped_applied_and_kept_in_the_session() {
    let home = tempfile::tempdir().unwrap();
    frames(home.path());
    let mut window = Start::of(&home.path().join("night")).open();
    let value = |window: &crate::support::Window, u: usize, v: usize| {
        window.app().model.slots.a.burst.as_ref().unwrap().burst.frames[0].at(u, v) * 65_535.0
    };
    assert!((value(&window, 0, 0) - 1300.0).abs() < 3.0 && (value(&window, 90, 1) - 900.0).abs() < 3.0);
    // The suggestion about the values was noted when the burst was opened.
    assert!(
        window
            .app()
            .model
            .slots
            .a
            .burst
            .as_ref()
            .unwrap()
            .burst
            .notes()
            .iter()
            .any(|note| note.option == Some("full-scale"))
    );
    window.run_action("calibration");
    // The first dropped file is the bias; the flat is chosen.
    window.drop_file(home.path().join("bias.png"));
    window.dialogs.will_choose(home.path().join("flat.png"));
    window.click("Choose flat frame…");
    window.wait("both are named", |app| app.is_settled());
    window.harness.run_steps(3);
    assert!(window.shows("bias.png") && window.shows("flat.png"));
    window.snapshot("calibration");
    window.click("Apply");
    window.settle();
    // Both halves are as bright, and there are no stripes.
    for (u, v) in [(0, 0), (0, 1), (90, 0), (90, 1)] {
        assert!((value(&window, u, v) - 900.0).abs() < 4.0, "({u}, {v}): {}", value(&window, u, v));
    }
    let file = home.path().join("night.burstscope.toml");
    window.dialogs.will_choose(&file);
    window.run_action("save session");
    window.settle();
    let mut other = Start::without_auto_detect().open();
    other.dialogs.will_choose(&file);
    other.run_action("open session");
    other.settle();
    assert!((value(&other, 90, 1) - 900.0).abs() < 4.0);
    let kept = other.app().model.calibration.clone();
    assert!(kept.bias.is_some_and(|path| path.ends_with("bias.png")) && kept.flat.is_some());
    // Without calibration, values are as in the files.
    other.run_action("calibration");
    other.click("Reset");
    other.click("Apply");
    other.settle();
    assert!((value(&other, 0, 0) - 1300.0).abs() < 3.0);
}

#[test]
fn a_calibration_that_does_not_fit_is_said_and_the_burst_stays() {
    let home = tempfile::tempdir().unwrap();
    frames(home.path());
    let wrong = home.path().join("small.png");
    image::GrayImage::new(8, 8).save(&wrong).unwrap();
    let mut window = Start::of(&home.path().join("night")).open();
    window.run_action("calibration");
    window.drop_file(wrong);
    window.harness.get_by_role_and_label(Role::CheckBox, "Linear light").click();
    window.harness.run_steps(2);
    window.click("Apply");
    window.wait("a message", |app| !app.model.messages.errors().is_empty());
    assert!(window.shows("the bias frame is 8×8"));
    assert_eq!(window.app().model.slots.a.burst.as_ref().unwrap().burst.len(), 4);
}

#[test]
fn a_film_that_was_opened_as_a_burst_is_cut_with_one_click() {
    let folder = tempfile::tempdir().unwrap();
    // A few frames more than a usual burst has.
    let film = folder.path().join("film");
    std::fs::create_dir_all(&film).unwrap();
    let (burst, truth) = burstscope::synth::synth_scene(
        &burstscope::synth::SceneParams { width: 64, height: 48, frames: 36, max_slope: 0.3, ..Default::default() },
        &burstscope::Monitor::default(),
    )
    .unwrap();
    let path = film.join("walk");
    burstscope::synth::write_burst(&path, &burst, &truth, &burstscope::Monitor::default()).unwrap();
    let mut window = Start::of(&path).open();
    assert!(window.shows("36 frames are long for one burst"));
    let length = 36 / window.app().remembered().burst_length;
    let label = format!("Cut into bursts of {}", window.app().remembered().burst_length);
    window.click(&label);
    window.settle();
    assert_eq!(dataset(&window).bursts.len(), length);
    assert!(!window.shows("frames are long for one burst"));
    window.settle();
    // A burst of usual length has no note.
    let stack = noisy_stack(folder.path(), 10, 40, 40);
    let short = Start::of(&stack).open();
    assert!(!short.shows("are long for one burst"));
}

#[test]
fn features_of_other_parameters_are_replaced_only_after_a_question() {
    let home = tempfile::tempdir().unwrap();
    let mut window = start(walk(home.path())).open();
    window.click("Detect all");
    window.settle();
    let features = |window: &crate::support::Window| -> Vec<usize> {
        dataset(window).states.iter().map(|s| if let BurstState::Done(f) = s { f.features } else { 0 }).collect()
    };
    let before = features(&window);
    assert!(before.iter().all(|count| *count > 2), "{before:?}");
    window.app_mut().model.params.max_features = 2;
    window.harness.run_steps(2);
    window.click("Detect all");
    window.harness.run_steps(3);
    assert!(window.shows("Replace features?") && window.shows("The bursts themselves are not touched"));
    window.click("Cancel");
    window.settle();
    assert_eq!(features(&window), before);
    window.click("Detect all");
    window.harness.run_steps(3);
    window.click("Replace");
    window.settle();
    assert_eq!(features(&window), [2; 3]);
    // With unchanged parameters work continues without a question.
    window.click("Detect all");
    window.settle();
    assert!(!window.shows("Replace features?"));
}

#[cfg(feature = "colmap")]
#[test]
fn the_window_writes_the_database_that_the_command_writes() {
    use burstscope::burst::OpenOptions;
    use burstscope::dataset::{CameraChoice, ColmapJob, FeatureJob, ImageKind, export_colmap};
    use burstscope::matching::{CameraModel, MatchParams, PairSelection};
    let home = tempfile::tempdir().unwrap();
    let mut window = start(walk(home.path())).open();
    let (ours, theirs) = (home.path().join("from-window"), home.path().join("from-command"));
    window.dialogs.will_choose(&ours);
    window.run_action("export colmap database");
    window.settle();
    assert!(window.shows("database.db: 3 images, 3 pairs"));
    let job = ColmapJob {
        features: FeatureJob {
            detector: few_slopes().into(),
            open: OpenOptions::default(),
            images: ImageKind::default(),
        },
        matching: MatchParams::default(),
        pairs: PairSelection::All,
        camera: CameraChoice::Guessed(CameraModel::SimpleRadial),
    };
    let bursts = dataset(&window).bursts.clone();
    let report = export_colmap(&bursts, &theirs, &job, &mut |_| {}, &burstscope::Monitor::default()).unwrap();
    assert_eq!(report.images.len(), 3);
    let read = |path: std::path::PathBuf| std::fs::read(path).unwrap();
    for image in &report.images {
        let file = format!("features/{}.txt", image.image);
        assert_eq!(read(ours.join(&file)), read(theirs.join(&file)), "{file}");
    }
    assert_eq!(read(ours.join("database.db")), read(theirs.join("database.db")));
    assert!(window.harness.query_by_label_contains("from-window").is_some() || window.shows("from-window"));
}

/// Window with an example of the Help menu: slopes are found unless the example has its own.
fn example(example: Example) -> Window {
    let mut start = Start { size: [1280.0, 800.0], ..Start::automatic() };
    start.startup.source = Some(BurstSource::Example(example));
    start.open()
}

#[test]
fn an_example_opens_probed_and_a_remedy_is_applied_and_taken_back() {
    let mut window = example(Example::LowContrast);
    let place = Example::LowContrast.place();
    assert_eq!(answer(&window).probe.pos_image, place);
    assert_eq!(window.app().model.slopes, SlopeChoice::Given);
    assert!(window.shows("Nothing was kept here") && window.shows("Below the noise gate"), "it is said at once");
    let first = answer(&window).probe.subject_fate().expect("a candidate").remedy.clone().expect("a remedy");
    assert!(window.shows(&first.change.label()) && first.then_fails.is_none(), "and what would keep it");
    window.snapshot("probe_low_contrast");
    let fates = answer(&window).probe.fates.clone();
    let lost = fates
        .iter()
        .position(|fate| {
            fate.first_failed == Some(Test::NoiseGate) && fate.remedy.as_ref().is_some_and(|r| r.then_fails.is_none())
        })
        .expect("a candidate that only the gate takes");
    assert!(lost < 6, "it is among the first that came far: {lost}");
    let name = format!("Candidate {}: noise gate", lost + 1);
    window.harness.query_all_by_label_contains(&name).next().expect("it is listed").click();
    window.harness.run_steps(2);
    window.settle();
    assert_eq!(answer(&window).probe.subject_fate().map(|f| f.of_sample()), Some(fates[lost].of_sample()));
    assert!(window.shows("Below the noise gate"));
    let (before, change) = (window.app().model.params.clone(), fates[lost].remedy.clone().unwrap().change);
    window.click(&format!("Apply {}", change.label()));
    window.settle();
    let gate = window.app().model.params.noise_gate;
    assert!(matches!(gate, NoiseGate::Factor(_)) && gate != before.noise_gate);
    let now = answer(&window);
    assert!(!window.app().model.probe_is_stale());
    let fate = now.probe.fates.iter().find(|f| f.of_sample() == fates[lost].of_sample()).expect("the same candidate");
    assert_ne!(fate.first_failed, Some(Test::NoiseGate));
    window.ctrl(Key::Z);
    window.settle();
    assert_eq!(window.app().model.params, before);
    assert_eq!(window.app().model.slots.a.found.as_ref().unwrap().params.noise_gate, before.noise_gate);
    // Another burst is searched at slopes that are found in it.
    window.run_action("open demo burst");
    window.settle();
    assert!(window.app().model.slopes.is_auto() && window.app().model.probe.place().is_none());
}

#[test]
fn the_garlands_open_on_an_alias_with_its_evidence() {
    let mut window = example(Example::Aliasing);
    let probed = &answer(&window).probe;
    assert_eq!(probed.pos_image, Example::Aliasing.place());
    let fate = probed.subject_fate().expect("a candidate").clone();
    assert!(fate.is_kept() && (fate.slope.u - Example::Aliasing.slope_u()).abs() < 0.5, "{fate:?}");
    let alias = probed.suspicions.iter().find(|s| s.kind == Kind::Alias).expect("an alias").clone();
    // The object that really moves there responds more strongly, one period of the texture away.
    let other = alias.other_slope.expect("another slope");
    assert!((other.u - ALIASING_SLOPE).abs() < 0.2 && alias.number > 1.0, "{alias:?}");
    assert!(window.shows("An alias?") && window.shows("repeats every 8 px"), "it is said at once");
    // The picture is that of a slope at which nothing moves, and yet the garlands are sharp.
    let slope = window.app().model.cursor().slope;
    assert_eq!((slope.u, slope.v), (ALIASING_SLOPE - GARLAND_PERIOD, 0.0));
    assert_eq!(Example::Aliasing.slope_u(), slope.u);
    window.snapshot("probe_aliasing");
    // With other parameters the place is probed again.
    window.app_mut().model.params.edge_threshold = 10.0;
    window.settle();
    assert_eq!(answer(&window).probe.pos_image, Example::Aliasing.place());
    // With other slopes and octaves the probe answers too.
    let mut start = Start::default();
    start.startup.params.detector.first_octave = 1;
    start.startup.source = Some(BurstSource::Example(Example::Aliasing));
    assert_eq!(answer(&start.open()).probe.pos_image, Example::Aliasing.place());
}
