//! State of datasets, as plain values: the bursts with their states, the matches of their pairs, the work in progress.

use crate::app::document::Side;
use crate::app::results::{Effect, Read};
use crate::engine::{Engine, Wanted};
use crate::requests::{BurstSource, DatasetRequest};
use std::path::PathBuf;

mod dataset;
pub mod pairs;

pub use dataset::{BurstState, Dataset, StateCounts};

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
        let whole = self.wanted.running().and_then(|r| r.progress).map_or(0.0, |p| p.fraction);
        // At the end of the last burst the share is almost 1, not 0.
        (bursts * whole).min(bursts - 1e-3).fract()
    }
}

/// Number of frames from which a burst counts as a film: motion is not uniform for so long.
const FILM_FRAMES: usize = 30;

impl Read<'_> {
    pub(in crate::app) fn cut_of_open_burst(self) -> Option<Effect> {
        let open = self.burst_of(Side::A)?;
        let BurstSource::Paths(paths) = &open.source else { return None };
        Some(Effect::Cut { paths: paths.clone(), frames: open.burst.len() })
    }

    /// Whether the open burst is a film that belongs to no dataset: cutting it is offered.
    pub(in crate::app) fn is_film(self) -> bool {
        self.burst_of(Side::A).is_some_and(|open| {
            let in_dataset = self.results.datasets.open.as_ref().is_some_and(|d| d.place_of(Some(open)).is_some());
            matches!(open.source, BurstSource::Paths(_)) && open.burst.len() >= FILM_FRAMES && !in_dataset
        })
    }
}
