//! What the window asks the engine to do with a dataset, and what it does with the answers.

use crate::app::dataset::cut::CutDialog;
use crate::app::dataset::matches::BurstPair;
use crate::app::dataset::model::{Dataset, Work};
use crate::app::dataset::trajectories::Which;
use crate::app::project::workspace::Workspace;
use crate::app::session::{SavedDataset, SavedTrajectories};
use crate::app::window::BurstscopeApp;
use crate::dataset::DatasetSource;
use crate::engine::{
    BurstSource, ComparedPoses, DatasetAnswer, DatasetRequest, DatasetUpdate, JobAnswer, JobError, OpenDataset,
    PosesRequest, TrajectorySource,
};
use crate::inspect::words::counted;
use std::path::PathBuf;

/// A burst of at least this many frames is rather a film: nothing moves evenly for so long.
const FILM_FRAMES: usize = 30;

impl BurstscopeApp {
    /// Opens a dataset in the background; what is open stays until it is there.
    pub fn open_dataset(&mut self, source: DatasetSource) {
        self.look_at_dataset(source, None);
    }

    /// Opens the bursts at `paths` as a dataset; a long sequence that lies there alone is first asked about.
    pub(in crate::app) fn look_at_dataset(&mut self, source: DatasetSource, folder: Option<PathBuf>) {
        self.model.datasets.work = Some(Work::Opening);
        self.engine.datasets.submit(DatasetRequest::Open { source, folder, params: self.model.asked() });
    }

    /// Opens the dataset of a session, or none.
    pub(in crate::app) fn restore_dataset(&mut self, saved: Option<SavedDataset>) {
        match saved {
            Some(SavedDataset { source, folder, a, b }) => {
                self.model.datasets.restoring = Some([a, b]);
                self.look_at_dataset(source, folder);
            }
            None => self.close_dataset(),
        }
    }

    /// Keeps the dataset's features in `folder` from now on.
    pub(in crate::app) fn use_feature_folder(&mut self, folder: PathBuf) {
        if let Some(dataset) = &self.model.datasets.open {
            self.look_at_dataset(dataset.source.clone(), Some(folder));
        }
    }

    /// Takes over the parameters with which the features in the dataset's folder were found.
    pub(in crate::app) fn use_folder_params(&mut self) {
        let Some(dataset) = &self.model.datasets.open else { return };
        let (source, folder) = (dataset.source.clone(), dataset.folder.clone());
        if let Some(params) = dataset.other_params.clone() {
            self.model.set_search(params);
            self.look_at_dataset(source, folder);
        }
    }

    /// Asks how the burst that is open is cut into shorter ones.
    pub(in crate::app) fn ask_for_cut(&mut self) {
        if let Some(open) = &self.model.burst
            && let BurstSource::Paths(paths) = &open.source
        {
            self.overlays.cut = Some(CutDialog::new(paths.clone(), open.burst.len(), self.burst_length()));
        }
    }

    /// Frames of each burst when the film that is open is cut with one click; `None` where there is nothing to cut.
    pub(in crate::app) fn offered_cut(&self) -> Option<usize> {
        let open = self.model.burst.as_ref()?;
        let in_dataset = self.model.datasets.open.as_ref().is_some_and(|d| d.place_of(Some(open)).is_some());
        let is_film = matches!(open.source, BurstSource::Paths(_)) && open.burst.len() >= FILM_FRAMES;
        let asked = self.overlays.stays_whole == Some(open.id) || self.overlays.cut.is_some();
        (is_film && !in_dataset && !asked).then(|| self.burst_length())
    }

    /// Cuts the film that is open into bursts of `length` frames, one after another, and opens them as a dataset.
    pub(in crate::app) fn cut_open_burst(&mut self, length: usize) {
        if let Some(open) = &self.model.burst
            && let BurstSource::Paths(paths) = &open.source
        {
            self.open_dataset(DatasetSource { paths: paths.clone(), burst_length: Some(length), burst_step: None });
        }
    }

    /// The film that is open is looked at as one burst: cutting it is not offered any more.
    pub(in crate::app) fn keep_burst_whole(&mut self) {
        self.overlays.stays_whole = self.model.burst.as_ref().map(|open| open.id);
    }

    pub(in crate::app) fn close_dataset(&mut self) {
        self.engine.datasets.cancel();
        self.model.datasets = Default::default();
        self.thumbnails.clear();
    }

    /// Finds the features of all bursts; where that replaces features of other parameters, it asks first.
    pub(in crate::app) fn ask_and_detect_all(&mut self) {
        let params = self.model.asked();
        match &self.model.datasets.open {
            Some(dataset) if dataset.would_replace(&params) => self.overlays.replace_features = true,
            _ => self.detect_all(),
        }
    }

    pub(in crate::app) fn detect_all(&mut self) {
        let params = self.model.asked();
        let Some(dataset) = &mut self.model.datasets.open else { return };
        dataset.begin_detection(&params);
        if let Some(keeping) = dataset.keeping() {
            let bursts = dataset.bursts.clone();
            self.model.datasets.work = Some(Work::Detecting);
            self.model.messages.resolved(Work::Detecting.title());
            self.engine.datasets.submit(DatasetRequest::Detect { bursts, keeping });
        }
    }

    /// Matches the pairs that are chosen by rule.
    pub(in crate::app) fn match_pairs(&mut self) {
        if let Some(dataset) = &self.model.datasets.open {
            self.start_matching_pairs(self.model.datasets.choice.selection().pairs(dataset.bursts.len()));
        }
    }

    /// Matches A with B.
    pub(in crate::app) fn match_selected(&mut self) {
        if let Some(pair) = self.model.datasets.open.as_ref().and_then(Dataset::selected) {
            self.start_matching_pairs(vec![pair]);
        }
    }

    fn start_matching_pairs(&mut self, pairs: Vec<BurstPair>) {
        let matching = self.model.pair.params.clone();
        let Some(dataset) = &mut self.model.datasets.open else { return };
        dataset.matches.begin(&matching);
        if let Some(keeping) = dataset.keeping() {
            let bursts = dataset.bursts.clone();
            self.model.datasets.work = Some(Work::Matching);
            self.model.messages.resolved(Work::Matching.title());
            self.engine.datasets.submit(DatasetRequest::Match { bursts, keeping, pairs, matching });
        }
    }

    /// Opens A and B side by side.
    pub(in crate::app) fn show_selected_pair(&mut self) {
        let Some(dataset) = &self.model.datasets.open else { return };
        let [Some(a), Some(b)] = dataset.pair else { return };
        let (Some(source_a), Some(source_b)) = (dataset.source_at(a), dataset.source_at(b)) else { return };
        let a_is_open = dataset.place_of(self.model.burst.as_ref()) == Some(a);
        let b_is_open = dataset.place_of(self.model.pair.b.burst.as_ref()) == Some(b);
        if !a_is_open {
            self.open(source_a);
        }
        if !b_is_open {
            self.open_second(source_b);
        }
        self.model.workspace = Workspace::Pair;
    }

    /// Opens the burst `by` places after the one that is open in the inspector.
    pub(in crate::app) fn step_burst(&mut self, by: isize) {
        let Some(dataset) = &self.model.datasets.open else { return };
        let last = dataset.bursts.len() - 1;
        let next = match dataset.place_of(self.model.burst.as_ref()) {
            Some(place) => place.saturating_add_signed(by).min(last),
            None => 0,
        };
        self.open_burst_at(next);
    }

    pub(in crate::app) fn open_burst_at(&mut self, place: usize) {
        let dataset = self.model.datasets.open.as_ref();
        let here = dataset.and_then(|d| d.place_of(self.model.burst.as_ref())) == Some(place);
        if let Some(source) = dataset.and_then(|d| d.source_at(place)).filter(|_| !here) {
            self.open(source);
        }
    }

    /// Opens the burst of the camera with this label in the inspector, or says why there is none.
    pub(in crate::app) fn look_at_camera(&mut self, label: &str) {
        let dataset = self.model.datasets.open.as_ref();
        match dataset.map(|d| (d.place_of_camera(label), d.source.label())) {
            Some((Some(place), _)) => {
                self.open_burst_at(place);
                self.model.workspace = Workspace::Inspect;
            }
            Some((None, name)) => {
                self.model.messages.note(format!("{name} has no burst named like the camera {label}"));
            }
            None => self.model.messages.note(format!("Open the dataset that {label} is of to look at its burst")),
        }
    }

    /// Makes the burst that is open in the inspector A (0) or B (1).
    pub(in crate::app) fn choose_open_burst(&mut self, side: usize) {
        let shown = self.model.burst.as_ref();
        if let Some(dataset) = &mut self.model.datasets.open
            && let Some(place) = dataset.place_of(shown)
        {
            dataset.choose(side, place);
        }
    }

    pub(in crate::app) fn take_dataset_update(&mut self, ctx: &egui::Context, update: DatasetUpdate) {
        match update {
            DatasetUpdate::Event(event) => {
                if let Some(dataset) = &mut self.model.datasets.open {
                    dataset.take_event(&event);
                }
            }
            DatasetUpdate::Thumbnail { source, picture } => {
                if let Some(dataset) = &self.model.datasets.open {
                    self.thumbnails.take(ctx, &dataset.bursts, &source, picture);
                }
            }
            DatasetUpdate::Ended(answer) => self.take_dataset_answer(answer),
        }
    }

    fn take_dataset_answer(&mut self, answer: JobAnswer<DatasetAnswer>) {
        if answer.is_superseded() {
            return;
        }
        let work = self.model.datasets.work.take();
        if let Some(dataset) = &mut self.model.datasets.open {
            dataset.stop();
        }
        if answer.result.is_err() {
            self.model.datasets.restoring = None;
        }
        let title = work.map_or("Dataset", Work::title);
        match answer.result {
            Ok(DatasetAnswer::Opened(open)) => {
                self.model.messages.resolved(title);
                self.take_dataset(*open);
            }
            Ok(DatasetAnswer::Detected) => self.say_what_was_found(answer.elapsed.as_secs_f64()),
            Ok(DatasetAnswer::Matched { left_out }) => self.say_what_matched(left_out, answer.elapsed.as_secs_f64()),
            #[cfg(feature = "colmap")]
            Ok(DatasetAnswer::Colmap(done)) => {
                self.say_what_was_exported(&done);
            }
            Err(JobError::Cancelled) => {
                self.model.messages.note(format!("{title}: cancelled; what is done stays done"));
            }
            Err(error) => self.model.messages.error(title, error.to_string()),
        }
        // The states told of the folder that was written; those of the dataset's own are looked at again.
        let own = self.model.datasets.open.as_ref().map(|d| (d.source.clone(), d.folder.clone()));
        if let Some((source, folder)) = own.filter(|_| work == Some(Work::Exporting)) {
            self.look_at_dataset(source, folder);
        }
    }

    fn take_dataset(&mut self, open: OpenDataset) {
        let same = self.model.datasets.open.as_ref().is_some_and(|d| d.bursts == open.bursts);
        match open.frames_of_one {
            // A lone burst of many files is a sequence that is yet to be cut.
            Some(frames) if frames > 1 && open.source.burst_length.is_none() => {
                self.overlays.cut = Some(CutDialog::new(open.source.paths, frames, self.burst_length()));
                return;
            }
            Some(1) if open.source.burst_length.is_none() => {
                self.open(BurstSource::Paths(open.source.paths));
                return;
            }
            _ => {}
        }
        let restoring = self.model.datasets.restoring.take();
        if let Some(error) = &open.folder_error {
            self.model.messages.error("Feature folder", error.clone());
        } else {
            self.model.messages.resolved("Feature folder");
        }
        if let Some(dataset) = self.model.datasets.open.as_mut().filter(|_| same) {
            dataset.look_again(open);
            dataset.restore_pair(restoring.unwrap_or_default());
            return;
        }
        let mut dataset = Dataset::new(open);
        dataset.restore_pair(restoring.unwrap_or_default());
        let (count, done) = (dataset.bursts.len(), dataset.counts().done);
        self.model.messages.note(format!(
            "Opened {}: {}, {done} of them done",
            dataset.source.label(),
            counted(count, "burst")
        ));
        self.remember_dataset(&dataset.source);
        self.thumbnails.clear();
        let shown = dataset.place_of(self.model.burst.as_ref());
        self.model.datasets.open = Some(dataset);
        self.model.panels.filmstrip = true;
        // A session brings its own burst.
        if shown.is_none() && restoring.is_none() {
            self.open_burst_at(0);
        }
    }

    fn say_what_was_found(&mut self, seconds: f64) {
        let Some(dataset) = &self.model.datasets.open else { return };
        let counts = dataset.counts();
        let mut text = format!(
            "{} done in {seconds:.1} s: {}",
            counted(counts.done, "burst"),
            counted(counts.features, "feature")
        );
        if counts.failed > 0 {
            text += &format!("; {} failed, see the filmstrip", counts.failed);
        }
        self.model.messages.note(text);
    }

    fn say_what_matched(&mut self, left_out: usize, seconds: f64) {
        let Some(dataset) = &self.model.datasets.open else { return };
        let mut text = format!("{} matched in {seconds:.1} s", counted(dataset.matches.len(), "pair"));
        if left_out > 0 {
            text += &format!("; {left_out} left out, whose bursts have no features yet");
        }
        self.model.messages.note(text);
    }
}

/// Trajectories.
impl BurstscopeApp {
    /// Reads a trajectory in the background, and compares it with the other one if that is there.
    pub fn open_trajectory(&mut self, which: Which, path: PathBuf) {
        self.engine.poses.submit(self.model.trajectories.request_with(which, path));
        self.model.workspace = Workspace::Trajectories;
    }

    /// Compares the trajectories that are open as the study now says.
    pub(in crate::app) fn compare_again(&self) {
        self.engine.poses.submit(self.model.trajectories.request());
    }

    pub(in crate::app) fn take_compared(&mut self, answer: JobAnswer<ComparedPoses>) {
        const TITLE: &str = "Trajectories";
        if answer.is_superseded() {
            return;
        }
        match answer.result {
            Ok(compared) => {
                self.model.messages.resolved(TITLE);
                self.model.trajectories.take(compared);
            }
            Err(error) => {
                self.model.trajectories.fail();
                self.model.messages.error(TITLE, error.to_string());
            }
        }
    }

    /// Opens the trajectories of a session, or none.
    pub(in crate::app) fn restore_trajectories(&mut self, saved: Option<SavedTrajectories>) {
        self.model.trajectories.clear();
        if let Some(SavedTrajectories { estimate, truth, projection }) = saved {
            self.model.trajectories.projection = projection;
            let study = self.model.trajectories.study;
            let (estimate, truth) = (estimate.map(TrajectorySource::Path), truth.map(TrajectorySource::Path));
            self.engine.poses.submit(PosesRequest { estimate, truth, study });
        }
    }
}
