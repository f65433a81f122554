//! State of datasets, as plain values: the bursts with their states, the matches of their pairs, the work in progress.

mod dataset;
pub mod pairs;
mod work;

pub use dataset::{BurstState, Dataset, StateCounts};

use crate::app::project::side::{Side, Sides};
use crate::dataset::DatasetSource;
use crate::engine::Wanted;
use crate::matching::PairSelection;
use crate::requests::DatasetRequest;
use pairs::{BurstPair, pair_of};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

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

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct PairChoice {
    /// Whether each burst is matched with the next few only.
    pub neighbours: bool,
    /// Number of these next bursts, 1 or more.
    pub overlap: usize,
}

impl Default for PairChoice {
    fn default() -> Self {
        Self { neighbours: false, overlap: 3 }
    }
}

impl PairChoice {
    pub fn selection(self) -> PairSelection {
        if self.neighbours { PairSelection::Sequential(self.overlap) } else { PairSelection::All }
    }
}

/// The dataset as it is set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetChoice {
    pub source: DatasetSource,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub folder: Option<PathBuf>,
    /// Places of the bursts chosen as A and as B.
    #[serde(default)]
    pub pair: Sides<Option<usize>>,
}

impl DatasetChoice {
    pub fn selected(&self) -> Option<BurstPair> {
        pair_of(self.pair.a?, self.pair.b?)
    }

    /// Makes the earlier burst of a pair A and the later one B.
    pub fn select(&mut self, (a, b): BurstPair) {
        self.pair = Sides { a: Some(a), b: Some(b) };
    }

    /// Clears the choice if it is chosen already. A burst cannot be both.
    pub fn choose(&mut self, side: Side, place: usize) {
        let Self { pair, .. } = self;
        pair[side] = (pair[side] != Some(place)).then_some(place);
        pair[side.other()].take_if(|other| *other == place);
    }

    /// Without places that `count` bursts do not have.
    pub fn within(mut self, count: usize) -> Self {
        for side in Side::BOTH {
            self.pair[side] = self.pair[side].filter(|place| *place < count);
        }
        self
    }
}

#[derive(Debug, Default)]
pub struct Datasets {
    pub open: Option<Dataset>,
    pub work: Option<Work>,
    pub wanted: Wanted<DatasetRequest>,
    /// Folder of the last export, until another dataset is opened.
    pub exported: Option<PathBuf>,
}

impl Datasets {
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
        let whole = self.wanted.running().and_then(|r| r.progress).map_or(0.0, |p| p.fraction);
        // At the end of the last burst the share is almost 1, not 0.
        (bursts * whole).min(bursts - 1e-3).fract()
    }
}
