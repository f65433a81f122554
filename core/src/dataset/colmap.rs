//! Export of a dataset to COLMAP: a folder from which its mapper can start directly.
//!
//! `images/NAME.png` shows each burst, `features/NAME.png.txt` holds its features in the form of COLMAP's importer, and
//! `database.db` cameras, images, features, matches and verified geometries. Finished bursts are not computed again;
//! matches are. Features are in memory only while they are found or matched: memory does not grow with the bursts.

use super::CameraChoice;
use super::features::{BurstEvent, BurstFeatures, FeatureJob, FeatureStore, IMAGES_FOLDER, detect_all};
use super::pairs::{BurstSide, DetectedBurst, MatchedPair, PairSource, match_pairs};
use crate::burst::{Burst, BurstFiles};
use crate::detector::{DetectorParams, SearchParams};
use crate::error::{Error, ErrorKind, Result};
use crate::export::{
    ColmapKeypoint, DatabaseCamera, DatabaseGeometry, DatabaseWriter, GeometryKind, make_file_names_unique,
    write_colmap_database,
};
use crate::files::serialize_path;
use crate::matching::align::Measured;
use crate::matching::aligned::{Alignment, Inlier, Moved, Seen};
use crate::matching::{
    Blob, Camera, Geometry, MatchCounts, MatchParams, PairSelection, Pictures, Refusal, TwoViewModel, Unaligned,
    Verification,
};
use crate::monitor::Monitor;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};
use rayon::prelude::*;
use serde::Serialize;
use std::cell::RefCell;
use std::path::{Path, PathBuf};

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
    /// Camera of all images, or the model that is guessed for each size.
    pub camera: CameraChoice,
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
    /// Distances by which the database's keypoints moved from those in the files; `None` if they were not aligned.
    pub moved: Option<Moved>,
    /// Says why COLMAP's mapper will not be able to start from the database; `None` where a pair has enough inliers.
    pub no_start: Option<String>,
}

/// Inliers with which COLMAP's mapper begins, nearly: it asks for 100, 50, 25, and for 30 places of each further image.
const INLIERS_TO_START: usize = 30;

impl ColmapReport {
    fn why_no_start(&self) -> Option<String> {
        let best = self.pairs.iter().max_by_key(|pair| pair.counts.inliers)?;
        let most = best.counts.inliers.unwrap_or(0);
        if most >= INLIERS_TO_START {
            return None;
        }
        let name = |id: u32| self.images.iter().find(|image| image.id == id).map_or("", |image| &image.burst);
        let pairs_with = |has: fn(&MatchCounts) -> bool| self.pairs.iter().filter(|pair| has(&pair.counts)).count();
        let why = if most > 0 {
            let [a, b] = best.ids.map(name);
            format!("the most inliers of a pair are {most}, of {a} and {b}")
        } else {
            // The three causes have different remedies.
            let no_match = pairs_with(|counts| counts.putative == 0);
            let refused = pairs_with(|counts| counts.refused.is_some());
            let all = self.pairs.len();
            format!(
                "none of {all} pairs is verified ({no_match} without a match, {refused} refused, in the others too few agree)"
            )
        };
        let needed = format!("and it needs a pair with about {INLIERS_TO_START} inliers");
        Some(format!("a mapper will not be able to start from it: {why}, {needed}"))
    }
}

/// Finds the features of `bursts`, matches them, and writes the input of COLMAP's mapper into the folder of `store`,
/// opened with [`ColmapJob::features`]. `on` receives every event. A burst that cannot be opened is left out.
///
/// # Errors
/// Parameters, or what concerns all bursts. Files are written completely or not at all; finished bursts stay finished.
pub fn export_colmap(
    store: &mut FeatureStore,
    bursts: &[BurstFiles],
    job: &ColmapJob,
    on: &mut dyn FnMut(BurstEvent<'_>),
    monitor: &Monitor,
) -> Result<ColmapReport> {
    let matching = job.verified_matching()?;
    if bursts.len() < 2 {
        return Err(too_few(bursts.len()));
    }
    let out = store.folder.clone();
    // Outputs are checked before the search, which may take hours.
    store.protect(bursts)?;
    store.check_output(&out.join(DATABASE_FILE))?;
    // The index of each burst whose features are in the folder, and whether an earlier run had found them.
    let mut done: Vec<(usize, bool)> = Vec::with_capacity(bursts.len());
    let mut tell = |event: BurstEvent<'_>| {
        if let BurstEvent::Done(index, features) = event {
            done.push((index, features.resumed));
        }
        on(event);
    };
    detect_all(store, bursts, &job.camera, &mut tell, monitor)?;
    if done.len() < 2 {
        return Err(too_few(done.len()));
    }
    on(BurstEvent::Matching(job.pairs.pairs(done.len()).len()));
    // Where all bursts are resumed, nothing has locked the folder yet.
    store.begin_writing()?;
    let written = |place: usize| {
        let (index, resumed) = done[place];
        Ok(BurstFeatures { resumed, ..store.written(&bursts[index])? })
    };
    let open = |place: usize| store.open_burst(&bursts[done[place].0], &monitor.silent());
    let report = write_database(store, (job, &matching), (done.len(), &written, &open), monitor)?;
    // If the folder was removed meanwhile, it now holds only the database.
    store.begin_writing()?;
    Ok(report)
}

/// Writes COLMAP's input as [`export_colmap`] does, from `bursts` in memory, each with its own search parameters.
///
/// # Errors
/// Parameters, a folder that holds other files, and files that cannot be written.
pub fn export_detections(
    folder: &Path,
    bursts: &[DetectedBurst<'_>],
    job: &ColmapJob,
    monitor: &Monitor,
) -> Result<ColmapReport> {
    let matching = job.verified_matching()?;
    if bursts.len() < 2 {
        return Err(too_few(bursts.len()));
    }
    let of = |of: &DetectedBurst<'_>| BurstFiles { name: of.burst.name.clone(), paths: of.burst.sources.clone() };
    let mut sources: Vec<BurstFiles> = bursts.iter().map(of).collect();
    // Bursts in memory may share a name, and their files must not.
    make_file_names_unique(sources.iter_mut().map(|source| &mut source.name));
    let params = bursts.iter().map(|of| SearchParams::from(of.params.clone()).to_toml()).collect();
    let mut store = FeatureStore::of_detections(folder, &job.features, params)?;
    store.protect(&sources)?;
    store.check_output(&folder.join(DATABASE_FILE))?;
    // A camera of another size fails before anything is written.
    let sizes = bursts.iter().map(|of| job.camera.for_images(of.burst.size()));
    sizes.collect::<Result<Vec<_>>>()?;
    let found: Vec<BurstFeatures> =
        sources.iter().zip(bursts).map(|(source, of)| store.keep(source, of, monitor)).collect::<Result<_>>()?;
    let written = |place: usize| Ok(found[place].clone());
    let open = |place: usize| Ok((bursts[place].burst.clone(), bursts[place].params.clone()));
    let report = write_database(&store, (job, &matching), (found.len(), &written, &open), monitor)?;
    store.begin_writing()?;
    Ok(report)
}

/// Bursts of an export: their number, and by their places the features, and the frames with the parameters of search.
type Exported<'a> =
    (usize, &'a dyn Fn(usize) -> Result<BurstFeatures>, &'a dyn Fn(usize) -> Result<(Burst, DetectorParams)>);

fn write_database(
    store: &FeatureStore,
    (job, matching): (&ColmapJob, &MatchParams),
    (count, features, open): Exported<'_>,
    monitor: &Monitor,
) -> Result<ColmapReport> {
    let (database, images_folder) = (store.folder.join(DATABASE_FILE), store.folder.join(IMAGES_FOLDER));
    let (cameras, images, pairs) = (Vec::new(), Vec::new(), Vec::new());
    let known_camera = job.camera.is_known();
    let (moved, no_start) = (None, None);
    let mut report = ColmapReport { database, images_folder, cameras, known_camera, images, pairs, moved, no_start };
    store.check_output(&report.database)?;
    write_colmap_database(&report.database.clone(), |database| {
        let mut blobs = Vec::with_capacity(count);
        for place in 0..count {
            monitor.check()?;
            let mut burst = features(place)?;
            // Keypoints and descriptors go to the database; shapes alone stay in memory.
            blobs.push(std::mem::take(&mut burst.blobs));
            add_burst(database, &burst, job, &mut report)?;
        }
        match_all(database, (&job.pairs.pairs(count), &blobs), matching, open, &mut report, monitor)
    })?;
    report.no_start = report.why_no_start();
    Ok(report)
}

fn add_burst(
    database: &mut DatabaseWriter<'_>,
    burst: &BurstFeatures,
    job: &ColmapJob,
    report: &mut ColmapReport,
) -> Result<()> {
    let camera = job.camera.for_images(burst.size)?;
    // One camera for images of one size: the mapper then refines one lens, not many.
    let camera_id = match report.cameras.iter().position(|c| *c == camera) {
        Some(index) => index as u32 + 1,
        None => {
            let Camera { model, width, height, params } = camera.clone();
            let (model_id, prior_focal_length) = (model.id(), report.known_camera);
            let id = database.add_camera(&DatabaseCamera { model_id, width, height, params, prior_focal_length })?;
            report.cameras.push(camera);
            id
        }
    };
    let id = database.add_image(&burst.image_name, camera_id, &burst.keypoints, &burst.descriptors)?;
    let (name, image, features) = (burst.name.clone(), burst.image_name.clone(), burst.keypoints.len());
    report.images.push(ImageReport { id, burst: name, image, features, resumed: burst.resumed });
    Ok(())
}

/// A verified pair that waits for the solution: indices of its images, and its inliers with their measurements.
struct Waiting {
    images: (usize, usize),
    inliers: Vec<(Inlier, Option<Measured>)>,
}

struct InDatabase<'a, 'b> {
    database: &'a RefCell<&'a mut DatabaseWriter<'b>>,
    ids: &'a [u32],
    blobs: &'a [Vec<Blob>],
    open: &'a dyn Fn(usize) -> Result<(Burst, DetectorParams)>,
}

impl PairSource<Error> for InDatabase<'_, '_> {
    fn features(&mut self, index: usize) -> Result<Option<BurstSide>> {
        let (keypoints, descriptors) = self.database.borrow().features(self.ids[index])?;
        Ok(Some(BurstSide::new(&keypoints, descriptors, self.blobs[index].clone())))
    }

    fn burst(&mut self, index: usize) -> Result<(Burst, DetectorParams)> {
        (self.open)(index)
    }
}

fn match_all(
    database: &mut DatabaseWriter<'_>,
    (pairs, blobs): (&[(usize, usize)], &[Vec<Blob>]),
    matching: &MatchParams,
    open: &dyn Fn(usize) -> Result<(Burst, DetectorParams)>,
    report: &mut ColmapReport,
    monitor: &Monitor,
) -> Result<()> {
    let ids: Vec<u32> = report.images.iter().map(|image| image.id).collect();
    let database = RefCell::new(database);
    let mut source = InDatabase { database: &database, ids: &ids, blobs, open };
    let mut seen: Vec<Option<Seen>> = vec![None; ids.len()];
    let mut waiting: Vec<Waiting> = Vec::new();
    let mut write = |MatchedPair { indices: images, sides, found: Unaligned { result, measured } }: MatchedPair<'_>| {
        let [a, b] = [ids[images.0], ids[images.1]];
        for (image, side) in [images.0, images.1].into_iter().zip(sides) {
            // An image's pictures leave memory with its features: what the alignment needs of them is kept.
            seen[image] = seen[image].take().or_else(|| side.pictures.as_ref().map(Pictures::seen).cloned());
        }
        report.pairs.push(PairReport { ids: [a, b], counts: result.counts });
        // COLMAP also has no row for a pair without a match.
        if result.matches.is_empty() {
            return Ok(());
        }
        let mut database = database.borrow_mut();
        database.add_matches(a, b, &result.matches.iter().map(|m| [m.a as u32, m.b as u32]).collect::<Vec<_>>())?;
        let Some(verified) = &result.verification else { return Ok(()) };
        let agreed = result.matches.iter().zip(measured).zip(&verified.inlier).filter(|(_, inlier)| **inlier);
        let inliers: Vec<(Inlier, Option<Measured>)> = agreed.map(|((m, measured), _)| (m.into(), *measured)).collect();
        // With alignment, geometries wait until all pairs agree on the places.
        if matching.aligns() && verified.model.is_some() {
            waiting.push(Waiting { images, inliers });
            return Ok(());
        }
        let agreed: Vec<Inlier> = inliers.iter().map(|(m, _)| *m).collect();
        let places = [&sides[0].places[..], &sides[1].places];
        database.add_geometry(a, b, &database_geometry(places, &agreed, verified.model.as_ref()))
    };
    match_pairs(pairs, matching, &mut source, &mut write, monitor)?;
    // Pairs come in the order of loading.
    report.pairs.sort_by_key(|pair| pair.ids);
    if matching.aligns() {
        waiting.sort_by_key(|pair| pair.images);
        align_all(&mut database.borrow_mut(), (&waiting, blobs, seen), matching, report, monitor)?;
    }
    Ok(monitor.check()?)
}

fn align_all(
    database: &mut DatabaseWriter<'_>,
    (waiting, blobs, seen): (&[Waiting], &[Vec<Blob>], Vec<Option<Seen>>),
    matching: &MatchParams,
    report: &mut ColmapReport,
    monitor: &Monitor,
) -> Result<()> {
    let ids: Vec<u32> = report.images.iter().map(|image| image.id).collect();
    let mut alignment = Alignment::default();
    for ((&id, blobs), seen) in ids.iter().zip(blobs).zip(seen) {
        let (keypoints, _) = database.features(id)?;
        alignment.add_image(keypoints.iter().map(ColmapKeypoint::pos_image).collect(), blobs, seen);
    }
    // Links are numbered over all pairs, as the solution returns residuals by link.
    let mut linked: Vec<Vec<(Inlier, Option<usize>)>> = Vec::with_capacity(waiting.len());
    for Waiting { images, inliers } in waiting {
        let mut link = |m: &Inlier, measured| alignment.add_match(*images, (m.a as usize, m.b as usize), measured);
        linked.push(inliers.iter().map(|(m, measured)| (*m, measured.map(|measured| link(m, measured)))).collect());
    }
    let aligned = alignment.solve(monitor)?;
    report.moved = Some(aligned.moved);
    let confirmed: Vec<Option<Verification>> = waiting
        .par_iter()
        .zip(&linked)
        .map(|(pair, inliers)| aligned.confirmed(pair.images, inliers, matching, &monitor.silent()))
        .collect::<Result<_, _>>()?;
    // Features move first: geometries are of the places in the database.
    for (&id, places) in ids.iter().zip(&aligned.places) {
        database.move_features(id, places)?;
    }
    for (Waiting { images, inliers }, verified) in waiting.iter().zip(confirmed) {
        let Some(Verification { model, inlier, .. }) = verified else { continue };
        let agreed: Vec<Inlier> =
            inliers.iter().zip(inlier).filter(|(_, inlier)| *inlier).map(|((m, _), _)| *m).collect();
        let pair = [ids[images.0], ids[images.1]];
        // The reports were sorted before the alignment.
        if let Ok(index) = report.pairs.binary_search_by_key(&pair, |report| report.ids) {
            let counts = &mut report.pairs[index].counts;
            counts.inliers = Some(agreed.len());
            counts.refused = model.is_none().then_some(Refusal::Pictures);
        }
        let places = [&aligned.places[images.0][..], &aligned.places[images.1]];
        database.add_geometry(pair[0], pair[1], &database_geometry(places, &agreed, model.as_ref()))?;
    }
    Ok(())
}

fn too_few(bursts: usize) -> Error {
    let problem = format!("{bursts} bursts have features, and matching needs two or more");
    let remedy = "name a folder of bursts, or cut a long sequence with --burst-length";
    Error::new(ErrorKind::Failed, problem, remedy)
}

impl ColmapJob {
    fn verified_matching(&self) -> Result<MatchParams> {
        let camera = match &self.camera {
            CameraChoice::Known(camera) => Some(camera.clone()),
            CameraChoice::Guessed(_) => None,
        };
        // A guessed focal length is too uncertain for an essential matrix.
        let matching = MatchParams { camera, ..self.matching.clone() };
        matching.validate()?;
        if matching.geometry == Geometry::None {
            return Err(Error::param(
                crate::matching::params::doc::GEOMETRY.name,
                "COLMAP's mapper takes verified matches only",
                "give fundamental, essential or homography",
            ));
        }
        Ok(matching)
    }
}

fn database_geometry([a, b]: [&[[f64; 2]]; 2], inliers: &[Inlier], model: Option<&TwoViewModel>) -> DatabaseGeometry {
    let Some(model) = model else { return DatabaseGeometry::default() };
    let none =
        DatabaseGeometry { inliers: inliers.iter().map(|m| [m.a, m.b]).collect(), ..DatabaseGeometry::default() };
    match model {
        TwoViewModel::Fundamental { fundamental } => {
            DatabaseGeometry { kind: GeometryKind::Uncalibrated, fundamental: Some(*fundamental), ..none }
        }
        TwoViewModel::Homography { forward, .. } => {
            DatabaseGeometry { kind: GeometryKind::PlanarOrPanoramic, homography: Some(*forward), ..none }
        }
        TwoViewModel::Essential { essential, .. } => {
            let places: Vec<([f64; 2], [f64; 2])> =
                inliers.iter().map(|m| (a[m.a as usize], b[m.b as usize])).collect();
            // E alone leaves four poses; the inliers decide.
            let pose = model.relative_pose(&places).map(|(pose, _)| {
                let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(pose.rotation));
                Isometry3::from_parts(Translation3::from(pose.translation), rotation)
            });
            DatabaseGeometry { kind: GeometryKind::Calibrated, essential: Some(*essential), b_from_a: pose, ..none }
        }
    }
}
