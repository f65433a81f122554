//! A dataset with the states of its bursts and the matches of its pairs.

use crate::app::document::{DatasetChoice, Sides};
use crate::app::results::datasets::pairs::PairTable;
use crate::burst::BurstFiles;
use crate::dataset::{FinishedBurst, image_name};
use crate::detector::SearchParams;
use crate::inspect::words::counted;
use crate::matching::ImageCounts;
use crate::requests::{BurstSource, DatasetEvent, Keeping, OpenBurst, OpenDataset};
use std::ops::Deref;
use std::sync::Arc;

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

    pub fn place_of(&self, open: Option<&OpenBurst>) -> Option<usize> {
        let BurstSource::Paths(paths) = &open?.source else { return None };
        self.bursts.iter().position(|b| b.paths == *paths)
    }

    pub fn has(&self, source: &BurstSource) -> bool {
        matches!(source, BurstSource::Paths(paths) if self.bursts.iter().any(|burst| burst.paths == *paths))
    }

    /// By its picture's name, with or without folders before it, or its own name.
    pub fn place_of_camera(&self, label: &str) -> Option<usize> {
        let file = label.rsplit(['/', '\\']).next().unwrap_or(label);
        let named = |b: &BurstFiles| image_name(b) == file || b.name == label;
        self.bursts.iter().position(named)
    }

    pub fn source_at(&self, place: usize) -> Option<BurstSource> {
        self.bursts.get(place).map(|burst| BurstSource::Paths(burst.paths.clone()))
    }

    /// Gives an open burst of the dataset its name in the dataset: the bursts of a cut sequence all lie in one folder.
    pub fn name_as_here(&self, open: &mut OpenBurst) {
        if let Some(BurstFiles { name, .. }) = self.place_of(Some(open)).and_then(|place| self.bursts.get(place))
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
        for state in &mut self.states {
            if others || !matches!(state, BurstState::Done(_)) {
                *state = BurstState::Waiting;
            }
        }
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
        for state in &mut self.states {
            if *state == BurstState::Running {
                *state = BurstState::Waiting;
            }
        }
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
