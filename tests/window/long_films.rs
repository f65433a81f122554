//! A film opened as one burst, features of other parameters, and COLMAP's database.

use crate::datasets::{dataset, few_slopes, walk_open};
use crate::support::*;

#[test]
fn a_film_that_was_opened_as_a_burst_is_cut_with_one_click() {
    let folder = folder();
    // A few frames more than a usual burst has.
    let film = folder.join("film");
    fs::create_dir_all(&film).unwrap();
    let (burst, truth) = burstscope::synth::synth_scene(
        &burstscope::synth::SceneParams { width: 64, height: 48, frames: 36, max_slope: 0.3, ..Default::default() },
        &Monitor::default(),
    )
    .unwrap();
    let path = film.join("walk");
    burstscope::synth::write_burst(&path, &burst, &truth, &Monitor::default()).unwrap();
    let mut window = Start::of(&path).open();
    assert!(window.shows("36 frames are long for one burst"));
    let length = 36 / window.app().settings.burst_length;
    let label = format!("Cut into bursts of {}", window.app().settings.burst_length);
    window.click(&label).settle();
    assert_eq!(dataset(&window).bursts.len(), length);
    assert!(!window.shows("frames are long for one burst"));
    window.settle();
    // A burst of usual length has no note.
    assert!(!Start::of(&noisy_stack(&folder, 10, 40, 40)).open().shows("are long for one burst"));
}

#[test]
fn features_of_other_parameters_are_replaced_only_after_a_question() {
    let (_home, mut window) = walk_open();
    window.click("Detect all").settle();
    let features = |window: &Window| -> Vec<usize> {
        dataset(window).states.iter().map(|s| if let BurstState::Done(f) = s { f.features } else { 0 }).collect()
    };
    let before = features(&window);
    assert!(before.iter().all(|count| *count > 2), "{before:?}");
    window.change(|document| document.params.max_features = 2).steps(2).click("Detect all").steps(3);
    assert!(window.shows("Replace features?") && window.shows("The bursts themselves are not touched"));
    window.click("Cancel").settle();
    assert_eq!(features(&window), before);
    window.click("Detect all").steps(3).click("Replace").settle();
    assert_eq!(features(&window), [2; 3]);
    window.click("Detect all").settle();
    assert!(!window.shows("Replace features?"));
}

#[cfg(feature = "colmap")]
#[test]
fn the_window_writes_the_database_that_the_command_writes() {
    use burstscope::burst::OpenOptions;
    use burstscope::dataset::{BurstCameras, ColmapJob, FeatureJob, FeatureStore, ImageKind, export_colmap};
    use burstscope::matching::{MatchParams, PairSelection};
    let (home, mut window) = walk_open();
    let (ours, theirs) = (home.join("from-window"), home.join("from-command"));
    window.will_choose(&ours).run_action("export colmap database").settle();
    assert!(window.shows("database.db: 3 images, 3 pairs"));
    let job = ColmapJob {
        features: FeatureJob {
            detector: few_slopes().into(),
            open: OpenOptions::default(),
            images: ImageKind::default(),
        },
        matching: MatchParams::default(),
        pairs: PairSelection::All,
        cameras: BurstCameras::default(),
    };
    let bursts = dataset(&window).bursts.clone();
    let mut store = FeatureStore::open(&theirs, &job.features).unwrap();
    let report = export_colmap(&mut store, &bursts, &job, &mut |_| {}, &Monitor::default()).unwrap();
    assert_eq!(report.images.len(), 3);
    let read = |path: PathBuf| fs::read(path).unwrap();
    for image in &report.images {
        let file = format!("features/{}.txt", image.image);
        assert_eq!(read(ours.join(&file)), read(theirs.join(&file)), "{file}");
    }
    assert_eq!(read(ours.join("database.db")), read(theirs.join("database.db")));
    assert!(window.harness.query_by_label_contains("from-window").is_some() || window.shows("from-window"));
}
