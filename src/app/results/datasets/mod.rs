//! State of datasets, as plain values: the bursts with their states, the matches of their pairs, the work in progress.

pub mod pairs;

use crate::app::document::{DatasetChoice, Side, Sides};
use crate::app::results::{Effect, Read};
use crate::burst::BurstFiles;
use crate::dataset::{FinishedBurst, image_name};
use crate::detector::SearchParams;
use crate::engine::{Engine, Wanted};
use crate::inspect::words::counted;
use crate::matching::ImageCounts;
use crate::requests::{BurstSource, DatasetEvent, DatasetRequest, Keeping, OpenBurst, OpenDataset};
use pairs::PairTable;
use std::ops::Deref;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    Opening,
    Detecting,
    Matching,
    Exporting,
}

impl Work {
    pub fn title(self) -> &'static str {
        match self {
            Self::Opening => "Open dataset",
            Self::Detecting => "Detect all",
            Self::Matching => "Match pairs",
            Self::Exporting => "Export COLMAP database",
        }
    }
}

#[derive(Debug, Default)]
pub struct Datasets {
    pub open: Option<Dataset>,
    pub work: Option<Work>,
    pub wanted: Wanted<DatasetRequest>,
    /// Folder of the last export, and whether all its cameras are known; until another dataset is opened.
    pub exported: Option<(PathBuf, bool)>,
}

impl Datasets {
    pub fn begin(&mut self, work: Work, request: DatasetRequest, engine: &Engine) {
        self.work = Some(work);
        self.wanted.ask(engine, request);
    }

    pub fn can_detect(&self, params_are_valid: bool) -> bool {
        let ready = |d: &Dataset| d.folder.is_some() && d.folder_error.is_none();
        self.work.is_none() && params_are_valid && self.open.as_ref().is_some_and(ready)
    }

    pub fn can_match(&self, params_are_valid: bool) -> bool {
        self.can_detect(params_are_valid) && self.open.as_ref().is_some_and(|d| d.counts().done > 1)
    }

    /// Finished share of the burst in work, 0 to 1, computed from the progress over all bursts.
    pub fn burst_fraction(&self) -> f32 {
        let bursts = self.open.as_ref().map_or(1, |d| d.bursts.len()) as f32;
        let whole = self.wanted.running.and_then(|r| r.progress).map_or(0.0, |p| p.fraction);
        // At the end of the last burst the share is almost 1, not 0.
        (bursts * whole).min(bursts - 1e-3).fract()
    }
}

/// Number of frames from which a burst counts as a film: motion is not uniform for so long.
const FILM_FRAMES: usize = 30;

impl Read<'_> {
    pub fn place_of(self, side: Side) -> Option<usize> {
        self.results.datasets.open.as_ref()?.place_of(&self.burst_of(side)?.source)
    }

    pub(in crate::app) fn cut_of_open_burst(self) -> Option<Effect> {
        let open = self.burst_of(Side::A)?;
        let BurstSource::Paths(paths) = &open.source else { return None };
        Some(Effect::Cut(paths.clone(), open.burst.len()))
    }

    /// Whether the open burst is a film that belongs to no dataset: cutting it is offered.
    pub(in crate::app) fn is_film(self) -> bool {
        self.burst_of(Side::A).is_some_and(|open| {
            let is_long = matches!(open.source, BurstSource::Paths(_)) && open.burst.len() >= FILM_FRAMES;
            is_long && self.place_of(Side::A).is_none()
        })
    }
}

/// A dataset that is open. All that the engine has said of it is read as if it were its own.
#[derive(Debug, Clone)]
pub struct Dataset {
    pub opened: OpenDataset,
    pub states: Vec<BurstState>,
    pub matches: PairTable,
}

impl Deref for Dataset {
    type Target = OpenDataset;

    fn deref(&self) -> &OpenDataset {
        &self.opened
    }
}

impl Dataset {
    pub fn new(opened: OpenDataset) -> Self {
        let states = opened.finished.iter().map(|f| f.map_or(BurstState::Waiting, BurstState::Done)).collect();
        Self { opened, states, matches: PairTable::default() }
    }

    /// The matches stay if folder, parameters and options are unchanged.
    pub fn look_again(&mut self, open: OpenDataset) {
        let matches = std::mem::take(&mut self.matches);
        let same_features = self.folder == open.folder && self.params == open.params && self.open == open.open;
        *self = Self::new(open);
        if same_features {
            self.matches = matches;
        }
    }

    pub fn choice(&self) -> DatasetChoice {
        DatasetChoice { source: self.source.clone(), folder: self.folder.clone(), pair: Sides::default() }
    }

    pub fn place_of(&self, source: &BurstSource) -> Option<usize> {
        let BurstSource::Paths(paths) = source else { return None };
        self.bursts.iter().position(|burst| burst.paths == *paths)
    }

    /// By its picture's name, with or without folders before it, or its own name.
    pub fn place_of_camera(&self, label: &str) -> Option<usize> {
        let file = label.rsplit(['/', '\\']).next().unwrap_or(label);
        self.bursts.iter().position(|burst| image_name(burst) == file || burst.name == label)
    }

    pub fn source_at(&self, place: usize) -> Option<BurstSource> {
        self.bursts.get(place).map(|burst| BurstSource::Paths(burst.paths.clone()))
    }

    /// Gives an open burst of the dataset its name in the dataset: the bursts of a cut sequence all lie in one folder.
    pub fn name_as_here(&self, open: &mut OpenBurst) {
        if let Some(BurstFiles { name, .. }) = self.place_of(&open.source).and_then(|place| self.bursts.get(place))
            && open.burst.name != *name
        {
            Arc::make_mut(&mut open.burst).name.clone_from(name);
        }
    }

    pub fn keeping(&self) -> Option<Keeping> {
        let folder = self.folder.clone().filter(|_| self.folder_error.is_none())?;
        Some(Keeping { folder, params: self.params.clone(), open: self.open.clone() })
    }

    pub fn counts(&self) -> StateCounts {
        let mut counts = StateCounts::default();
        for state in &self.states {
            match state {
                BurstState::Done(finished) => {
                    counts.done += 1;
                    counts.features += finished.features;
                }
                BurstState::Failed(_) => counts.failed += 1,
                BurstState::Waiting | BurstState::Running => {}
            }
        }
        counts
    }

    /// The numbers of all images in the paper's columns; `None` before pairs were matched.
    pub fn image_counts(&self) -> Option<ImageCounts> {
        let keypoints = |state: &BurstState| if let BurstState::Done(f) = state { f.features } else { 0 };
        let keypoints: Vec<usize> = self.states.iter().map(keypoints).collect();
        let pairs = self.matches.listed();
        ImageCounts::of(&keypoints, &pairs).filter(|_| !pairs.is_empty())
    }

    pub fn would_replace(&self, params: &SearchParams) -> bool {
        let others_here = self.params != *params && self.counts().done > 0;
        let others_in_folder = self.other_params.as_ref().is_some_and(|others| others != params);
        self.keeping().is_some() && (others_here || others_in_folder)
    }

    /// With other parameters all bursts wait and all matches are forgotten; otherwise finished bursts stay so.
    pub fn begin_detection(&mut self, params: &SearchParams) {
        let others = self.params != *params;
        if others {
            self.matches.counts.clear();
        }
        self.opened.params = params.clone();
        let searched = self.states.iter_mut().filter(|state| others || !matches!(state, BurstState::Done(_)));
        searched.for_each(|state| *state = BurstState::Waiting);
    }

    pub fn take_event(&mut self, event: &DatasetEvent) {
        let (index, state) = match event {
            // A finished burst is only checked.
            DatasetEvent::Begun { index } if matches!(self.states.get(*index), Some(BurstState::Done(_))) => return,
            DatasetEvent::Begun { index } => (*index, BurstState::Running),
            DatasetEvent::Done { index, finished } => {
                // These features replace those of other parameters.
                self.opened.other_params = None;
                if !matches!(self.states.get(*index), Some(BurstState::Done(_))) {
                    self.matches.counts.retain(|(a, b), _| a != index && b != index);
                }
                (*index, BurstState::Done(*finished))
            }
            DatasetEvent::Failed { index, error } => (*index, BurstState::Failed(error.clone())),
            DatasetEvent::Matched { pair, counts } => {
                self.matches.counts.insert(*pair, *counts);
                return;
            }
        };
        if let Some(place) = self.states.get_mut(index) {
            *place = state;
        }
    }

    pub fn stop(&mut self) {
        let running = self.states.iter_mut().filter(|state| **state == BurstState::Running);
        running.for_each(|state| *state = BurstState::Waiting);
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum BurstState {
    /// Its features were not found yet, or with other parameters.
    Waiting,
    Running,
    Done(FinishedBurst),
    Failed(String),
}

impl BurstState {
    pub fn text(&self) -> String {
        match self {
            Self::Waiting => "waiting".to_owned(),
            Self::Running => "running".to_owned(),
            Self::Failed(_) => "failed".to_owned(),
            Self::Done(FinishedBurst { features: 0, .. }) => "no features".to_owned(),
            Self::Done(FinishedBurst { features, seconds }) => format!("{features} · {seconds:.1} s"),
        }
    }

    pub fn sentence(&self) -> String {
        match self {
            Self::Waiting => "waiting: no features with these parameters yet".to_owned(),
            Self::Running => "running: its features are being found".to_owned(),
            Self::Failed(error) => format!("failed: {error}"),
            Self::Done(FinishedBurst { features, seconds }) => {
                let count = if *features == 0 { "no features".to_owned() } else { counted(*features, "feature") };
                format!("done: {count}, found in {seconds:.2} s")
            }
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StateCounts {
    pub done: usize,
    pub failed: usize,
    pub features: usize,
}
