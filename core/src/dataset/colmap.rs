//! Export of a dataset to COLMAP: a folder from which its mapper can start directly.
//!
//! `images/NAME.png` shows each burst, `features/NAME.png.txt` holds its features in the form of COLMAP's importer, and
//! `database.db` cameras, images, features, matches and verified geometries. Finished bursts are not computed again,
//! see [`super::features`]; matches are, because they take little time compared with features.

use super::features::{BurstEvent, BurstFeatures, FeatureJob, FeatureStore, IMAGES_FOLDER, detect_all};
use super::geometry::{database_camera, database_geometry, match_indices};
use super::pairs::match_pairs;
use super::{CameraChoice, DatasetError};
use crate::burst::BurstSource;
use crate::export::write_colmap_database;
use crate::files::serialize_path;
use crate::matching::PairSelection;
use crate::matching::{Camera, Geometry, MatchCounts, MatchParams, MatchResult};
use crate::monitor::Monitor;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Name of the database in the dataset's folder.
const DATABASE_FILE: &str = "database.db";

/// Parameters of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct ColmapJob {
    /// Parameters of finding features.
    pub features: FeatureJob,
    /// Parameters of matching. A known camera is used for verification; [`MatchParams::camera`] is set from it.
    pub matching: MatchParams,
    /// Selection of the pairs of bursts that are matched.
    pub pairs: PairSelection,
    /// The camera.
    pub camera: CameraChoice,
}

/// Event of an export.
#[derive(Debug)]
pub enum Event<'a> {
    /// A burst was started.
    Begin {
        /// Index in the dataset, from 0.
        index: usize,
        /// Number of bursts.
        count: usize,
        /// Name of the burst.
        name: &'a str,
    },
    /// A burst was finished.
    Done(&'a BurstFeatures),
    /// A burst cannot be opened; the export continues with the others.
    Failed {
        /// Name of the burst.
        name: &'a str,
        /// Reason.
        error: &'a DatasetError,
    },
    /// All bursts are finished, and matching begins.
    Matching {
        /// Number of pairs.
        pairs: usize,
    },
}

/// Report of one image of the database.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ImageReport {
    /// Id in the database.
    pub id: u32,
    /// Name of the burst.
    pub burst: String,
    /// File below the folder of images.
    pub image: String,
    /// Number of features.
    pub features: usize,
    /// Whether an earlier run had found the features.
    pub resumed: bool,
}

/// Report of one matched pair.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PairReport {
    /// Ids of the images, the smaller one first.
    pub ids: [u32; 2],
    /// Counts of the match.
    #[serde(flatten)]
    pub counts: MatchCounts,
}

/// Report of an export.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColmapReport {
    /// Path of the database.
    #[serde(serialize_with = "serialize_path")]
    pub database: PathBuf,
    /// Folder of images.
    #[serde(serialize_with = "serialize_path")]
    pub images_folder: PathBuf,
    /// Cameras, one for each size of image.
    pub cameras: Vec<Camera>,
    /// Whether the focal length is known.
    pub known_camera: bool,
    /// Images, in ascending id.
    pub images: Vec<ImageReport>,
    /// Pairs, in order.
    pub pairs: Vec<PairReport>,
}

/// Finds the features of `bursts`, matches them, and writes the input of COLMAP's mapper into the folder `out`. `on` is
/// called with every event. A burst that cannot be opened is left out.
///
/// # Errors
/// [`DatasetError`]. Files are written completely or not at all; finished bursts stay finished.
pub fn export_colmap(
    bursts: &[BurstSource],
    out: &Path,
    job: &ColmapJob,
    on: &mut dyn FnMut(Event<'_>),
    monitor: &Monitor,
) -> Result<ColmapReport, DatasetError> {
    export_colmap_from(&mut FeatureStore::open(out, &job.features)?, bursts, job, on, monitor)
}

/// Exports as `export_colmap` does, into the folder of `store`, which was opened with [`ColmapJob::features`].
///
/// # Errors
/// As [`export_colmap`].
pub fn export_colmap_from(
    store: &mut FeatureStore,
    bursts: &[BurstSource],
    job: &ColmapJob,
    on: &mut dyn FnMut(Event<'_>),
    monitor: &Monitor,
) -> Result<ColmapReport, DatasetError> {
    let matching = job.verified_matching()?;
    job.features.detector.validate()?;
    if bursts.len() < 2 {
        return Err(DatasetError::TooFew { count: bursts.len() });
    }
    let out = store.folder().to_path_buf();
    store.protect(bursts)?;
    store.check_output(&out.join(DATABASE_FILE))?;
    let all = features_of_all(bursts, store, job, on, monitor)?;
    if all.len() < 2 {
        return Err(DatasetError::TooFew { count: all.len() });
    }
    let pairs = job.pairs.pairs(all.len());
    on(Event::Matching { pairs: pairs.len() });
    store.begin_writing()?;
    let mut report = ColmapReport {
        database: out.join(DATABASE_FILE),
        images_folder: out.join(IMAGES_FOLDER),
        cameras: Vec::new(),
        known_camera: job.camera.is_known(),
        images: Vec::new(),
        pairs: Vec::new(),
    };
    store.check_output(&report.database)?;
    write_colmap_database(&report.database.clone(), |database| -> Result<(), DatasetError> {
        for burst in &all {
            monitor.check()?;
            let camera = job.camera.for_images(burst.size)?;
            let known = report.cameras.iter().position(|c| *c == camera);
            let camera_id = match known {
                Some(index) => index as u32 + 1,
                None => {
                    let id = database.add_camera(&database_camera(&camera, report.known_camera))?;
                    report.cameras.push(camera);
                    id
                }
            };
            let id = database.add_image(&burst.image_name, camera_id, &burst.keypoints, &burst.descriptors)?;
            report.images.push(ImageReport {
                id,
                burst: burst.name.clone(),
                image: burst.image_name.clone(),
                features: burst.keypoints.len(),
                resumed: burst.resumed,
            });
        }
        let mut write = |(a, b): (usize, usize), result: &MatchResult| -> Result<(), DatasetError> {
            let ids = [report.images[a].id, report.images[b].id];
            report.pairs.push(PairReport { ids, counts: result.counts });
            // COLMAP also has no row for a pair without a match.
            if !result.matches.is_empty() {
                let geometry = database_geometry(&all[a], &all[b], result);
                database.add_pair(ids[0], ids[1], &match_indices(result), geometry.as_ref())?;
            }
            Ok(())
        };
        match_pairs(&all, &pairs, &matching, &mut write, monitor)?;
        Ok(monitor.check()?)
    })?;
    // If the folder was removed meanwhile, it now holds only the database.
    store.begin_writing()?;
    Ok(report)
}

/// The features of all bursts that can be opened.
fn features_of_all(
    bursts: &[BurstSource],
    store: &mut FeatureStore,
    job: &ColmapJob,
    on: &mut dyn FnMut(Event<'_>),
    monitor: &Monitor,
) -> Result<Vec<BurstFeatures>, DatasetError> {
    let mut all = Vec::with_capacity(bursts.len());
    let mut tell = |event: BurstEvent<'_>| match event {
        BurstEvent::Begin { index } => on(Event::Begin { index, count: bursts.len(), name: &bursts[index].name }),
        BurstEvent::Done { features, .. } => {
            on(Event::Done(&features));
            all.push(features);
        }
        BurstEvent::Failed { index, error } => on(Event::Failed { name: &bursts[index].name, error }),
    };
    detect_all(store, bursts, &job.camera, &mut tell, monitor)?;
    Ok(all)
}

impl ColmapJob {
    /// The parameters of matching, with the camera where it is known.
    fn verified_matching(&self) -> Result<MatchParams, DatasetError> {
        let camera = match &self.camera {
            CameraChoice::Known(camera) => Some(camera.clone()),
            CameraChoice::Guessed(_) => None,
        };
        let matching = MatchParams { camera, ..self.matching.clone() };
        matching.validate()?;
        if matching.geometry == Geometry::None {
            return Err(crate::detector::ParamError {
                parameter: crate::matching::params::doc::GEOMETRY.name,
                problem: "COLMAP's mapper takes verified matches only".to_owned(),
                remedy: "give fundamental, essential or homography".to_owned(),
            }
            .into());
        }
        Ok(matching)
    }
}
