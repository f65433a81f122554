//! Work on a dataset: the requests, and what their answers change.

use crate::app::document::datasets::BurstPair;
use crate::app::document::datasets::DatasetChoice;
use crate::app::document::side::{Side, Sides};
use crate::app::results::Effect;
use crate::app::results::Model;
use crate::app::results::datasets::{Dataset, Datasets, Work};
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::engine::{Ended, Engine};
use crate::error::Error;
use crate::inspect::words::counted;
use crate::requests::{BurstSource, DatasetAnswer, DatasetEvent, DatasetRequest, JobError, OpenDataset};
#[cfg(feature = "colmap")]
use crate::requests::{ColmapDone, ColmapRequest};
use crate::teach::Workspace;
use std::path::PathBuf;

/// Number of frames from which a burst counts as a film: motion is not uniform for so long.
const FILM_FRAMES: usize = 30;

impl Datasets {
    fn begin(&mut self, work: Work, request: DatasetRequest, engine: &Engine) {
        self.work = Some(work);
        self.wanted.ask(engine, request);
    }
}

impl Model {
    /// Opens a dataset in the background; the open one stays until then. Without a folder the features are kept beside
    /// the bursts. A single long sequence is first offered for cutting.
    pub(in crate::app) fn look_at_dataset(
        &mut self,
        source: DatasetSource,
        folder: Option<PathBuf>,
        open: OpenOptions,
        engine: &Engine,
    ) {
        let params = self.asked();
        self.results.datasets.begin(Work::Opening, DatasetRequest::Open { source, folder, params, open }, engine);
    }

    pub(in crate::app) fn look_at_dataset_again(&mut self, engine: &Engine) {
        if let Some(dataset) = &self.results.datasets.open {
            let options = self.document.calibration.clone();
            self.look_at_dataset(dataset.source.clone(), dataset.folder.clone(), options, engine);
        }
    }

    pub(in crate::app) fn use_feature_folder(&mut self, folder: PathBuf, engine: &Engine) {
        if let Some(dataset) = &self.results.datasets.open {
            self.look_at_dataset(dataset.source.clone(), Some(folder), dataset.open.clone(), engine);
        }
    }

    pub(in crate::app) fn use_folder_params(&mut self, engine: &Engine) {
        if let Some(params) = self.results.datasets.open.as_ref().and_then(|dataset| dataset.other_params.clone()) {
            self.document.set_search(params);
            self.look_at_dataset_again(engine);
        }
    }

    pub(in crate::app) fn close_dataset(&mut self) -> Effect {
        (self.results.datasets, self.document.dataset) = Default::default();
        Effect::ForgetThumbnails
    }

    pub(in crate::app) fn cut_of_open_burst(&self) -> Option<Effect> {
        let open = self.results.slots.a.burst.as_ref()?;
        let BurstSource::Paths(paths) = &open.source else { return None };
        Some(Effect::Cut { paths: paths.clone(), frames: open.burst.len() })
    }

    /// Whether the open burst is a film that belongs to no dataset: cutting it is offered.
    pub(in crate::app) fn is_film(&self) -> bool {
        self.results.slots.a.burst.as_ref().is_some_and(|open| {
            let in_dataset = self.results.datasets.open.as_ref().is_some_and(|d| d.place_of(Some(open)).is_some());
            matches!(open.source, BurstSource::Paths(_)) && open.burst.len() >= FILM_FRAMES && !in_dataset
        })
    }

    pub(in crate::app) fn cut_open_burst(&mut self, length: usize, engine: &Engine) {
        if let Some(Effect::Cut { paths, .. }) = self.cut_of_open_burst() {
            let source = DatasetSource { paths, burst_length: Some(length), burst_step: None };
            self.look_at_dataset(source, None, self.document.calibration.clone(), engine);
        }
    }

    /// Finds the features of all bursts; where that replaces features of other parameters, the user is asked first.
    pub(in crate::app) fn ask_and_detect_all(&mut self, engine: &Engine) -> Option<Effect> {
        let params = self.asked();
        if self.results.datasets.open.as_ref().is_some_and(|dataset| dataset.would_replace(&params)) {
            return Some(Effect::ReplaceFeatures);
        }
        self.detect_all(engine);
        None
    }

    pub(in crate::app) fn detect_all(&mut self, engine: &Engine) {
        let params = self.asked();
        let Some(dataset) = &mut self.results.datasets.open else { return };
        dataset.begin_detection(&params);
        if let Some(keeping) = dataset.keeping() {
            let bursts = dataset.bursts.clone();
            self.messages.resolved(Work::Detecting.title());
            self.results.datasets.begin(Work::Detecting, DatasetRequest::Detect { bursts, keeping }, engine);
        }
    }

    pub(in crate::app) fn match_pairs(&mut self, engine: &Engine) {
        if let Some(dataset) = &self.results.datasets.open {
            self.start_matching_pairs(self.document.pairs.selection().pairs(dataset.bursts.len()), engine);
        }
    }

    pub(in crate::app) fn match_selected(&mut self, engine: &Engine) {
        if let Some(pair) = self.document.dataset.as_ref().and_then(DatasetChoice::selected) {
            self.start_matching_pairs(vec![pair], engine);
        }
    }

    fn start_matching_pairs(&mut self, pairs: Vec<BurstPair>, engine: &Engine) {
        let matching = self.document.matching.clone();
        let Some(dataset) = &mut self.results.datasets.open else { return };
        dataset.matches.begin(&matching);
        if let Some(keeping) = dataset.keeping() {
            let bursts = dataset.bursts.clone();
            self.messages.resolved(Work::Matching.title());
            self.results.datasets.begin(
                Work::Matching,
                DatasetRequest::Match { bursts, keeping, pairs, matching },
                engine,
            );
        }
    }

    #[cfg(feature = "colmap")]
    pub(in crate::app) fn export_database(&mut self, out: PathBuf, engine: &Engine) {
        let Some(dataset) = &self.results.datasets.open else { return };
        let request = ColmapRequest {
            out,
            kept: dataset.folder.clone(),
            params: self.asked(),
            open: dataset.open.clone(),
            matching: self.document.matching.clone(),
            pairs: self.document.pairs.selection(),
        };
        let bursts = dataset.bursts.clone();
        self.messages.resolved(Work::Exporting.title());
        self.results.datasets.begin(
            Work::Exporting,
            DatasetRequest::Colmap { bursts, request: Box::new(request) },
            engine,
        );
    }

    pub(in crate::app) fn show_selected_pair(&mut self, engine: &Engine) {
        let (Some(dataset), Some(set)) = (&self.results.datasets.open, &self.document.dataset) else { return };
        let Sides { a: Some(a), b: Some(b) } = set.pair else { return };
        let chosen = [(Side::A, a), (Side::B, b)].map(|(side, place)| {
            let is_open = dataset.place_of(self.burst_of(side)) == Some(place);
            (side, is_open, dataset.source_at(place))
        });
        for (side, is_open, source) in chosen {
            if let Some(source) = source.filter(|_| !is_open) {
                self.open(side, source, engine);
            }
        }
        self.document.workspace = Workspace::Pair;
    }

    pub(in crate::app) fn step_burst(&mut self, by: isize, engine: &Engine) {
        let Some(dataset) = &self.results.datasets.open else { return };
        let last = dataset.bursts.len() - 1;
        let next = match dataset.place_of(self.results.slots.a.burst.as_ref()) {
            Some(place) => place.saturating_add_signed(by).min(last),
            None => 0,
        };
        self.open_burst_at(next, engine);
    }

    pub(in crate::app) fn open_burst_at(&mut self, place: usize, engine: &Engine) {
        let dataset = self.results.datasets.open.as_ref();
        let here = dataset.and_then(|d| d.place_of(self.results.slots.a.burst.as_ref())) == Some(place);
        if let Some(source) = dataset.and_then(|d| d.source_at(place)).filter(|_| !here) {
            self.open(Side::A, source, engine);
        }
    }

    pub(in crate::app) fn look_at_camera(&mut self, label: &str, engine: &Engine) {
        let dataset = self.results.datasets.open.as_ref();
        match dataset.map(|d| (d.place_of_camera(label), d.source.label())) {
            Some((Some(place), _)) => {
                self.open_burst_at(place, engine);
                self.document.workspace = Workspace::Inspect;
            }
            Some((None, name)) => {
                self.messages.note(format!("{name} has no burst with the name of the camera {label}"));
            }
            None => self.messages.note(format!("Open the dataset of {label} to show its burst")),
        }
    }

    pub(in crate::app) fn choose_open_burst(&mut self, side: Side) {
        let place = self
            .results
            .datasets
            .open
            .as_ref()
            .and_then(|dataset| dataset.place_of(self.results.slots.a.burst.as_ref()));
        if let (Some(set), Some(place)) = (&mut self.document.dataset, place) {
            set.choose(side, place);
        }
    }

    pub(in crate::app) fn take_dataset_event(&mut self, event: &DatasetEvent) {
        self.results.datasets.open.iter_mut().for_each(|dataset| dataset.take_event(event));
        // Counts that were said before are old.
        self.messages.forget_note();
    }

    pub(in crate::app) fn take_dataset_answer(
        &mut self,
        answer: Ended<DatasetRequest>,
        engine: &Engine,
    ) -> Vec<Effect> {
        let work = self.results.datasets.work.take();
        if let Some(dataset) = &mut self.results.datasets.open {
            dataset.stop();
        }
        if work == Some(Work::Opening) && answer.result.is_err() {
            // A session may have named another one.
            let open = self.results.datasets.open.as_ref();
            let choice =
                |d: &Dataset| self.document.dataset.take_if(|set| set.source == d.source).unwrap_or(d.choice());
            self.document.dataset = open.map(choice);
        }
        let title = work.map_or("Dataset", Work::title);
        let mut effects = Vec::new();
        match answer.result {
            Ok(DatasetAnswer::Opened(open)) => {
                self.messages.resolved(title);
                effects = self.take_dataset(*open, engine);
            }
            Ok(DatasetAnswer::Detected) => self.say_what_was_found(answer.elapsed.as_secs_f64()),
            Ok(DatasetAnswer::Matched { left_out }) => self.say_what_matched(left_out, answer.elapsed.as_secs_f64()),
            #[cfg(feature = "colmap")]
            Ok(DatasetAnswer::Colmap(done)) => self.say_what_was_exported(&done),
            Err(JobError::Cancelled) => {
                self.messages.note(format!("{title}: cancelled; what is done stays done"));
            }
            Err(error) => self.messages.error(title, error.to_string()),
        }
        // The states told of the folder that was written; those of the dataset's own are looked at again.
        if work == Some(Work::Exporting) {
            self.look_at_dataset_again(engine);
        }
        effects
    }

    fn take_dataset(&mut self, open: OpenDataset, engine: &Engine) -> Vec<Effect> {
        let same = self.results.datasets.open.as_ref().is_some_and(|d| d.bursts == open.bursts);
        match open.frames_of_one {
            // A lone burst of many files is a sequence that is yet to be cut.
            Some(frames) if frames > 1 && open.source.burst_length.is_none() => {
                return vec![Effect::Cut { paths: open.source.paths, frames }];
            }
            Some(1) if open.source.burst_length.is_none() => {
                self.open(Side::A, BurstSource::Paths(open.source.paths), engine);
                return Vec::new();
            }
            _ => {}
        }
        let set = self.document.dataset.take().filter(|set| set.source == open.source);
        let is_set = set.is_some();
        let (source, folder) = (open.source.clone(), open.folder.clone());
        let choice = DatasetChoice { source, folder, pair: set.map(|set| set.pair).unwrap_or_default() };
        self.document.dataset = Some(choice.within(open.bursts.len()));
        if let Some(error) = &open.folder_error {
            self.messages.error("Feature folder", error.clone());
        } else {
            self.messages.resolved("Feature folder");
        }
        if let Some(dataset) = self.results.datasets.open.as_mut().filter(|_| same) {
            dataset.look_again(open);
            return Vec::new();
        }
        if let [first, rest @ ..] = &open.strays[..] {
            let more = if rest.is_empty() { String::new() } else { format!(" (and {} more)", rest.len()) };
            let stray = Error::stray(first);
            self.messages.error("Open dataset", format!("{stray}{more}"));
        }
        let dataset = Dataset::new(open);
        let (count, done) = (dataset.bursts.len(), dataset.counts().done);
        self.messages.note(format!(
            "Opened {}: {}, {done} of them done",
            dataset.source.label(),
            counted(count, "burst")
        ));
        let recent = Effect::RecentDataset(dataset.source.clone());
        let shown = dataset.place_of(self.results.slots.a.burst.as_ref());
        (self.results.datasets.open, self.results.datasets.exported) = (Some(dataset), None);
        self.document.panels.filmstrip = true;
        // A session opens its own burst.
        if shown.is_none() && !is_set {
            self.open_burst_at(0, engine);
        }
        vec![recent, Effect::ForgetThumbnails]
    }

    fn say_what_was_found(&mut self, seconds: f64) {
        let Some(dataset) = &self.results.datasets.open else { return };
        let counts = dataset.counts();
        let mut text = format!(
            "{} done in {seconds:.1} s: {}",
            counted(counts.done, "burst"),
            counted(counts.features, "feature")
        );
        if counts.failed > 0 {
            text += &format!("; {} failed, see the filmstrip", counts.failed);
        }
        self.messages.note(text);
    }

    fn say_what_matched(&mut self, left_out: usize, seconds: f64) {
        let Some(dataset) = &self.results.datasets.open else { return };
        let mut text = format!("{} matched in {seconds:.1} s", counted(dataset.matches.len(), "pair"));
        if left_out > 0 {
            text += &format!("; {left_out} left out, whose bursts have no features yet");
        }
        self.messages.note(text);
    }

    #[cfg(feature = "colmap")]
    fn say_what_was_exported(&mut self, done: &ColmapDone) {
        let report = &done.report;
        let verified = report.pairs.iter().filter(|pair| pair.counts.inliers.is_some_and(|n| n > 0)).count();
        self.messages.resolved(Work::Exporting.title());
        self.results.datasets.exported = report.database.parent().map(Into::into);
        self.messages.note(format!(
            "Wrote {}: {}, {}, {verified} of them verified; Matches has the next step",
            report.database.display(),
            counted(report.images.len(), "image"),
            counted(report.pairs.len(), "pair"),
        ));
        if let Some((name, why)) = done.left_out.first() {
            let others = match done.left_out.len() - 1 {
                0 => String::new(),
                more => format!(" (and {} more)", counted(more, "burst")),
            };
            self.messages.error(Work::Exporting.title(), format!("{name} was left out{others}: {why}"));
        }
    }
}
