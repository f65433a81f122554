//! What is known of datasets, as plain values: the bursts with their states, the matches of their pairs, what is being
//! done.

mod dataset;
pub mod pairs;
mod state;

pub use dataset::Dataset;
pub use state::{BurstState, StateCounts};

use crate::engine::Wanted;
use crate::matching::PairSelection;
use crate::requests::DatasetRequest;

/// What is being done with the dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// It is being opened, or looked at again.
    Opening,
    /// Features are being found.
    Detecting,
    /// Pairs are being matched.
    Matching,
    /// What COLMAP's mapper takes is being written.
    Exporting,
}

impl Work {
    /// What it is called in messages.
    pub fn title(self) -> &'static str {
        match self {
            Self::Opening => "Open dataset",
            Self::Detecting => "Detect all",
            Self::Matching => "Match pairs",
            Self::Exporting => "Export COLMAP database",
        }
    }
}

/// Which pairs are matched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PairChoice {
    /// Only each burst with the next few.
    pub neighbours: bool,
    /// How many those are, 1 or more.
    pub overlap: usize,
}

impl Default for PairChoice {
    fn default() -> Self {
        Self { neighbours: false, overlap: 3 }
    }
}

impl PairChoice {
    /// The choice as the dataset's workspace knows it.
    pub fn selection(self) -> PairSelection {
        if self.neighbours { PairSelection::Sequential(self.overlap) } else { PairSelection::All }
    }
}

/// Everything about datasets.
#[derive(Debug, Default)]
pub struct Datasets {
    /// The dataset that is open.
    pub open: Option<Dataset>,
    /// What is being done, as it was asked for.
    pub work: Option<Work>,
    /// The request for it.
    pub wanted: Wanted<DatasetRequest>,
    /// Which pairs are matched.
    pub choice: PairChoice,
    /// A and B of the session that the dataset being opened belongs to, if it belongs to one.
    pub restoring: Option<[Option<usize>; 2]>,
}

impl Datasets {
    /// Whether features of `params` can be looked for now.
    pub fn can_detect(&self, params_are_valid: bool) -> bool {
        let ready = |d: &Dataset| d.folder.is_some() && d.folder_error.is_none();
        self.work.is_none() && params_are_valid && self.open.as_ref().is_some_and(ready)
    }

    /// Whether pairs can be matched now.
    pub fn can_match(&self, params_are_valid: bool) -> bool {
        self.can_detect(params_are_valid) && self.open.as_ref().is_some_and(|d| d.counts().done > 1)
    }

    /// The share of the burst being worked on that is done, from the share of the whole.
    pub fn burst_fraction(&self) -> f32 {
        let bursts = self.open.as_ref().map_or(1, |d| d.bursts.len()) as f32;
        let whole = self.wanted.running().and_then(|r| r.progress).map_or(0.0, |p| p.fraction);
        // The last burst's end is 1, not 0.
        (bursts * whole).min(bursts - 1e-3).fract()
    }
}
