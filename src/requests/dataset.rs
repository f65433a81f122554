//! Work on a whole dataset, opening, detecting, matching and exporting: long, so that each finished burst and pair is
//! reported before the answer.

use crate::burst::{BurstFiles, Entries, OpenOptions};
use crate::dataset::{
    BurstCameras, BurstEvent, BurstPicture, DatasetSource, FeatureJob, FeatureStore, FinishedBurst, ImageKind,
    KeptBursts, MatchedPair, detect_all, match_pairs, thumbnail,
};
#[cfg(feature = "colmap")]
use crate::dataset::{ColmapJob, ColmapReport, export_colmap, gather};
use crate::detector::SearchParams;
use crate::error::Error;
use crate::files::shell_path;
use crate::matching::{MatchCounts, MatchParams, PairSelection};
use crate::monitor::{Monitor, Stage};
use crate::requests::JobError;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub type Bursts = Arc<Vec<BurstFiles>>;

/// Folder in which features are kept, and parameters with which they are found: an immutable snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct Keeping {
    pub folder: PathBuf,
    pub params: SearchParams,
    pub open: OpenOptions,
}

impl Keeping {
    fn store(&self) -> Result<FeatureStore, Error> {
        let job = FeatureJob { detector: self.params.clone(), open: self.open.clone(), images: ImageKind::default() };
        FeatureStore::open(&self.folder, &job)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum DatasetRequest {
    /// Find out which bursts there are, and which of them are finished. Without a folder the dataset's own is taken.
    Open { source: DatasetSource, folder: Option<PathBuf>, params: SearchParams, open: OpenOptions },
    /// Find the features of all bursts that are not finished.
    Detect { bursts: Bursts, keeping: Keeping },
    /// Match pairs of finished bursts; pairs with one that is not are left out.
    Match { bursts: Bursts, keeping: Keeping, pairs: PairSelection, matching: MatchParams },
    #[cfg(feature = "colmap")]
    Colmap { bursts: Bursts, request: Box<ColmapRequest> },
}

#[derive(Debug, Clone)]
pub struct OpenDataset {
    pub source: DatasetSource,
    pub bursts: Bursts,
    pub strays: Vec<PathBuf>,
    /// Files of its only burst; `None` if there are several bursts.
    pub frames_of_one: Option<usize>,
    /// Folder of kept features; `None` without a given or default folder.
    pub folder: Option<PathBuf>,
    pub folder_error: Option<String>,
    pub params: SearchParams,
    pub open: OpenOptions,
    pub finished: Vec<Option<FinishedBurst>>,
    pub other_params: Option<SearchParams>,
}

#[derive(Debug, Clone)]
pub enum DatasetAnswer {
    Opened(Box<OpenDataset>),
    Detected,
    /// All pairs are matched, except those left out because a burst is not finished.
    Matched {
        left_out: usize,
    },
    #[cfg(feature = "colmap")]
    Colmap(Box<ColmapDone>),
}

#[derive(Debug, Clone)]
pub enum DatasetEvent {
    Begun { index: usize },
    Done { index: usize, finished: FinishedBurst },
    Failed { index: usize, error: String },
    Matched { pair: (usize, usize), counts: MatchCounts },
}

impl DatasetEvent {
    fn of(event: &BurstEvent<'_>) -> Option<Self> {
        match *event {
            BurstEvent::Begin(index) => Some(Self::Begun { index }),
            BurstEvent::Done(index, features) => Some(Self::Done { index, finished: features.summary() }),
            BurstEvent::Failed(index, error) => Some(Self::Failed { index, error: error.to_string() }),
            BurstEvent::Matching(_) => None,
        }
    }
}

request! {
    DatasetRequest => DatasetAnswer; DatasetEvent, Dataset: |self, work| {
        let (tell, monitor) = (work.tell, work.monitor);
        match self {
            Self::Open { source, folder, params, open } => {
                Ok(DatasetAnswer::Opened(Box::new(OpenDataset::look(source, folder, params, open, monitor)?)))
            }
            Self::Detect { bursts, keeping } => {
                let mut on = |event: BurstEvent<'_>| DatasetEvent::of(&event).into_iter().for_each(tell);
                detect_all(&mut keeping.store()?, &bursts, &BurstCameras::default(), &mut on, monitor)?;
                Ok(DatasetAnswer::Detected)
            }
            Self::Match { bursts, keeping, pairs, matching } => {
                // Features are read when a pair needs them, so that few bursts are in memory.
                let mut kept = KeptBursts { store: &keeping.store()?, bursts: &bursts, monitor };
                let pairs = kept.pairs(&pairs)?;
                let mut on = |matched: MatchedPair<'_>| {
                    let aligned = matched.aligned(&matching, &monitor.silent())?;
                    tell(DatasetEvent::Matched { pair: matched.indices, counts: aligned.counts });
                    Ok(())
                };
                let left_out = match_pairs::<JobError>(&pairs, &matching, &mut kept, &mut on, monitor)?;
                Ok(DatasetAnswer::Matched { left_out })
            }
            #[cfg(feature = "colmap")]
            Self::Colmap { bursts, request } => {
                Ok(DatasetAnswer::Colmap(Box::new(export(&bursts, *request, tell, monitor)?)))
            }
        }
    }
}

impl OpenDataset {
    fn look(
        source: DatasetSource,
        folder: Option<PathBuf>,
        params: SearchParams,
        open: OpenOptions,
        monitor: &Monitor,
    ) -> Result<Self, JobError> {
        monitor.report(Stage::Open, 0.0);
        let Entries { bursts, strays } = source.entries(&open)?;
        monitor.check()?;
        let frames_of_one = if let [one] = &bursts[..] { one.files().ok().map(|files| files.len()) } else { None };
        let folder = folder.or_else(|| source.default_folder());
        let (mut finished, mut folder_error, mut other_params) = (vec![None; bursts.len()], None, None);
        // A folder that cannot be read is reported beside the open dataset, and does not keep it from opening.
        if let Some(folder) = &folder {
            match (Keeping { folder: folder.clone(), params: params.clone(), open: open.clone() }).store() {
                Ok(store) => {
                    for (index, (burst, finished)) in bursts.iter().zip(&mut finished).enumerate() {
                        monitor.check()?;
                        monitor.report(Stage::Open, index as f32 / bursts.len() as f32);
                        *finished = store.finished(burst);
                    }
                    other_params = FeatureStore::params_in(folder).filter(|stored| *stored != params);
                }
                Err(error) => folder_error = Some(error.to_string()),
            }
        }
        let bursts = Arc::new(bursts);
        Ok(Self { source, bursts, strays, frames_of_one, folder, folder_error, params, open, finished, other_params })
    }
}

/// Export of a whole dataset for COLMAP's mapper: the work of the command `colmap`.
#[cfg(feature = "colmap")]
#[derive(Debug, Clone, PartialEq)]
pub struct ColmapRequest {
    pub out: PathBuf,
    /// Paths of the dataset: a file `camera.toml` in a folder there is the camera of its bursts, if `job` has none.
    pub inputs: Vec<PathBuf>,
    /// Folder in which the dataset's features are kept: those of the same parameters are copied, not found again.
    pub kept: Option<PathBuf>,
    pub job: ColmapJob,
}

#[cfg(feature = "colmap")]
#[derive(Debug, Clone)]
pub struct ColmapDone {
    pub report: ColmapReport,
    pub left_out: Vec<(String, String)>,
}

/// Bursts whose features are in the folder, or where the dataset keeps them, are not searched again.
#[cfg(feature = "colmap")]
fn export(
    bursts: &[BurstFiles],
    ColmapRequest { out, inputs, kept, mut job }: ColmapRequest,
    tell: &dyn Fn(DatasetEvent),
    monitor: &Monitor,
) -> Result<ColmapDone, Error> {
    let mut left_out = Vec::new();
    let mut on = |event: BurstEvent<'_>| {
        if let BurstEvent::Failed(index, error) = event {
            left_out.push((bursts[index].name.clone(), error.to_string()));
        }
        DatasetEvent::of(&event).into_iter().for_each(tell);
    };
    job.cameras = BurstCameras::of(bursts, &inputs, &[], job.cameras.rest)?;
    let mut store = FeatureStore::open(&out, &job.features)?;
    if let Some(kept) = kept.filter(|kept| *kept != out && kept.is_dir()) {
        gather(&mut store, bursts, &[kept], monitor)?;
    }
    let report = export_colmap(&mut store, bursts, &job, &mut on, monitor)?;
    Ok(ColmapDone { report, left_out })
}

#[derive(Debug, Clone, PartialEq)]
pub struct ThumbnailsRequest {
    /// The bursts, in the order in which their pictures are made.
    pub bursts: Vec<BurstFiles>,
    pub max_side_px: usize,
    pub open: OpenOptions,
}

request! {
    ThumbnailsRequest => (); (BurstFiles, Result<BurstPicture, String>), Dataset: |self, work| {
        for source in self.bursts {
            let silent = work.monitor.silent();
            let picture = thumbnail(&source, self.max_side_px, &self.open, &silent).map_err(|e| e.to_string());
            // Cancellation makes the picture fail, which is no fault of the burst.
            work.monitor.check()?;
            (work.tell)((source, picture));
        }
        Ok(())
    }
}

/// Sentence about a model beside the database in `out`, which was made of another one; `None` where there is none.
pub fn old_model(out: &Path) -> Option<String> {
    let old = out.join("sparse");
    old.exists().then(|| format!("{} is of an earlier database: its poses are not of this one", old.display()))
}

/// Commands that reconstruct what an export wrote to `out`: the mapper of COLMAP in two lines, or that of pycolmap. A
/// known camera is held; a guessed one is refined.
pub fn next_commands(out: &Path, knows_camera: bool) -> [String; 3] {
    // A mapper refines the focal length and the distortion unless it is told not to.
    let refined = ["focal_length", "principal_point", "extra_params"].map(|what| format!("ba_refine_{what}"));
    let [colmap, pycolmap] = match knows_camera {
        true => [
            format!(" --Mapper.{} 0", refined.join(" 0 --Mapper.")),
            format!(", dict({}=False)", refined.join("=False, ")),
        ],
        false => Default::default(),
    };
    let [database, images, sparse] = ["database.db", "images", "sparse"].map(|name| shell_path(&out.join(name)));
    [
        format!("mkdir -p {sparse}"),
        format!("colmap mapper --database_path {database} --image_path {images} --output_path {sparse}{colmap}"),
        format!(
            "python3 -c 'import sys, pycolmap; pycolmap.incremental_mapping(*sys.argv[1:]{pycolmap})' {database} {images} {sparse}"
        ),
    ]
}
