//! Export of a dataset to COLMAP: a folder from which its mapper can start directly.
//!
//! `images/NAME.png` shows each burst, `features/NAME.png.txt` holds its features in the form of COLMAP's importer, and
//! `database.db` cameras, images, features, matches and verified geometries. Finished bursts and matched pairs are not
//! computed again; the places on which all pairs agree are. Features are in memory only while they are found or
//! matched: memory does not grow with the bursts. [`read_exported`] reads the report of such a folder.

use super::camera::{BurstCameras, CameraChoice};
use super::features::{BurstEvent, BurstFeatures, FeatureJob, FeatureStore, IMAGES_FOLDER, detect_all};
use super::joint::{Agreed, Joint, Waiting};
use super::kept::pairs_folder;
use super::kept_pairs::{KeptPairs, PairFound, PairedImage, why_refused};
use super::pairs::{BurstSide, DetectedBurst, PairSource, for_pairs, seen_part};
use super::report::{CameraReport, ColmapReport, ImageReport, Joined, PairReport};
use crate::burst::{Burst, BurstFiles};
use crate::detector::{Descriptor, DetectorParams, SearchParams};
use crate::error::{Error, ErrorKind, Result};
use crate::export::{
    ColmapKeypoint, DatabaseGeometry, DatabaseWriter, GeometryKind, make_file_names_unique, safe_file_name,
    write_colmap_database,
};
use crate::files::{mark::has_mark, open_database};
use crate::matching::aligned::{Alignment, Inlier, Seen};
use crate::matching::params::doc;
use crate::matching::tracks::Tracks;
use crate::matching::{
    Blob, Camera, Geometry, MatchCounts, MatchParams, MatchSide, PairSelection, Refusal, TwoViewModel, beside,
    match_features,
};
use crate::monitor::Monitor;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};
use rayon::prelude::*;
use rusqlite::Row;
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};
use std::path::Path;

const DATABASE_FILE: &str = "database.db";

/// Parameters of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct ColmapJob {
    /// Parameters of finding features.
    pub features: FeatureJob,
    /// Parameters of matching. A pair of known cameras is verified with them; [`MatchParams::camera`] is set from them.
    pub matching: MatchParams,
    /// Selection of the pairs of bursts that are matched.
    pub pairs: PairSelection,
    /// Cameras of the images, or the model that is guessed for each size.
    pub cameras: BurstCameras,
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
    check_enough(bursts.len())?;
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
    detect_all(store, bursts, &job.cameras, &mut tell, monitor)?;
    check_enough(done.len())?;
    let pairs = match &job.pairs {
        // A list is of all bursts, also of those that cannot be opened.
        PairSelection::Listed(pairs) => {
            let place = |burst: usize| done.binary_search_by_key(&burst, |(index, _)| *index).ok();
            PairSelection::Listed(pairs.iter().filter_map(|&(a, b)| Some((place(a)?, place(b)?))).collect())
        }
        other => other.clone(),
    };
    // Where all bursts are resumed, nothing has locked the folder yet.
    store.begin_writing()?;
    let written = |place: usize| {
        let (index, resumed) = done[place];
        let (features, seen, key) = store.written(&bursts[index])?;
        Ok((BurstFeatures { resumed, ..features }, seen, Some(key)))
    };
    let open = |place: usize| store.open_burst(&bursts[done[place].0], &monitor.silent());
    let report = write_database(store, (job, &matching, &pairs), (done.len(), &written, &open), on, monitor)?;
    store.exported_with = job.words(&report);
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
    check_enough(bursts.len())?;
    let of = |of: &DetectedBurst<'_>| BurstFiles { name: of.burst.name.clone(), paths: of.burst.sources.clone() };
    let mut sources: Vec<BurstFiles> = bursts.iter().map(of).collect();
    // Bursts in memory may share a name, and their files must not.
    make_file_names_unique(sources.iter_mut().map(|of| (&mut of.name, of.paths.first().cloned())));
    let params = bursts.iter().map(|of| SearchParams::from(of.params.clone()).to_toml()).collect();
    let mut store = FeatureStore::of_detections(folder, &job.features, params)?;
    store.protect(&sources)?;
    store.check_output(&folder.join(DATABASE_FILE))?;
    // A camera of another size fails before anything is written.
    let choices = sources.iter().map(|source| job.cameras.of_burst(&source.name));
    choices.zip(bursts).map(|(choice, of)| choice.for_images(of.burst.size())).collect::<Result<Vec<_>>>()?;
    let found: Vec<BurstFeatures> =
        sources.iter().zip(bursts).map(|(source, of)| store.keep(source, of, monitor)).collect::<Result<_>>()?;
    let written = |place: usize| {
        let DetectedBurst { burst, params, .. } = bursts[place];
        Ok((found[place].clone(), seen_part(burst, params, monitor)?, None))
    };
    let open = |place: usize| Ok((bursts[place].burst.clone(), bursts[place].params.clone()));
    let report =
        write_database(&store, (job, &matching, &job.pairs), (found.len(), &written, &open), &mut |_| {}, monitor)?;
    store.exported_with = job.words(&report);
    store.begin_writing()?;
    Ok(report)
}

/// A burst of an export: its features, what is seen of its image, and what both were made from if it is not in memory.
type Exported = (BurstFeatures, Seen, Option<Value>);

/// Opens the burst at a place, with the parameters of its search.
type Opening<'a> = &'a dyn Fn(usize) -> Result<(Burst, DetectorParams)>;

/// Bursts of an export: their number, and by place what is exported, and the frames with the search's parameters.
type AllExported<'a> = (usize, &'a dyn Fn(usize) -> Result<Exported>, Opening<'a>);

fn write_database(
    store: &FeatureStore,
    (job, matching, pairs): (&ColmapJob, &MatchParams, &PairSelection),
    (count, exported, open): AllExported<'_>,
    on: &mut dyn FnMut(BurstEvent<'_>),
    monitor: &Monitor,
) -> Result<ColmapReport> {
    let (database, images_folder) = (store.folder.join(DATABASE_FILE), store.folder.join(IMAGES_FOLDER));
    let mut report = ColmapReport { database, images_folder, ..Default::default() };
    store.check_output(&report.database)?;
    write_colmap_database(&report.database.clone(), |database| {
        let (mut blobs, mut seen, mut paired) = (Vec::with_capacity(count), Vec::new(), Vec::new());
        for place in 0..count {
            monitor.check()?;
            let (mut burst, of_burst, key) = exported(place)?;
            // Keypoints and descriptors go to the database; shapes alone stay in memory.
            blobs.push(std::mem::take(&mut burst.blobs));
            seen.push(of_burst);
            let choice = job.cameras.of_burst(&burst.name);
            add_burst(database, &burst, choice, &mut report)?;
            let camera = choice.known().cloned();
            paired.push(PairedImage { name: burst.image_name, features: burst.keypoints.len(), camera, key });
        }
        report.known_camera = report.cameras.iter().all(|camera| camera.known);
        // Chosen only here: features may decide, and are all in the database now.
        let descriptors = |place: usize| -> Result<Vec<Descriptor>> { Ok(database.features(place as u32 + 1)?.1) };
        let pairs = &pairs.pairs_by(count, descriptors, monitor)?;
        on(BurstEvent::Matching(pairs.len()));
        let kept = KeptPairs::of(store, matching, &paired);
        let resumed = match_all(database, (pairs, &blobs), matching, (&kept, open), monitor)?;
        let waiting = add_pairs(database, pairs, matching, (&kept, &resumed), &mut report)?;
        match matching.aligns() {
            true => align_all(database, (pairs, waiting), (&blobs, seen), &kept, &mut report, monitor),
            false => Ok(()),
        }
    })?;
    report.joined = Joined::of(&report.images, &report.pairs);
    report.no_start = report.why_no_start();
    Ok(report)
}

fn add_burst(
    database: &mut DatabaseWriter<'_>,
    burst: &BurstFeatures,
    choice: &CameraChoice,
    report: &mut ColmapReport,
) -> Result<()> {
    let (camera, known) = (choice.for_images(burst.size)?, choice.known().is_some());
    // One camera for all images that have an equal one: the mapper then refines one lens, not many.
    let equal = report.cameras.iter().position(|of| of.camera == camera && of.known == known);
    let place = equal.unwrap_or(report.cameras.len());
    if equal.is_none() {
        let Camera { model, width, height, ref params } = camera;
        database.add_camera(model.id(), (width, height), params, known)?;
        report.cameras.push(CameraReport { camera, known, from: Vec::new(), images: Vec::new() });
    }
    let id = database.add_image(&burst.image_name, place as u32 + 1, &burst.keypoints, &burst.descriptors)?;
    let of = &mut report.cameras[place];
    of.images.push(id);
    of.from.extend(choice.source().filter(|from| !of.from.contains(from)).cloned());
    let (name, image, features) = (burst.name.clone(), burst.image_name.clone(), burst.keypoints.len());
    let (frames, resumed) = (burst.frames, burst.resumed);
    report.images.push(ImageReport { id, burst: name, image, frames, features, resumed });
    Ok(())
}

struct InDatabase<'a, 'b> {
    database: &'a DatabaseWriter<'b>,
    blobs: &'a [Vec<Blob>],
    open: Opening<'a>,
}

impl PairSource<Error> for InDatabase<'_, '_> {
    fn features(&mut self, index: usize) -> Result<Option<BurstSide>> {
        let (keypoints, descriptors) = self.database.features(index as u32 + 1)?;
        Ok(Some(BurstSide::new(&keypoints, descriptors, self.blobs[index].clone())))
    }

    fn burst(&mut self, index: usize) -> Result<(Burst, DetectorParams)> {
        (self.open)(index)
    }
}

/// Matches the pairs that are not kept yet, and keeps each. Returns for each pair whether it was kept before.
fn match_all(
    database: &DatabaseWriter<'_>,
    (pairs, blobs): (&[(usize, usize)], &[Vec<Blob>]),
    matching: &MatchParams,
    (kept, open): (&KeptPairs<'_>, Opening<'_>),
    monitor: &Monitor,
) -> Result<Vec<bool>> {
    let has = |pair: &(usize, usize)| Ok(monitor.check().map(|()| kept.has(*pair))?);
    let resumed: Vec<bool> = pairs.par_iter().map(has).collect::<Result<_>>()?;
    let missing = pairs.iter().zip(&resumed).filter(|(_, resumed)| !**resumed).map(|(pair, _)| *pair);
    let missing: Vec<(usize, usize)> = missing.collect();
    let keep = |pair, sides: [MatchSide<'_>; 2]| {
        let (params, silent) = (kept.matching(pair), monitor.silent());
        let found = match_features(sides, &params, &silent)?;
        kept.keep(pair, PairFound::of(&found, beside(sides, &found, &params, &silent)?))
    };
    let mut source = InDatabase { database, blobs, open };
    for_pairs::<Error, ()>(&missing, matching, &mut source, (&keep, &mut |_| Ok(())), monitor)?;
    monitor.check()?;
    Ok(resumed)
}

/// Adds all pairs in their order, so that the database has the same bytes whether they were kept or matched now.
/// Returns those whose geometries wait until all pairs agree on the places.
fn add_pairs(
    database: &mut DatabaseWriter<'_>,
    pairs: &[(usize, usize)],
    matching: &MatchParams,
    (kept, resumed): (&KeptPairs<'_>, &[bool]),
    report: &mut ColmapReport,
) -> Result<Vec<Waiting>> {
    let mut waiting = Vec::new();
    for (&images, &resumed) in pairs.iter().zip(resumed) {
        let PairFound { matches, inliers, beside, model, refused } = kept.take(images)?;
        let [a, b] = [&report.images[images.0], &report.images[images.1]];
        let (keypoints_a, keypoints_b, found) = (a.features, b.features, Some(inliers.len()));
        let putative = matches.len();
        let counts = MatchCounts { keypoints_a, keypoints_b, putative, inliers: found, refused, not_mutual: None };
        let [a, b] = [a.id, b.id];
        report.pairs.push(PairReport { ids: [a, b], resumed, counts });
        // COLMAP also has no row for a pair without a match.
        if matches.is_empty() {
            continue;
        }
        database.add_matches(a, b, &matches)?;
        if matching.aligns() && model.is_some() {
            waiting.push(Waiting { images, model, inliers, beside });
            continue;
        }
        let places =
            |id| Ok::<_, Error>(database.features(id)?.0.iter().map(ColmapKeypoint::pos_image).collect::<Vec<_>>());
        let (of_a, of_b) = if model.is_some() { (places(a)?, places(b)?) } else { Default::default() };
        let agreed: Vec<Inlier> = inliers.iter().map(|(m, _)| *m).collect();
        database.add_geometry(a, b, &database_geometry([&of_a, &of_b], &agreed, model.as_ref()))?;
    }
    Ok(waiting)
}

/// Aligns the places of all images, and adds the geometries of the pairs at these, with the matches beside inliers and
/// those that others imply.
fn align_all(
    database: &mut DatabaseWriter<'_>,
    (pairs, mut waiting): (&[(usize, usize)], Vec<Waiting>),
    (blobs, seen): (&[Vec<Blob>], Vec<Seen>),
    kept: &KeptPairs<'_>,
    report: &mut ColmapReport,
    monitor: &Monitor,
) -> Result<()> {
    let ids: Vec<u32> = report.images.iter().map(|image| image.id).collect();
    let mut alignment = Alignment::default();
    for ((&id, blobs), seen) in ids.iter().zip(blobs).zip(seen) {
        let (keypoints, _) = database.features(id)?;
        alignment.add_image(keypoints.iter().map(ColmapKeypoint::pos_image).collect(), blobs, Some(seen));
    }
    let mut joint = Joint::of(&mut alignment, &waiting, kept, monitor)?;
    if joint.add_beside(&mut waiting) {
        joint = Joint::of(&mut alignment, &waiting, kept, monitor)?;
    }
    let Joint { aligned, mut found } = joint;
    report.moved = Some(aligned.moved);
    // Features move first: geometries are of the places in the database.
    for (&id, places) in ids.iter().zip(&aligned.places) {
        database.move_features(id, places)?;
    }
    let is_beside = |inlier: &&Inlier| inlier.rank >= Inlier::RANK_BESIDE;
    report.beside = found.values().map(|of| of.inliers.iter().filter(is_beside).count()).sum();
    let tracks = Tracks::of(&aligned.place_of, found.iter().map(|(images, of)| (*images, &of.inliers[..])));
    let implied = |&images: &(usize, usize)| {
        monitor.check()?;
        let implied = tracks.implied(images);
        let of_pair = found.get(&images);
        let (former, own) = of_pair.map_or((None, &[][..]), |of| (of.model.as_ref(), &of.inliers[..]));
        if implied.is_empty() {
            return Ok(None);
        }
        let more = aligned.with_implied(images, former, [own, &implied], &kept.matching(images), &monitor.silent())?;
        Ok(more.map(|more| (images, more)))
    };
    // A pair without a geometry of its own may get one by them.
    let implied: Vec<_> = pairs.par_iter().map(implied).collect::<Result<_>>()?;
    for (images, (model, [own, implied])) in implied.into_iter().flatten() {
        report.implied += implied.len();
        let inliers = [own, implied].concat();
        found.insert(images, Agreed { model: Some(model), confirmed: inliers.len(), inliers });
    }
    for (images, Agreed { model, inliers, .. }) in found {
        let pair @ [a, b] = [ids[images.0], ids[images.1]];
        let index = report.pairs.binary_search_by_key(&pair, |of| of.ids).expect("all pairs are reported");
        // Of these descriptors say nothing, but an inlier is a match.
        let mut matches = database.matches(a, b)?;
        let known: HashSet<[u32; 2]> = matches.iter().copied().collect();
        matches.extend(inliers.iter().map(|m| [m.a, m.b]).filter(|m| !known.contains(m)));
        if matches.len() > known.len() {
            database.add_matches(a, b, &matches)?;
        }
        let counts = &mut report.pairs[index].counts;
        counts.putative = matches.len();
        counts.inliers = Some(inliers.len());
        counts.refused =
            if model.is_none() { Some(Refusal::Pictures) } else { inliers.is_empty().then_some(Refusal::Tracks) };
        let places = [&aligned.places[images.0][..], &aligned.places[images.1]];
        database.add_geometry(a, b, &database_geometry(places, &inliers, model.as_ref()))?;
    }
    Ok(())
}

/// Reads images, pairs with a match, and what they join from `folder`, which an export of some of `bursts` wrote.
/// Numbers of frames are 0; a burst that is not among `bursts` has the name of its picture.
///
/// # Errors
/// One of the parameter `pairs-of`: a folder that no export wrote, a damaged database, or one of other bursts alone.
pub fn read_exported(folder: &Path, bursts: &[&str]) -> Result<ColmapReport> {
    let strange = |why: &str| {
        let problem = format!("{} is no folder that colmap wrote from these bursts: {why}", folder.display());
        Error::param("pairs-of", problem, "give the --out of a `burstscope colmap` of them")
    };
    if !has_mark(&folder.join(DATABASE_FILE), false) {
        return Err(strange("it has no database.db of Burstscope's"));
    }
    let known: HashMap<String, &str> = bursts.iter().map(|name| (safe_file_name(name) + ".png", *name)).collect();
    let report =
        read_database(folder, &known).map_err(|error| strange(&format!("its database.db is damaged ({error})")))?;
    let is_of_them = report.images.iter().any(|image| known.contains_key(&image.image));
    if is_of_them { Ok(report) } else { Err(strange("it holds none of them")) }
}

fn read_database(folder: &Path, known: &HashMap<String, &str>) -> rusqlite::Result<ColmapReport> {
    let database = folder.join(DATABASE_FILE);
    let connection = open_database(&database)?;
    let image = |row: &Row<'_>| {
        let (id, image, features): (u32, String, u32) = row.try_into()?;
        let burst = known.get(&image).copied().unwrap_or(image.trim_end_matches(".png")).to_owned();
        Ok(ImageReport { id, burst, image, frames: 0, features: features as usize, resumed: true })
    };
    let images = "SELECT image_id, name, rows FROM images JOIN keypoints USING (image_id) ORDER BY image_id";
    let images: Vec<_> = connection.prepare(images)?.query_map([], image)?.collect::<rusqlite::Result<_>>()?;
    let pair = |row: &Row<'_>| {
        let (a, b): (String, String) = row.try_into()?;
        let count = |column: usize| row.get::<_, u32>(column).map(|count| count as usize);
        let (putative, inliers) = (count(6)?, count(7)?);
        let file = || pairs_folder(folder).join(a).join(format!("{b}.pair"));
        let refused = match (inliers, row.get::<_, u32>(8)?) {
            (1.., _) => None,
            // A geometry without inliers.
            (0, kind) if kind > GeometryKind::Degenerate as u32 => Some(Refusal::Tracks),
            _ => why_refused(&file(), putative),
        };
        let (keypoints_a, keypoints_b, inliers) = (count(4)?, count(5)?, Some(inliers));
        let counts = MatchCounts { keypoints_a, keypoints_b, putative, inliers, refused, not_mutual: None };
        Ok(PairReport { ids: [row.get(2)?, row.get(3)?], resumed: true, counts })
    };
    let pairs =
        "SELECT a.name, b.name, a.image_id, b.image_id, in_a.rows, in_b.rows, matches.rows, coalesce(found.rows, 0),
        coalesce(found.config, 0)
        FROM matches LEFT JOIN two_view_geometries AS found USING (pair_id)
        JOIN images AS a ON a.image_id = pair_id / 2147483647 JOIN keypoints AS in_a ON in_a.image_id = a.image_id
        JOIN images AS b ON b.image_id = pair_id % 2147483647 JOIN keypoints AS in_b ON in_b.image_id = b.image_id
        ORDER BY pair_id";
    let pairs: Vec<_> = connection.prepare(pairs)?.query_map([], pair)?.collect::<rusqlite::Result<_>>()?;
    Ok(ColmapReport { joined: Joined::of(&images, &pairs), database, images, pairs, ..ColmapReport::default() })
}

fn check_enough(bursts: usize) -> Result<()> {
    if bursts > 1 {
        return Ok(());
    }
    let have = if bursts == 1 { "1 burst has".into() } else { format!("{bursts} bursts have") };
    let remedy = "name a folder of bursts, or cut a long sequence with --burst-length";
    Err(Error::new(ErrorKind::Failed, format!("{have} features, and matching needs two or more"), remedy))
}

impl ColmapJob {
    /// Options of matching, pairs, cameras and pictures, as the manifest has them, with the cameras of the images.
    fn words(&self, report: &ColmapReport) -> Value {
        let camera = match &self.cameras.rest {
            CameraChoice::Known(camera) | CameraChoice::Own(camera, _) => camera.to_string(),
            CameraChoice::Guessed(model) => format!("guessed {}", model.name()),
        };
        // As text, like the options of the search.
        let (matching, pairs) = (toml::to_string(&self.matching).ok(), self.pairs.to_string());
        let (cameras, images) = (&report.cameras, self.features.images);
        json!({ "matching": matching, "pairs": pairs, "camera": camera, "cameras": cameras, "images": images })
    }

    fn verified_matching(&self) -> Result<MatchParams> {
        // A guessed focal length is too uncertain for an essential matrix.
        let matching = MatchParams { camera: self.cameras.known().next().cloned(), ..self.matching.clone() };
        matching.validate()?;
        self.cameras.known().try_for_each(|camera| camera.validate(doc::CAMERA.name))?;
        if matching.geometry == Geometry::None {
            return Err(Error::param(
                doc::GEOMETRY.name,
                "COLMAP's mapper takes verified matches only",
                "give fundamental, essential or homography",
            ));
        }
        Ok(matching)
    }
}

fn database_geometry([a, b]: [&[[f64; 2]]; 2], inliers: &[Inlier], model: Option<&TwoViewModel>) -> DatabaseGeometry {
    let Some(model) = model else { return DatabaseGeometry::default() };
    let kind = match model {
        TwoViewModel::Fundamental { .. } => GeometryKind::Uncalibrated,
        TwoViewModel::Essential { .. } => GeometryKind::Calibrated,
        TwoViewModel::Homography { .. } => GeometryKind::PlanarOrPanoramic,
    };
    let places: Vec<([f64; 2], [f64; 2])> = inliers.iter().map(|m| (a[m.a as usize], b[m.b as usize])).collect();
    // E alone leaves four poses; the inliers decide.
    let pose = model.relative_pose(&places).filter(|(_, in_front)| *in_front > 0);
    let b_from_a = pose.map(|(pose, _)| {
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(pose.rotation));
        Isometry3::from_parts(Translation3::from(pose.translation), rotation)
    });
    let inliers = inliers.iter().map(|m| [m.a, m.b]).collect();
    DatabaseGeometry { kind, inliers, matrix: Some(*model.matrix()), b_from_a }
}
