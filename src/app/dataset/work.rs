//! What the window asks the engine to do with a dataset, and what it does with the answers.

use super::cut::CutDialog;
use super::model::{Dataset, Work};
use crate::app::session::SavedDataset;
use crate::app::window::BurstscopeApp;
use crate::dataset::DatasetSource;
use crate::engine::{Answer, BurstSource, DatasetAnswer, DatasetRequest, DatasetUpdate, JobError, OpenDataset};
use std::path::PathBuf;

impl BurstscopeApp {
    /// Opens a dataset in the background; what is open stays until it is there.
    pub fn open_dataset(&mut self, source: DatasetSource) {
        self.look_at_dataset(source, None);
    }

    /// Opens the bursts at `paths` as a dataset; a long sequence that lies there alone is first asked about.
    pub(in crate::app) fn look_at_dataset(&mut self, source: DatasetSource, folder: Option<PathBuf>) {
        self.model.datasets.work = Some(Work::Opening);
        self.engine.datasets.submit(DatasetRequest::Open { source, folder, params: self.model.params.clone() });
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
        if let Some(params) = dataset.other_params.clone() {
            self.model.params = params;
            self.look_at_dataset(dataset.source.clone(), dataset.folder.clone());
        }
    }

    /// Asks how the burst that is open is cut into shorter ones.
    pub(in crate::app) fn ask_for_cut(&mut self) {
        if let Some(open) = &self.model.burst
            && let BurstSource::Paths(paths) = &open.source
        {
            self.cut = Some(CutDialog::new(paths.clone(), open.burst.len(), self.burst_length()));
        }
    }

    pub(in crate::app) fn close_dataset(&mut self) {
        self.engine.datasets.cancel();
        self.model.datasets = Default::default();
        self.thumbnails.clear();
    }

    pub(in crate::app) fn detect_all(&mut self) {
        let params = self.model.params.clone();
        let Some(dataset) = &mut self.model.datasets.open else { return };
        dataset.begin_detection(&params);
        if let Some(keeping) = dataset.keeping() {
            let bursts = dataset.bursts.clone();
            self.model.datasets.work = Some(Work::Detecting);
            self.model.messages.resolved(Work::Detecting.title());
            self.engine.datasets.submit(DatasetRequest::Detect { bursts, keeping });
        }
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

    fn take_dataset_answer(&mut self, answer: Answer<DatasetAnswer>) {
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
            Ok(DatasetAnswer::Matched { .. }) => {}
            Err(JobError::Cancelled) => {
                self.model.messages.note(format!("{title}: cancelled; what is done stays done"))
            }
            Err(error) => self.model.messages.error(title, error.to_string()),
        }
    }

    fn take_dataset(&mut self, open: OpenDataset) {
        let same = self.model.datasets.open.as_ref().is_some_and(|d| d.bursts == open.bursts);
        match open.frames_of_one {
            // A lone burst of many files is a sequence that is yet to be cut.
            Some(frames) if frames > 1 && open.source.burst_length.is_none() => {
                self.cut = Some(CutDialog::new(open.source.paths, frames, self.burst_length()));
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
        self.model.messages.note(format!("Opened {}: {count} bursts, {done} of them done", dataset.source.label()));
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
        let mut text = format!("{} bursts done in {seconds:.1} s: {} features", counts.done, counts.features);
        if counts.failed > 0 {
            text += &format!("; {} failed, see the filmstrip", counts.failed);
        }
        self.model.messages.note(text);
    }
}
