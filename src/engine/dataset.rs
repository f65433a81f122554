//! Work on a whole dataset: looking at it, finding the features of all its bursts, matching pairs of them; and small
//! pictures of its bursts.
//!
//! Such work is long, and a person wants to see each burst and each pair as it is finished. So beside the one
//! answer at the end there are events on the way. Events of a request that another has replaced are dropped.

use super::Running;
use super::fault::JobError;
use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use crate::burst::{BurstSource, OpenOptions};
use crate::dataset::{
    BurstEvent, BurstFeatures, CameraChoice, DatasetError, DatasetSource, FeatureJob, FeatureStore, FinishedBurst,
    ImageKind, Thumbnail, detect_all, match_pairs, thumbnail,
};
use crate::detector::SearchParams;
use crate::matching::{MatchCounts, MatchParams};
use crate::monitor::{Monitor, Stage};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// The bursts of a dataset, shared by all who work on them.
pub type Bursts = Arc<Vec<BurstSource>>;

/// Where features are kept, and how they are found: an immutable snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct Keeping {
    /// The folder.
    pub folder: PathBuf,
    /// The detector's parameters, and how the slopes are chosen.
    pub params: SearchParams,
}

impl Keeping {
    fn store(&self) -> Result<FeatureStore, DatasetError> {
        let job =
            FeatureJob { detector: self.params.clone(), open: OpenOptions::default(), images: ImageKind::default() };
        FeatureStore::open(&self.folder, &job)
    }
}

/// What is to be done with a dataset.
#[derive(Debug, Clone)]
pub enum DatasetRequest {
    /// Find out which bursts there are, and which of them are finished. Without a folder the dataset's own is taken.
    Open {
        /// Where they come from.
        source: DatasetSource,
        /// Where features are kept.
        folder: Option<PathBuf>,
        /// With which parameters.
        params: SearchParams,
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
    /// Write what COLMAP's mapper takes.
    #[cfg(feature = "colmap")]
    Colmap {
        /// The bursts.
        bursts: Bursts,
        /// What is made, and where.
        request: Box<super::colmap::ColmapRequest>,
    },
}

/// A dataset that was looked at.
#[derive(Debug, Clone)]
pub struct OpenDataset {
    /// Where it comes from.
    pub source: DatasetSource,
    /// Its bursts; at least one.
    pub bursts: Bursts,
    /// Files of its only burst; `None` if there are several bursts.
    pub frames_of_one: Option<usize>,
    /// Where features are kept; `None` if no folder was given and the dataset has none of its own.
    pub folder: Option<PathBuf>,
    /// Why features cannot be kept there.
    pub folder_error: Option<String>,
    /// The parameters with which it was looked at.
    pub params: SearchParams,
    /// For each burst what is finished with these parameters.
    pub finished: Vec<Option<FinishedBurst>>,
    /// Other parameters, with which the features in the folder were found.
    pub other_params: Option<SearchParams>,
}

/// How a request ended.
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
    /// What COLMAP's mapper takes is written.
    #[cfg(feature = "colmap")]
    Colmap(Box<super::colmap::ColmapDone>),
}

/// What happens on the way.
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

/// Something that was published about datasets since the last poll. Events come before the answer that ends their
/// request.
#[derive(Debug)]
pub enum DatasetUpdate {
    /// On the way.
    Event(DatasetEvent),
    /// A request ended.
    Ended(JobAnswer<DatasetAnswer>),
    /// A burst's small picture, or why there is none.
    Thumbnail {
        /// The burst's first path: places change with the dataset.
        source: BurstSource,
        /// The picture.
        picture: Result<Thumbnail, String>,
    },
}

/// A burst's small picture, or why there is none.
type ThumbnailNews = (BurstSource, Result<Thumbnail, String>);

/// The workers for datasets.
pub struct DatasetWorkers {
    work: Jobs<DatasetRequest, DatasetAnswer, DatasetEvent>,
    thumbnails: Jobs<(Vec<BurstSource>, usize), (), ThumbnailNews>,
}

impl DatasetWorkers {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        let make = |(bursts, side): (Vec<BurstSource>, usize), tell: &dyn Fn(ThumbnailNews), monitor: &Monitor| {
            for source in bursts {
                let picture = thumbnail(&source, side, &monitor.silent()).map_err(|e| e.to_string());
                monitor.check()?;
                tell((source, picture));
            }
            Ok(())
        };
        Self {
            work: Jobs::telling(queue, Priority::Dataset, Duration::ZERO, run),
            thumbnails: Jobs::telling(queue, Priority::Dataset, Duration::ZERO, make),
        }
    }

    /// Starts a piece of work; the one that runs is cancelled.
    pub fn submit(&self, request: DatasetRequest) {
        self.work.submit(request);
    }

    /// Asks for the small pictures of `bursts`, no side longer than `max_side_px`, in this order. What was asked for
    /// before and is not there yet is not made.
    pub fn request_thumbnails(&self, bursts: Vec<BurstSource>, max_side_px: usize) {
        self.thumbnails.submit((bursts, max_side_px));
    }

    /// Whether small pictures are being made.
    pub fn makes_thumbnails(&self) -> bool {
        !self.thumbnails.is_idle()
    }

    /// What is being done with a dataset now, if anything.
    pub fn running(&self) -> Option<Running> {
        self.work.running()
    }

    /// Cancels it. What is finished stays finished.
    pub fn cancel(&self) {
        self.work.cancel();
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        self.work.is_idle() && self.thumbnails.is_idle()
    }

    pub(super) fn poll(&self) -> Vec<DatasetUpdate> {
        let (events, ended) = self.work.take_news();
        let (pictures, _) = self.thumbnails.take_news();
        let mut updates: Vec<DatasetUpdate> = events.into_iter().map(DatasetUpdate::Event).collect();
        updates.extend(pictures.into_iter().map(|(source, picture)| DatasetUpdate::Thumbnail { source, picture }));
        updates.extend(ended.into_iter().map(DatasetUpdate::Ended));
        updates
    }
}

fn run(request: DatasetRequest, tell: &dyn Fn(DatasetEvent), monitor: &Monitor) -> Result<DatasetAnswer, JobError> {
    match request {
        DatasetRequest::Open { source, folder, params } => {
            look(source, folder, params, monitor).map(|open| DatasetAnswer::Opened(Box::new(open)))
        }
        DatasetRequest::Detect { bursts, keeping } => detect(&bursts, &keeping, tell, monitor),
        DatasetRequest::Match { bursts, keeping, pairs, matching } => {
            match_all(&bursts, &keeping, &pairs, &matching, tell, monitor)
        }
        #[cfg(feature = "colmap")]
        DatasetRequest::Colmap { bursts, request } => super::colmap::run(&bursts, &request, tell, monitor)
            .map(|done| DatasetAnswer::Colmap(Box::new(done)))
            .map_err(job_error),
    }
}

fn look(
    source: DatasetSource,
    folder: Option<PathBuf>,
    params: SearchParams,
    monitor: &Monitor,
) -> Result<OpenDataset, JobError> {
    monitor.report(Stage::Open, 0.0);
    let bursts = source.bursts().map_err(|e| JobError::Failed(e.to_string()))?;
    monitor.check()?;
    let frames_of_one = match &bursts[..] {
        [one] => one.files().ok().map(|files| files.len()),
        _ => None,
    };
    let folder = folder.or_else(|| source.default_folder());
    let (mut finished, mut folder_error, mut other_params) = (vec![None; bursts.len()], None, None);
    if let Some(folder) = &folder {
        match (Keeping { folder: folder.clone(), params: params.clone() }).store() {
            Ok(store) => {
                for (index, (burst, finished)) in bursts.iter().zip(&mut finished).enumerate() {
                    monitor.check()?;
                    monitor.report(Stage::Open, index as f32 / bursts.len() as f32);
                    *finished = store.finished(burst);
                }
                other_params = other_params_in(folder, &params);
            }
            Err(error) => folder_error = Some(error.to_string()),
        }
    }
    let bursts = Arc::new(bursts);
    Ok(OpenDataset { source, bursts, frames_of_one, folder, folder_error, params, finished, other_params })
}

fn other_params_in(folder: &Path, params: &SearchParams) -> Option<SearchParams> {
    FeatureStore::params_in(folder).filter(|stored| stored != params)
}

fn detect(
    bursts: &[BurstSource],
    keeping: &Keeping,
    tell: &dyn Fn(DatasetEvent),
    monitor: &Monitor,
) -> Result<DatasetAnswer, JobError> {
    keeping.params.validate().map_err(|e| JobError::Failed(e.to_string()))?;
    let mut store = keeping.store().map_err(job_error)?;
    let mut on = |event: BurstEvent<'_>| {
        tell(match event {
            BurstEvent::Begin { index } => DatasetEvent::Begun { index },
            BurstEvent::Done { index, features } => DatasetEvent::Done { index, finished: features.summary() },
            BurstEvent::Failed { index, error } => DatasetEvent::Failed { index, error: error.to_string() },
        });
    };
    detect_all(&mut store, bursts, &CameraChoice::default(), &mut on, monitor).map_err(job_error)?;
    Ok(DatasetAnswer::Detected)
}

/// The part of the work of matching that is reading features from files.
const READING_SHARE: f32 = 0.2;

fn match_all(
    bursts: &[BurstSource],
    keeping: &Keeping,
    pairs: &[(usize, usize)],
    matching: &MatchParams,
    tell: &dyn Fn(DatasetEvent),
    monitor: &Monitor,
) -> Result<DatasetAnswer, JobError> {
    matching.validate().map_err(|e| JobError::Failed(e.to_string()))?;
    let store = keeping.store().map_err(job_error)?;
    let mut wanted: Vec<usize> = pairs.iter().flat_map(|&(a, b)| [a, b]).collect();
    wanted.sort_unstable();
    wanted.dedup();
    // Only what is matched is read; `place_of[index]` is where a burst is among these.
    let (mut read, mut place_of) = (Vec::<BurstFeatures>::new(), vec![None; bursts.len()]);
    for (count, &index) in wanted.iter().enumerate() {
        monitor.check()?;
        monitor.report(Stage::Open, READING_SHARE * count as f32 / wanted.len() as f32);
        if let Some(features) = bursts.get(index).and_then(|source| store.kept(source)) {
            place_of[index] = Some(read.len());
            read.push(features);
        }
    }
    let place = |index: usize| place_of.get(index).copied().flatten();
    let (indices, places): (Vec<_>, Vec<_>) =
        pairs.iter().filter_map(|&(a, b)| Some(((a, b), (place(a)?, place(b)?)))).unzip();
    let mut next = indices.iter();
    let mut on = |_, result: &crate::matching::MatchResult| {
        // Results come in the order of the pairs.
        if let Some(&pair) = next.next() {
            tell(DatasetEvent::Matched { pair, counts: result.counts });
        }
        Ok(())
    };
    let rest = monitor.part(READING_SHARE, 1.0 - READING_SHARE);
    match_pairs(&read, &places, matching, &mut on, &rest).map_err(job_error)?;
    Ok(DatasetAnswer::Matched { left_out: pairs.len() - indices.len() })
}

fn job_error(error: DatasetError) -> JobError {
    match error {
        DatasetError::Cancelled(cancelled) => cancelled.into(),
        error => JobError::Failed(error.to_string()),
    }
}
