//! State of datasets, as plain values: the bursts with their states, the matches of their pairs, the work in progress.

mod dataset;
pub mod pairs;
mod work;

pub use dataset::{BurstState, Dataset, StateCounts};

use crate::engine::Wanted;
use crate::requests::DatasetRequest;
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
