//! Requests for work on a dataset, from the window to the engine.

use crate::app::dataset::cut::CutDialog;
use crate::app::project::datasets::pairs::BurstPair;
use crate::app::project::datasets::{Dataset, Work};
use crate::app::project::workspace::Workspace;
use crate::app::session::SavedDataset;
use crate::app::window::BurstscopeApp;
use crate::dataset::DatasetSource;
use crate::requests::{BurstSource, DatasetRequest};
use std::path::PathBuf;

/// Number of frames from which a burst counts as a film: motion is not uniform for so long.
const FILM_FRAMES: usize = 30;

impl BurstscopeApp {
    /// Opens a dataset in the background; the open one stays until then.
    pub fn open_dataset(&mut self, source: DatasetSource) {
        self.look_at_dataset(source, None);
    }

    /// Opens the bursts of `source` as a dataset; a single long sequence is first offered for cutting.
    pub(in crate::app) fn look_at_dataset(&mut self, source: DatasetSource, folder: Option<PathBuf>) {
        self.model.datasets.work = Some(Work::Opening);
        let (params, open) = (self.model.asked(), self.model.calibration.clone());
        self.model.datasets.wanted.ask(&self.engine, DatasetRequest::Open { source, folder, params, open });
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

    /// Sets the folder in which the dataset's features are kept.
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
        if let Some(open) = &self.model.slots.a.burst
            && let BurstSource::Paths(paths) = &open.source
        {
            self.overlays.cut = Some(CutDialog::new(paths.clone(), open.burst.len(), self.burst_length()));
        }
    }

    /// Frames of each burst when the film that is open is cut with one click; `None` where there is nothing to cut.
    pub(in crate::app) fn offered_cut(&self) -> Option<usize> {
        let open = self.model.slots.a.burst.as_ref()?;
        let in_dataset = self.model.datasets.open.as_ref().is_some_and(|d| d.place_of(Some(open)).is_some());
        let is_film = matches!(open.source, BurstSource::Paths(_)) && open.burst.len() >= FILM_FRAMES;
        let asked = self.overlays.stays_whole == Some(open.id) || self.overlays.cut.is_some();
        (is_film && !in_dataset && !asked).then(|| self.burst_length())
    }

    /// Cuts the film that is open into bursts of `length` frames, one after another, and opens them as a dataset.
    pub(in crate::app) fn cut_open_burst(&mut self, length: usize) {
        if let Some(open) = &self.model.slots.a.burst
            && let BurstSource::Paths(paths) = &open.source
        {
            self.open_dataset(DatasetSource { paths: paths.clone(), burst_length: Some(length), burst_step: None });
        }
    }

    /// Keeps the open film as one burst: cutting it is not offered any more.
    pub(in crate::app) fn keep_burst_whole(&mut self) {
        self.overlays.stays_whole = self.model.slots.a.burst.as_ref().map(|open| open.id);
    }

    pub(in crate::app) fn close_dataset(&mut self) {
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
            self.model.datasets.wanted.ask(&self.engine, DatasetRequest::Detect { bursts, keeping });
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
            self.model.datasets.wanted.ask(&self.engine, DatasetRequest::Match { bursts, keeping, pairs, matching });
        }
    }

    /// Opens A and B side by side.
    pub(in crate::app) fn show_selected_pair(&mut self) {
        let Some(dataset) = &self.model.datasets.open else { return };
        let [Some(a), Some(b)] = dataset.pair else { return };
        let (Some(source_a), Some(source_b)) = (dataset.source_at(a), dataset.source_at(b)) else { return };
        let a_is_open = dataset.place_of(self.model.slots.a.burst.as_ref()) == Some(a);
        let b_is_open = dataset.place_of(self.model.slots.b.burst.as_ref()) == Some(b);
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
        let next = match dataset.place_of(self.model.slots.a.burst.as_ref()) {
            Some(place) => place.saturating_add_signed(by).min(last),
            None => 0,
        };
        self.open_burst_at(next);
    }

    pub(in crate::app) fn open_burst_at(&mut self, place: usize) {
        let dataset = self.model.datasets.open.as_ref();
        let here = dataset.and_then(|d| d.place_of(self.model.slots.a.burst.as_ref())) == Some(place);
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
                self.model.messages.note(format!("{name} has no burst with the name of the camera {label}"));
            }
            None => self.model.messages.note(format!("Open the dataset of {label} to show its burst")),
        }
    }

    /// Chooses the burst that is open in the inspector as A (0) or B (1).
    pub(in crate::app) fn choose_open_burst(&mut self, side: usize) {
        let shown = self.model.slots.a.burst.as_ref();
        if let Some(dataset) = &mut self.model.datasets.open
            && let Some(place) = dataset.place_of(shown)
        {
            dataset.choose(side, place);
        }
    }
}
