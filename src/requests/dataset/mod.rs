//! Work on a whole dataset: looking at it, finding the features of all its bursts, matching pairs of them, writing what
//! COLMAP takes.
//!
//! Such work is long, and a person wants to see each burst and each pair as it is finished. So beside the one
//! answer at the end there are events on the way.

#[cfg(feature = "colmap")]
mod colmap;
mod thumbnails;
mod work;

pub use thumbnails::ThumbnailsRequest;

#[cfg(feature = "colmap")]
pub use colmap::{ColmapDone, ColmapRequest};

use crate::burst::{BurstSource, OpenOptions};
use crate::dataset::{DatasetError, DatasetSource, FeatureJob, FeatureStore, FinishedBurst, ImageKind};
use crate::detector::SearchParams;
use crate::matching::{MatchCounts, MatchParams};
use std::path::PathBuf;
use std::sync::Arc;

/// The bursts of a dataset, shared by all who work on them.
pub type Bursts = Arc<Vec<BurstSource>>;

/// Where features are kept, and how they are found: an immutable snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct Keeping {
    /// The folder.
    pub folder: PathBuf,
    /// The detector's parameters, and how the slopes are chosen.
    pub params: SearchParams,
    /// How bursts are opened.
    pub open: OpenOptions,
}

impl Keeping {
    fn store(&self) -> Result<FeatureStore, DatasetError> {
        let job = FeatureJob { detector: self.params.clone(), open: self.open.clone(), images: ImageKind::default() };
        FeatureStore::open(&self.folder, &job)
    }
}

/// Request for work on a dataset.
#[derive(Debug, Clone, PartialEq)]
pub enum DatasetRequest {
    /// Find out which bursts there are, and which of them are finished. Without a folder the dataset's own is taken.
    Open {
        /// Where they come from.
        source: DatasetSource,
        /// Where features are kept.
        folder: Option<PathBuf>,
        /// With which parameters.
        params: SearchParams,
        /// How bursts are opened.
        open: OpenOptions,
    },
    /// Find the features of all bursts that are not finished.
    Detect {
        /// The bursts.
        bursts: Bursts,
        /// Where and how.
        keeping: Keeping,
    },
    /// Match pairs of finished bursts; pairs with one that is not are left out.
    Match {
        /// The bursts.
        bursts: Bursts,
        /// Where their features are.
        keeping: Keeping,
        /// Pairs of places in `bursts`.
        pairs: Vec<(usize, usize)>,
        /// How they are matched.
        matching: MatchParams,
    },
    /// Write the files that COLMAP's mapper reads.
    #[cfg(feature = "colmap")]
    Colmap {
        /// The bursts.
        bursts: Bursts,
        /// The export's folder and parameters.
        request: Box<ColmapRequest>,
    },
}

/// A dataset that was looked at.
#[derive(Debug, Clone)]
pub struct OpenDataset {
    /// Where it comes from.
    pub source: DatasetSource,
    /// Its bursts; at least one.
    pub bursts: Bursts,
    /// Pictures that lie beside the bursts and belong to none.
    pub strays: Vec<PathBuf>,
    /// Files of its only burst; `None` if there are several bursts.
    pub frames_of_one: Option<usize>,
    /// Where features are kept; `None` if no folder was given and the dataset has none of its own.
    pub folder: Option<PathBuf>,
    /// Why features cannot be kept there.
    pub folder_error: Option<String>,
    /// The parameters with which it was looked at.
    pub params: SearchParams,
    /// How its bursts are opened.
    pub open: OpenOptions,
    /// For each burst what is finished with these parameters.
    pub finished: Vec<Option<FinishedBurst>>,
    /// Other parameters, with which the features in the folder were found.
    pub other_params: Option<SearchParams>,
}

/// Answer to a `DatasetRequest`.
#[derive(Debug, Clone)]
pub enum DatasetAnswer {
    /// The dataset is open.
    Opened(Box<OpenDataset>),
    /// All bursts are finished or failed.
    Detected,
    /// All pairs are matched. Says how many were left out because a burst is not finished.
    Matched {
        /// Pairs left out.
        left_out: usize,
    },
    /// The files that COLMAP's mapper reads are written.
    #[cfg(feature = "colmap")]
    Colmap(Box<ColmapDone>),
}

/// Progress that is reported before the answer.
#[derive(Debug, Clone)]
pub enum DatasetEvent {
    /// A burst is begun.
    Begun {
        /// Its place.
        index: usize,
    },
    /// A burst is finished.
    Done {
        /// Its place.
        index: usize,
        /// In numbers.
        finished: FinishedBurst,
    },
    /// A burst failed; the others go on.
    Failed {
        /// Its place.
        index: usize,
        /// Why.
        error: String,
    },
    /// A pair is matched.
    Matched {
        /// The places of its bursts.
        pair: (usize, usize),
        /// In numbers.
        counts: MatchCounts,
    },
}
