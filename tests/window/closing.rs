//! The window is closed while files are written: files that were begun are finished, cancelled ones leave nothing half
//! done.

use crate::{lab::run_small_study, support::*};
use burstscope::app::document::panes::MeasuredLine;
use burstscope::engine::Wanted;
use burstscope::figures::{FigureSize, FiguresJob, PaperFigure};
use std::{convert::Infallible, sync::Mutex, sync::mpsc};

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found.sort();
    found
}

fn assert_nothing_half_written(folder: &Path) {
    for file in files(folder) {
        let is_unfinished = |part: &std::ffi::OsStr| part.to_string_lossy().ends_with(".tmp");
        assert!(!file.iter().any(is_unfinished), "{}", file.display());
        let text = || fs::read_to_string(&file).unwrap();
        match file.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => assert!(burstscope::export::is_ours(&file), "{}", file.display()),
            Some("png") => assert!(image::open(&file).is_ok(), "{}", file.display()),
            Some("json") => assert!(serde_json::from_str::<serde_json::Value>(&text()).is_ok(), "{}", file.display()),
            Some("csv") => assert!(text().ends_with('\n'), "{}", file.display()),
            _ => {}
        }
    }
}

/// Runs until it is cancelled, and drops its sender then.
#[derive(Clone)]
struct UntilCancelled {
    release: Arc<Mutex<Option<mpsc::Sender<()>>>>,
}

impl PartialEq for UntilCancelled {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Request for UntilCancelled {
    type Answer = ();
    type Partial = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<(), JobError> {
        while !work.monitor.is_cancelled() {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.release.lock().unwrap().take();
        Ok(work.monitor.check()?)
    }
}

/// Holds back the writing of files until the window is being closed: a task before them waits for a search job, which
/// releases it when it is cancelled.
fn hold_files_until_closing(window: &Window) -> Wanted<UntilCancelled> {
    let engine = &window.app().engine;
    let (release, held) = mpsc::channel::<()>();
    let mut closing = Wanted::default();
    closing.ask(engine, UntilCancelled { release: Arc::new(Mutex::new(Some(release))) });
    engine.task("Hold", move || {
        // Returns when the sender is dropped.
        let _ = held.recv();
        Ok(String::new())
    });
    closing
}

/// Begins these exports, by their actions and files in `folder`; none is written yet.
fn begin(window: &mut Window, folder: &Path, exports: &[(&str, &str)]) {
    for (action, name) in exports {
        window.will_choose(folder.join(name)).run_action(action).wait("the file is chosen", |app| !app.is_asking());
    }
    assert_eq!(files(folder), Vec::<PathBuf>::new());
}

/// Checks that all of these files are there, whole, and no others.
fn assert_written(folder: &Path, exports: &[(&str, &str)]) {
    let mut wanted: Vec<PathBuf> = exports.iter().map(|(_, name)| folder.join(name)).collect();
    wanted.sort();
    assert_eq!(files(folder), wanted);
    assert_nothing_half_written(folder);
}

#[test]
fn every_export_that_was_begun_is_whole_when_the_window_is_gone() {
    let folder = folder();
    let mut window = Start::without_auto_detect().open();
    window.click("Detect").settle();
    let count = window.read().features().len();
    let closing = hold_files_until_closing(&window);
    let exports = [
        ("features as csv", "f.csv"),
        ("features for colmap", "f.txt"),
        ("features as npz", "f.npz"),
        ("32-bit tiff", "p.tiff"),
        ("picture as png", "p.png"),
        ("figure as before", "p.svg"),
        ("figure as before", "figure.png"),
        ("figure as before", "figure.pdf"),
        ("save parameters", "params.toml"),
        ("save session", "session.toml"),
    ];
    begin(&mut window, &folder, &exports);
    drop((window, closing));
    assert_written(&folder, &exports);
    let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(text("f.csv").lines().count(), count + 1);
    assert_eq!(text("f.txt").lines().count(), count + 1);
    ndarray_npy::NpzReader::new(fs::File::open(folder.join("f.npz")).unwrap()).unwrap();
    assert_eq!(Burst::open(folder.join("p.tiff")).unwrap().size(), (480, 360));
    SearchParams::from_toml(&text("params.toml")).unwrap();
    burstscope::app::session::Session::from_toml(&text("session.toml")).unwrap();
}

#[test]
fn what_was_matched_and_measured_is_whole_too() {
    let folder = folder();
    let mut window = Start::two_bursts([1400.0, 900.0]).open();
    let matches = window.matches().result.counts.putative;
    run_small_study(&mut window);
    let closing = hold_files_until_closing(&window);
    let of_lab = [("export curves as csv", "c.csv"), ("export curves as svg", "c.svg")];
    begin(&mut window, &folder, &of_lab);
    window.ctrl(Key::Num2);
    let of_pair = [("export matches as csv", "m.csv"), ("figure as before", "m.png")];
    begin(&mut window, &folder, &of_pair);
    window.ctrl(Key::Num1);
    let pane = window.document().focus();
    let (from_image, to_image) = (pos2(100.0, 80.0), pos2(160.0, 80.0));
    window.set().measure.line = Some(MeasuredLine { pane, from_image, to_image });
    window.wait("there is something to measure", |app| app.read().picture().is_some());
    let of_line = [("export line profile as csv", "l.csv")];
    begin(&mut window, &folder, &of_line);
    drop((window, closing));
    assert_written(&folder, &[&of_lab[..], &of_pair[..], &of_line[..]].concat());
    let lines = |name: &str| fs::read_to_string(folder.join(name)).unwrap().lines().count();
    assert_eq!(lines("m.csv"), matches + 1);
    assert!(lines("l.csv") > 60 && lines("c.csv") > 2);
}

#[test]
fn figures_that_are_being_made_are_whole_or_not_there() {
    let (_folder, out) = folder_with("paper");
    let mut window = Start::nothing_open().open_without_waiting();
    let only = vec![PaperFigure::Fig9, PaperFigure::Fig5];
    let app = window.app_mut();
    let job = FiguresJob { out: out.clone(), only, size: FigureSize::Quick, colmap: None };
    app.model.results.figures.ask(&app.engine, job);
    while files(&out).is_empty() {
        assert!(!window.app().engine.is_idle(), "it ended without a file");
        std::thread::sleep(Duration::from_millis(1));
    }
    drop(window);
    assert_nothing_half_written(&out);
}

#[cfg(feature = "colmap")]
#[test]
fn a_dataset_that_is_being_exported_leaves_whole_files_and_goes_on_later() {
    use crate::datasets::{dataset, few_slopes, walk_open};
    use burstscope::dataset::{BurstCameras, ColmapJob, FeatureJob, FeatureStore, ImageKind, export_colmap};
    use burstscope::matching::{MatchParams, PairSelection};
    let (home, mut window) = walk_open();
    let (ours, theirs) = (home.join("from-window"), home.join("from-command"));
    let bursts = dataset(&window).bursts.clone();
    window.will_choose(&ours).run_action("export colmap database");
    window.wait("the first features are there", |_| {
        files(&ours).iter().any(|file| file.starts_with(ours.join("features")))
    });
    drop(window);
    assert_nothing_half_written(&ours);
    let job = ColmapJob {
        features: FeatureJob { detector: few_slopes().into(), open: Default::default(), images: ImageKind::default() },
        matching: MatchParams::default(),
        pairs: PairSelection::All,
        cameras: BurstCameras::default(),
    };
    for out in [&ours, &theirs] {
        let mut store = FeatureStore::open(out, &job.features).unwrap();
        export_colmap(&mut store, &bursts, &job, &mut |_| {}, &Monitor::default()).unwrap();
    }
    let database = |folder: &Path| fs::read(folder.join("database.db")).unwrap();
    assert_eq!(database(&ours), database(&theirs));
}
