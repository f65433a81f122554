//! On to COLMAP: a folder from which its mapper can begin at once.
//!
//! `images/NAME.png` shows each burst, `features/NAME.png.txt` holds its features as COLMAP's importer takes them, and
//! `database.db` cameras, images, features, matches and verified geometries. Bursts that are finished are not done
//! again, see [`super::features`]; matches are, for they take little time beside the features.

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

/// The name of the database in the dataset's folder.
const DATABASE_FILE: &str = "database.db";

/// What is made of a dataset.
#[derive(Debug, Clone, PartialEq)]
pub struct ColmapJob {
    /// How features are found.
    pub features: FeatureJob,
    /// How they are matched. Where the camera is known it is used for verification; [`MatchParams::camera`] is set from
    /// it.
    pub matching: MatchParams,
    /// Which bursts are matched with which.
    pub pairs: PairSelection,
    /// The camera.
    pub camera: CameraChoice,
}

/// What happens to a dataset, as it happens.
#[derive(Debug)]
pub enum Event<'a> {
    /// A burst is begun.
    Begin {
        /// Its place in the dataset, from 0.
        index: usize,
        /// Number of bursts.
        count: usize,
        /// Its name.
        name: &'a str,
    },
    /// A burst is finished.
    Done(&'a BurstFeatures),
    /// A burst cannot be opened; the others go on.
    Failed {
        /// Its name.
        name: &'a str,
        /// Why.
        error: &'a DatasetError,
    },
    /// All bursts are done, and this many pairs are matched.
    Matching {
        /// Number of pairs.
        pairs: usize,
    },
}

/// One image of the database.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ImageReport {
    /// Its id in the database.
    pub id: u32,
    /// The burst's name.
    pub burst: String,
    /// Its file below the folder of images.
    pub image: String,
    /// Number of features.
    pub features: usize,
    /// Whether an earlier run had found them.
    pub resumed: bool,
}

/// One matched pair.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PairReport {
    /// The images' ids, the smaller one first.
    pub ids: [u32; 2],
    /// The numbers of the match.
    #[serde(flatten)]
    pub counts: MatchCounts,
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColmapReport {
    /// The database.
    #[serde(serialize_with = "serialize_path")]
    pub database: PathBuf,
    /// The folder of images.
    #[serde(serialize_with = "serialize_path")]
    pub images_folder: PathBuf,
    /// The cameras, one for each size of image.
    pub cameras: Vec<Camera>,
    /// Whether the focal length is known.
    pub known_camera: bool,
    /// The images, by rising id.
    pub images: Vec<ImageReport>,
    /// The pairs, in order.
    pub pairs: Vec<PairReport>,
}

/// Finds the features of `bursts`, matches them, and writes what COLMAP's mapper takes into the folder `out`. `on`
/// hears what happens. A burst that cannot be opened is left out.
///
/// # Errors
/// [`DatasetError`]. Files are written whole or not at all; finished bursts stay finished.
pub fn export_colmap(
    bursts: &[BurstSource],
    out: &Path,
    job: &ColmapJob,
    on: &mut dyn FnMut(Event<'_>),
    monitor: &Monitor,
) -> Result<ColmapReport, DatasetError> {
    export_colmap_from(&mut FeatureStore::open(out, &job.features)?, bursts, job, on, monitor)
}

/// The same into the folder of `store`, which holds what [`ColmapJob::features`] says.
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
            // COLMAP too has no row for a pair without a match.
            if !result.matches.is_empty() {
                let geometry = database_geometry(&all[a], &all[b], result);
                database.add_pair(ids[0], ids[1], &match_indices(result), geometry.as_ref())?;
            }
            Ok(())
        };
        match_pairs(&all, &pairs, &matching, &mut write, monitor)?;
        Ok(monitor.check()?)
    })?;
    // Should the folder have been removed since, it holds nothing but the database now.
    store.begin_writing()?;
    Ok(report)
}

/// The features of every burst that can be opened.
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
    /// The parameters of matching with the camera where it is known.
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
