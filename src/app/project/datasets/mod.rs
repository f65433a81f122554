//! State of datasets, as plain values: the bursts with their states, the matches of their pairs, the work in progress.

mod dataset;
pub mod pairs;
mod work;

pub use dataset::{BurstState, Dataset, StateCounts};

use crate::engine::Wanted;
use crate::matching::PairSelection;
use crate::requests::DatasetRequest;
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

#[derive(Debug, Default)]
pub struct Datasets {
    pub open: Option<Dataset>,
    pub work: Option<Work>,
    pub wanted: Wanted<DatasetRequest>,
    pub choice: PairChoice,
    /// Places of A and B in the session to which the dataset being opened belongs, if it belongs to one.
    pub restoring: Option<[Option<usize>; 2]>,
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
