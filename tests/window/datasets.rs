//! Many bursts: opening, cutting, detecting all, resuming, choosing two.

use crate::support::*;
use burstscope::app::results::datasets::Dataset;
use burstscope::dataset::DatasetSource;
use burstscope::synth::{SceneParams, synth_scene, write_burst};

/// Writes fifteen frames of a trajectory past a layered scene, in a folder of `home`.
pub fn film(home: &Path) -> PathBuf {
    let params = SceneParams {
        width: 200,
        height: 150,
        frames: 15,
        max_slope: 1.5,
        snr: 20.0,
        seed: 3,
        ..SceneParams::default()
    };
    let (burst, truth) = synth_scene(&params, &Monitor::default()).unwrap();
    let film = home.join("film");
    write_burst(&film, &burst, &truth, &Monitor::default()).unwrap();
    film
}

pub fn walk(home: &Path) -> DatasetSource {
    DatasetSource { paths: vec![film(home)], burst_length: Some(5), burst_step: None }
}

pub fn few_slopes() -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 5), ..DetectorParams::default() }
}

pub fn start(dataset: DatasetSource) -> Start {
    let startup = Startup { source: None, dataset: Some(dataset), params: few_slopes().into(), ..Startup::default() };
    let settings = Start::without_auto_detect().startup.settings;
    Start { size: [1280.0, 800.0], startup: Startup { settings, ..startup }, ..Start::default() }
}

pub fn walk_open() -> (Folder, Window) {
    let home = folder();
    let window = start(walk(&home)).open();
    (home, window)
}

pub fn dataset(window: &Window) -> &Dataset {
    window.results().datasets.open.as_ref().expect("a dataset is open")
}

pub fn chosen(window: &Window) -> [Option<usize>; 2] {
    window.document().dataset.as_ref().expect("a dataset is open").pair.both().map(|place| *place)
}

fn features(window: &Window) -> Vec<Option<usize>> {
    let count = |state: &BurstState| if let BurstState::Done(f) = state { Some(f.features) } else { None };
    dataset(window).states.iter().map(count).collect()
}

pub fn click_burst(window: &mut Window, label: &str) {
    window.harness.get_by_label_contains(label).click();
    window.steps(2);
}

#[test]
fn a_folder_of_bursts_opens_as_a_filmstrip_and_a_stray_picture_in_it_is_named() {
    let (folder, nights) = folder_with("nights");
    for (name, frames) in [("first", 3), ("second", 6)] {
        fs::create_dir_all(nights.join(name)).unwrap();
        noisy_stack(&nights.join(name), frames, 40, 40);
    }
    let mut window = Start::without_auto_detect().open();
    window.will_choose(&nights).click("Open…").settle();
    // The folder holds one stack in each subfolder; stacks are named after themselves.
    let names: Vec<&str> = dataset(&window).bursts.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["first", "second"]);
    assert_eq!(window.read().frame_count(), 3);
    assert!(window.shows("2 bursts, 0 done"));
    click_burst(&mut window, "Burst second");
    window.settle();
    assert_eq!(window.read().frame_count(), 6);
    window.ctrl(Key::ArrowLeft).settle();
    assert_eq!(window.read().frame_count(), 3);
    assert_eq!(window.app().settings.datasets, [DatasetSource::of_bursts(vec![nights])]);
    assert!(window.app().settings.recent.is_empty(), "bursts of a dataset are not remembered one by one");
    window.click("Close dataset");
    assert!(window.results().datasets.open.is_none() && !window.shows("Burst second"));
    window.will_choose(folder.join("nights")).run_action("open b: folder");
    window.wait("the choice", |app| app.choice().len() == 2);
    assert!(window.results().datasets.open.is_none());
    let (home, nights) = folder_with("nights");
    for (folder, shade) in [("nights/a", 9u8), ("nights/b", 12)] {
        fs::create_dir_all(home.join(folder)).unwrap();
        for t in 0..2 {
            let frame = image::GrayImage::from_fn(40, 30, |u, v| image::Luma([shade + ((u * 7 + v * 3) % 50) as u8]));
            frame.save(home.join(format!("{folder}/{t}.png"))).unwrap();
        }
    }
    image::GrayImage::new(40, 30).save(nights.join("preview.png")).unwrap();
    let mut window = start(DatasetSource::of_bursts(vec![nights])).open_without_waiting();
    window.wait("the dataset is open", |app| app.model.results.datasets.open.is_some());
    assert_eq!(dataset(&window).bursts.len(), 2);
    assert!(window.shows("belongs to none") && window.shows("preview.png"));
}

#[test]
fn all_bursts_are_detected_and_found_done_by_the_next_window() {
    let home = folder();
    let source = walk(&home);
    let mut window = start(source.clone()).open();
    assert!(window.shows("Burst frame_002: waiting") && window.shows("Burst frame_012: waiting"));
    assert!(window.shows("frame_002 · 5 frames"), "the burst that is open has its name in the dataset");
    window.click("Detect all");
    assert!(window.results().datasets.work.is_some());
    window.settle();
    let found = features(&window);
    let params = few_slopes();
    for (burst, found) in source.bursts(&OpenOptions::default()).unwrap().iter().zip(&found) {
        let open = OpenOptions::default();
        let opened = Burst::open_with(&burst.paths, &open, &Monitor::default()).unwrap();
        let expected = burstscope::detect(&opened, &params, &Monitor::default()).unwrap();
        assert_eq!(*found, Some(expected.features.len()), "{}", burst.name);
    }
    assert!(window.shows("3 bursts, 3 done") && window.shows("3 bursts done in"));
    assert!(home.join("film-burstscope-5/features/frame_007.png.txt").is_file());
    fs::remove_file(home.join("film-burstscope-5/features/frame_007.png.txt")).unwrap();
    let mut next = start(source.clone()).open();
    assert_eq!(features(&next), [found[0], None, found[2]]);
    next.ctrl(Key::D).settle();
    assert_eq!(features(&next), found);
    let mut other = start(source);
    other.startup.params.edge_threshold *= 1.5;
    let mut other = other.open();
    assert_eq!(features(&other), [None; 3]);
    assert!(other.shows("The folder has features found with other parameters"));
    other.click("Use those").settle();
    assert_eq!((features(&other), &other.document().params), (found, &params.clone().into()));
    other.set().params.edge_threshold *= 2.0;
    other.settle();
    assert!(other.shows("The parameters changed"));
}

#[test]
fn a_burst_that_fails_says_why_and_the_others_go_on() {
    let home = folder();
    let source = walk(&home);
    fs::write(home.join("film/frame_006.png"), "broken").unwrap();
    let mut window = start(source).open();
    window.click("Detect all").settle();
    assert!(window.shows("3 bursts, 2 done, 1 failed"));
    assert!(window.shows("Burst frame_007: failed"));
    let BurstState::Failed(error) = &dataset(&window).states[1] else { panic!("it failed") };
    assert!(error.contains("frame_006.png"), "{error}");
    assert!(window.shows("1 failed, see the filmstrip"));
}

#[cfg(feature = "raw")]
#[test]
fn harmful_files_of_a_dataset_lose_their_bursts_alone() {
    let (_home, nights) = folder_with("nights");
    let png = crate::crafted::packed_chunks_png(1 << 16);
    for (name, file, bytes) in [
        ("b", "bad.dng", crate::crafted::huge_count_dng(12)),
        ("c", "bad.raf", crate::crafted::huge_count_raf()),
        ("d", "bad.png", png[..png.len() / 2].to_vec()),
    ] {
        fs::create_dir_all(nights.join(name)).unwrap();
        fs::write(nights.join(name).join(file), bytes).unwrap();
    }
    for name in ["a", "e"] {
        fs::create_dir_all(nights.join(name)).unwrap();
        noisy_stack(&nights.join(name), 3, 48, 48);
    }
    let dataset_source = DatasetSource { paths: vec![nights], burst_length: None, burst_step: None };
    let mut window = start(dataset_source).open();
    window.click("Detect all").settle();
    let states = &dataset(&window).states;
    let failed: Vec<bool> = states.iter().map(|state| matches!(state, BurstState::Failed(_))).collect();
    assert_eq!(failed, [false, true, true, true, false], "{states:?}");
    assert!(features(&window)[0].is_some() && features(&window)[4].is_some());
}

#[test]
fn what_is_done_stays_when_it_is_cancelled() {
    let home = folder();
    let mut start = start(walk(&home));
    start.startup.params.slopes = SlopeGrid::plane(-4.0..=4.0, 17, -4.0..=4.0, 17).into();
    let mut window = start.open();
    window.click("Detect all");
    window.wait("the first burst is done", |app| {
        app.model.results.datasets.open.as_ref().is_some_and(|d| matches!(d.states[0], BurstState::Done(_)))
    });
    assert!(window.results().datasets.work.is_some(), "it must still run for this test to mean something");
    // The inspector works meanwhile.
    window.slide("Slope u", 1.0).wait("the picture of the new slope", |app| app.read().picture_is_current());
    window.click("Cancel all").wait("it ends", |app| app.model.results.datasets.work.is_none());
    let done = dataset(&window).counts().done;
    assert!((1..3).contains(&done), "{done}");
    assert!(!dataset(&window).states.contains(&BurstState::Running));
    assert!(window.shows("cancelled; what is done stays done"));
}

#[test]
fn a_long_sequence_is_cut_as_one_says() {
    let home = folder();
    let mut window = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() }.open();
    window.will_choose(film(&home)).run_action("open dataset");
    window.wait("the question", |app| app.model.results.datasets.work.is_none());
    assert!(window.shows("15 frames") && window.shows("1 burst, each named"));
    window.slide("Burst length", 6.0).steps(2);
    assert!(window.shows("2 bursts, each named after its middle frame; the last 3 frames are left out"));
    window.click("Cut").settle();
    let names: Vec<&str> = dataset(&window).bursts.iter().map(|b| b.name.as_str()).collect();
    assert_eq!((names, window.read().frame_count()), (vec!["frame_003", "frame_009"], 6));
    window.run_action("cut into bursts");
    assert!(window.shows("6 frames"));
    window.key(Key::Escape).settle();
    assert!(!window.shows("Cut a sequence into bursts"));
}

#[test]
fn a_and_b_are_chosen_in_the_strip_or_by_action_and_a_session_brings_them_back() {
    let (_home, mut window) = walk_open();
    click_burst(&mut window, "Use frame_007 as A");
    click_burst(&mut window, "Use frame_012 as B");
    assert_eq!(chosen(&window), [Some(1), Some(2)]);
    window.run_action("use burst as b");
    assert_eq!(chosen(&window), [Some(1), Some(0)]);
    let (home, file) = folder_with("walk.burstscope.toml");
    let mut window = start(walk(&home)).open();
    click_burst(&mut window, "Burst frame_007");
    window.settle();
    click_burst(&mut window, "Use frame_012 as B");
    let other = window.kept_and_opened_in_another(&file);
    assert_eq!((chosen(&other), dataset(&other).bursts.len()), ([None, Some(2)], 3));
    assert_eq!(Read::of(other.model()).place_of(Side::A), Some(1));
}

#[test]
fn folders_that_will_not_do_are_named() {
    let (home, mut window) = walk_open();
    let own = home.join("own");
    fs::create_dir(&own).unwrap();
    fs::write(own.join("thesis.txt"), "precious").unwrap();
    window.will_choose(&own).click("Choose feature folder…").settle();
    assert!(window.shows("name a new or an empty folder") && window.shows("own"));
    assert!(window.shows("Features cannot be kept here"));
    let detect = window.harness.get_by_role_and_label(Role::Button, "Detect all");
    assert!(NodeT::accesskit_node(&detect).is_disabled());
    window.will_choose(home.join("new")).click("Choose feature folder…").settle();
    assert!(!window.shows("Features cannot be kept here"));
    window.click("Detect all").settle();
    assert!(home.join("new/manifest.json").is_file());
    window.drop_file(own).settle();
    assert!(window.shows("holds no pictures") && dataset(&window).bursts.len() == 3);
}
