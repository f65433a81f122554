//! The features of each burst of a dataset: found once, stored in files, and read from there the next time.

use super::blobs::StoredBlobs;
use super::camera::{BurstCameras, CameraChoice};
use super::kept::{
    BurstRecord, KeptBurst, NotKept, calibration_files, detector_text, differences, settings_of, tidy_pairs,
    write_manifest,
};
#[cfg(feature = "colmap")]
use super::pairs::DetectedBurst;
use super::picture::{BurstPicture, ImageKind, burst_plane};
use super::stamp::{Comparison, FileStamp};
use crate::burst::{Burst, BurstFiles, OpenOptions};
use crate::detect::{Searched, check_memory, search};
use crate::detector::slopes::resolve;
use crate::detector::{Descriptor, Detection, DetectorParams, SearchParams, SlopeFinding, open_burst};
use crate::error::{Error, ErrorKind, Result};
use crate::export::{
    ColmapKeypoint, MadeFrom, OpenedFiles, OutputRules, Overwrite, RECORDS_FOLDER, Record, Records, may_begin,
    parse_colmap, safe_file_name, write_colmap_keypoints, write_png,
};
use crate::files::mark::{Checksum, OutputKind, claims};
use crate::files::{lock::FolderLock, read_bytes, unfinished::remove_abandoned};
use crate::{matching::Blob, monitor::Monitor};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The features of one burst, in COLMAP's convention.
#[derive(Debug, Clone, PartialEq)]
pub struct BurstFeatures {
    /// Name of the burst.
    pub name: String,
    /// Name of its picture, below the folder of images.
    pub image_name: String,
    /// Size of its frames (columns, rows).
    pub size: (usize, usize),
    /// Number of frames that were searched.
    pub frames: usize,
    /// Positions, scales and orientations, strongest first.
    pub keypoints: Vec<ColmapKeypoint>,
    /// Descriptor of each keypoint.
    pub descriptors: Vec<Descriptor>,
    /// Scale and motion of each keypoint.
    pub blobs: Vec<Blob>,
    /// Whether they were read from files of an earlier run.
    pub resumed: bool,
    /// Result of finding the burst's slopes, if they were to be found and this run found them.
    pub slopes: Option<SlopeFinding>,
    /// Time taken to open the burst and find its features, seconds.
    pub seconds: f64,
}

impl BurstFeatures {
    /// The numbers of the finished burst, without its features.
    pub fn summary(&self) -> FinishedBurst {
        FinishedBurst { features: self.keypoints.len(), seconds: self.seconds }
    }
}

/// Numbers of a finished burst.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinishedBurst {
    /// Number of features.
    pub features: usize,
    /// Time taken to open the burst and find its features, seconds.
    pub seconds: f64,
}

/// Parameters of finding features, and the kind of picture stored for each burst.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct FeatureJob {
    pub detector: SearchParams,
    pub open: OpenOptions,
    pub images: ImageKind,
}

/// Folder of pictures in the dataset's folder.
pub const IMAGES_FOLDER: &str = "images";
/// Folder of the pictures' masks in the dataset's folder.
pub const MASKS_FOLDER: &str = "masks";
/// Folder of feature files in the dataset's folder.
pub const FEATURES_FOLDER: &str = "features";

/// Event of the work on a dataset; the bursts are named by their indices in it, from 0.
#[derive(Debug)]
pub enum BurstEvent<'a> {
    /// A burst was started.
    Begin(usize),
    /// A burst was finished; its features were found now or earlier.
    Done(usize, &'a BurstFeatures),
    /// A burst cannot be opened; the work continues with the others.
    Failed(usize, &'a Error),
    /// All bursts are finished, and so many pairs are matched.
    Matching(usize),
}

/// The files of a dataset, with the state of its bursts.
#[derive(Debug)]
pub struct FeatureStore {
    pub(super) folder: PathBuf,
    job: FeatureJob,
    made_with: MadeFrom,
    /// Options of the last export into the folder, of which its database is; for the manifest.
    pub(super) exported_with: Value,
    comparison: Comparison,
    /// Files that were opened beside frames and calibration, such as parameters.
    opened: Vec<PathBuf>,
    rules: OutputRules,
    /// Lock of the folder, taken with the first write.
    pub(super) lock: Option<FolderLock>,
}

impl FeatureStore {
    /// Opens the dataset in `folder`, existing or new. Nothing is written.
    ///
    /// # Errors
    /// The folder holds other files, or the bias or flat frame cannot be read.
    pub fn open(folder: &Path, job: &FeatureJob) -> Result<Self> {
        Self::at(folder, job, settings_of(&job.detector, &job.open)?)
    }

    /// Opens the dataset in `folder` for features in memory, found with `params`, one text a burst.
    #[cfg(feature = "colmap")]
    pub(super) fn of_detections(folder: &Path, job: &FeatureJob, params: Vec<String>) -> Result<Self> {
        Self::at(folder, job, serde_json::json!({ "detectors": params }))
    }

    fn at(folder: &Path, job: &FeatureJob, settings: Value) -> Result<Self> {
        if !may_begin(folder, OutputKind::Dataset, &[IMAGES_FOLDER, MASKS_FOLDER, FEATURES_FOLDER, RECORDS_FOLDER])? {
            let problem = "this folder holds files, but no dataset that was begun by this command";
            return Err(Error::new(ErrorKind::InTheWay, problem, "name a new or an empty folder").about(folder));
        }
        Ok(Self::new(folder, job, MadeFrom::new(settings)))
    }

    fn new(folder: &Path, job: &FeatureJob, made_with: MadeFrom) -> Self {
        let before = claims::<MadeFrom>(folder, OutputKind::Dataset);
        let exported_with = before.map_or(Value::Null, |made| made.settings()["export"].clone());
        let (folder, job) = (folder.into(), job.clone());
        let (comparison, opened, rules) = (Comparison::default(), Vec::new(), OutputRules::default());
        Self { folder, job, made_with, exported_with, comparison, opened, rules, lock: None }
    }

    /// This store, which never writes over the files `opened` either.
    pub fn and_opened(self, opened: Vec<PathBuf>) -> Self {
        Self { opened, ..self }
    }

    /// This store with another `comparison` of frames with those of finished bursts.
    pub fn comparing(self, comparison: Comparison) -> Self {
        Self { comparison, ..self }
    }

    pub(super) fn like(&self, folder: &Path) -> Self {
        Self::new(folder, &self.job, self.made_with.clone()).comparing(self.comparison)
    }

    pub(super) fn records(&self) -> Records {
        Records::of(&self.folder)
    }

    /// The parameters with which the features in `folder` were found; `None` where there are none, or where another
    /// version of the program or revision of the detector, which would find other ones, found them.
    pub fn params_in(folder: &Path) -> Option<SearchParams> {
        SearchParams::from_toml(&detector_text(folder)?).ok()
    }

    /// Ensures, now and with every later write, that no opened file and no file of others is overwritten.
    ///
    /// # Errors
    /// An opened file, a link, or a file of others in the place of an output file.
    pub fn protect(&mut self, bursts: &[BurstFiles]) -> Result<()> {
        let of_bursts = bursts.iter().flat_map(|burst| self.files(burst).unwrap_or_else(|_| burst.paths.clone()));
        let of_options = self.job.open.paths().into_iter().map(Some);
        let calibration = of_options.map(|path| calibration_files(&path).unwrap_or_default());
        let settings = self.opened.iter().cloned();
        let inputs = OpenedFiles::of(of_bursts.chain(calibration.flatten()).chain(settings));
        self.rules = OutputRules::new(inputs, Overwrite::Refuse);
        // All outputs are checked before the first burst, so that a refusal comes early.
        for image_name in bursts.iter().map(image_name) {
            for file in [self.feature_file(&image_name), self.picture_file(&image_name)] {
                self.check_output(&file)?;
            }
        }
        self.check_output(&self.folder.join(OutputKind::Dataset.file()))
    }

    /// Checks whether `file` of the dataset's folder may be written; errors as of [`Self::protect`].
    pub(super) fn check_output(&self, file: &Path) -> Result<()> {
        self.rules.check_own(file, &[])
    }

    pub(super) fn open_burst(&self, source: &BurstFiles, monitor: &Monitor) -> Result<(Burst, DetectorParams)> {
        Ok((open_burst(&source.paths, &self.job.open, monitor)?, self.job.detector.at_given()))
    }

    /// The numbers of `source` if it is finished, judged without reading its frames or its features.
    pub fn finished(&self, source: &BurstFiles) -> Option<FinishedBurst> {
        let files = self.files(source).ok()?;
        let KeptBurst { features, content, seconds, .. } =
            self.record(source, &files, Comparison::Glance, &Monitor::default()).ok()?.of;
        let there = content.is_as_long_as(&self.feature_file(&image_name(source)));
        there.then_some(FinishedBurst { features, seconds })
    }

    fn files(&self, source: &BurstFiles) -> Result<Vec<PathBuf>> {
        let mut files = source.files()?;
        let list = self.job.open.list_of_times(&files).filter(|list| list.is_file());
        files.extend(self.job.open.mask_files(&files));
        files.extend(self.job.open.files_of_rotations(&files).into_iter().flatten().filter(|file| file.is_file()));
        files.extend(list);
        Ok(files)
    }

    /// Reads the features of `source` from its files if it is finished.
    pub fn kept(&self, source: &BurstFiles, monitor: &Monitor) -> Result<BurstFeatures, NotKept> {
        Ok(self.kept_with_record(source, &self.files(source)?, monitor)?.0)
    }

    fn kept_with_record(
        &self,
        source: &BurstFiles,
        files: &[PathBuf],
        monitor: &Monitor,
    ) -> Result<(BurstFeatures, BurstRecord), NotKept> {
        let record = self.record(source, files, self.comparison, monitor)?;
        Ok((self.read(source, &record.of)?, record))
    }

    /// Reads the features that this store has found or kept in this run, with the part of the image that is seen, and
    /// what both were made from. The frames are not compared again.
    #[cfg(feature = "colmap")]
    pub(super) fn written(&self, of: &BurstFiles) -> Result<(BurstFeatures, crate::matching::aligned::Seen, Value)> {
        let image_name = image_name(of);
        let record: Option<BurstRecord> = self.records().read(&image_name);
        let record = record.filter(|record| record.made_from == self.made_with).ok_or(NotKept::NoRecord);
        let read = record.and_then(|record| Ok((self.read(of, &record.of)?, record)));
        let (found, record) = read.map_err(|reason| Error::unread_file(&self.feature_file(&image_name), reason))?;
        let key = record.of.key(&record.made_from);
        Ok((found, record.of.seen, key))
    }

    fn read(&self, source: &BurstFiles, record: &KeptBurst) -> Result<BurstFeatures, NotKept> {
        let image_name = image_name(source);
        let path = self.feature_file(&image_name);
        // A file of another length was altered; it is not read.
        let bytes = record.content.is_as_long_as(&path).then(|| read_bytes(&path, u64::MAX).ok()).flatten();
        let bytes = bytes.filter(|bytes| Checksum::of(bytes) == record.content).ok_or(NotKept::Altered)?;
        let text = String::from_utf8(bytes).map_err(|_| NotKept::Altered)?;
        let (keypoints, descriptors) = parse_colmap(&path, &text).map_err(|_| NotKept::Altered)?;
        let blobs = record.blobs.0.clone();
        if keypoints.len() != record.features || blobs.len() != record.features {
            return Err(NotKept::Altered);
        }
        let (name, size, frames, seconds) = (source.name.clone(), record.size, record.frames, record.seconds);
        let (resumed, slopes) = (true, None);
        Ok(BurstFeatures { name, image_name, size, frames, keypoints, descriptors, blobs, resumed, slopes, seconds })
    }

    /// The features of `source`: from its files if it is finished, otherwise found now and written with its picture.
    pub fn features(&mut self, source: &BurstFiles, camera: &CameraChoice, monitor: &Monitor) -> Result<BurstFeatures> {
        let files = self.files(source)?;
        match self.kept_with_record(source, &files, monitor) {
            Ok((kept, record)) => {
                // Also for kept features: the camera may be another one than that of the earlier run.
                camera.for_images(kept.size)?;
                self.complete(source, &files, record, monitor)?;
                Ok(kept)
            }
            Err(NotKept::Failed(error)) if error.is_cancelled() => Err(error),
            Err(_) => self.make(source, &files, camera, monitor),
        }
    }

    fn make(
        &mut self,
        source: &BurstFiles,
        files: &[PathBuf],
        camera: &CameraChoice,
        monitor: &Monitor,
    ) -> Result<BurstFeatures> {
        // Checked before anything is read.
        check_memory(&source.paths, &self.job.open, &self.job.detector, monitor)?;
        // Stamped before the search: a frame that changes meanwhile differs from its stamp.
        let stamps = FileStamp::with_checksums(files, monitor)?;
        let started = Instant::now();
        let burst = open_burst(&source.paths, &self.job.open, monitor)?;
        camera.for_images(burst.size())?;
        let Searched { detection, params, finding: slopes, .. } = search(&burst, &self.job.detector, monitor)?;
        let seconds = started.elapsed().as_secs_f64();
        let found = BurstFeatures { slopes, seconds, ..found_in(source, &burst, &detection) };
        let content = self.write_features(&found)?;
        let picture_content = self.write_picture_of(&found.image_name, &burst, &params, monitor)?;
        let of = KeptBurst {
            files: stamps,
            size: found.size,
            frames: found.frames,
            features: found.keypoints.len(),
            slopes: Some(params.slopes),
            content,
            blobs: StoredBlobs(found.blobs.clone()),
            seen: super::pairs::seen_part(&burst, &self.job.detector.at_given(), monitor)?,
            picture: self.job.images,
            picture_content,
            seconds,
        };
        let record = Record { made_from: self.made_with.clone(), of };
        // Written last: the record claims the files before it.
        self.records().write(&found.image_name, &record)?;
        Ok(found)
    }

    fn write_features(&mut self, found: &BurstFeatures) -> Result<Checksum> {
        self.begin_writing()?;
        let path = self.feature_file(&found.image_name);
        self.check_output(&path)?;
        // Without a record a half-written file counts as none.
        self.records().remove(&found.image_name)?;
        write_colmap_keypoints(&path, &found.keypoints, &found.descriptors)?;
        Checksum::of_file(&path).map_err(|e| Error::unwritten(&path, &e))
    }

    /// Writes features and picture of a burst that was searched elsewhere, without a record: another run searches it.
    #[cfg(feature = "colmap")]
    pub(super) fn keep(
        &mut self,
        source: &BurstFiles,
        of: &DetectedBurst<'_>,
        monitor: &Monitor,
    ) -> Result<BurstFeatures> {
        let found = found_in(source, of.burst, of.detection);
        self.write_features(&found)?;
        self.write_picture_of(&found.image_name, of.burst, of.params, monitor)?;
        Ok(found)
    }

    /// Writes what is missing: the picture, if another kind is requested, and the record with the frames' new times.
    fn complete(
        &mut self,
        source: &BurstFiles,
        files: &[PathBuf],
        Record { made_from, of }: BurstRecord,
        monitor: &Monitor,
    ) -> Result<()> {
        let image_name = image_name(source);
        let picture_file = self.picture_file(&image_name);
        // A picture may have been deleted or edited; the features, which took long, are still right.
        let is_whole = of.picture_content.is_of(&picture_file);
        let stamps = FileStamp::with_times_of(&of.files, files)?;
        let picture_content = if is_whole && of.picture == self.job.images {
            // Nothing is written where nothing changed, and the folder needs no lock.
            if stamps == of.files {
                return Ok(());
            }
            self.begin_writing()?;
            of.picture_content
        } else {
            let burst = open_burst(&source.paths, &self.job.open, monitor)?;
            let params = match of.slopes {
                Some(slopes) => DetectorParams { slopes, ..self.job.detector.at_given() },
                None => resolve(&burst, &self.job.detector, monitor)?.0,
            };
            self.begin_writing()?;
            self.write_picture_of(&image_name, &burst, &params, monitor)?
        };
        let of = KeptBurst { files: stamps, picture: self.job.images, picture_content, ..of };
        self.records().write(&image_name, &Record { made_from, of })
    }

    fn write_picture_of(
        &self,
        image_name: &str,
        burst: &Burst,
        params: &DetectorParams,
        monitor: &Monitor,
    ) -> Result<Checksum> {
        let path = self.picture_file(image_name);
        self.check_output(&path)?;
        let plane = burst_plane(burst, self.job.images, params, monitor)?;
        // COLMAP looks for the mask of `a.png` in `a.png.png`.
        let mask_file = self.folder.join(MASKS_FOLDER).join(format!("{image_name}.png"));
        // The mask of an earlier run is replaced even where nothing is hidden any more.
        if plane.mask().is_some() || mask_file.exists() {
            self.check_output(&mask_file)?;
            write_png(&mask_file, BurstPicture::of_mask(&plane).picture())?;
        }
        write_png(&path, BurstPicture::of(&plane).picture())?;
        Checksum::of_file(&path).map_err(|e| Error::unwritten(&path, &e))
    }

    /// Locks the folder and removes rests of killed runs, or checks the lock, and brings the manifest up to date.
    pub(super) fn begin_writing(&mut self) -> Result<()> {
        if let Some(lock) = &self.lock {
            lock.check()?;
        } else {
            let lock = FolderLock::take(&self.folder)?;
            let folders = [IMAGES_FOLDER, MASKS_FOLDER, FEATURES_FOLDER].map(|name| self.folder.join(name));
            for folder in folders.iter().chain([&self.folder, &self.records().folder().to_path_buf()]) {
                remove_abandoned(folder);
            }
            tidy_pairs(&self.folder)?;
            self.lock = Some(lock);
        }
        let mut settings = self.made_with.settings().clone();
        settings["export"] = self.exported_with.clone();
        write_manifest(&self.folder, &MadeFrom::new(settings))
    }

    fn record(
        &self,
        source: &BurstFiles,
        files: &[PathBuf],
        comparison: Comparison,
        monitor: &Monitor,
    ) -> Result<BurstRecord, NotKept> {
        let record: BurstRecord = self.records().read(&image_name(source)).ok_or(NotKept::NoRecord)?;
        if record.made_from != self.made_with {
            // Of other options the differing ones are named, for the user to set them back.
            return Err(match record.made_from.is_of_this_program() {
                true => NotKept::OtherOptions(differences(&record.made_from, &self.made_with)),
                false => NotKept::OtherProgram,
            });
        }
        // Last, because contents may have to be read.
        let agree = FileStamp::all_agree(&record.of.files, files, comparison, monitor)?;
        if agree { Ok(record) } else { Err(NotKept::OtherFiles) }
    }

    /// COLMAP's importer looks for the features of `a.png` in `a.png.txt`.
    fn feature_file(&self, image_name: &str) -> PathBuf {
        self.folder.join(FEATURES_FOLDER).join(format!("{image_name}.txt"))
    }

    fn picture_file(&self, image_name: &str) -> PathBuf {
        self.folder.join(IMAGES_FOLDER).join(image_name)
    }
}

fn found_in(source: &BurstFiles, burst: &Burst, detection: &Detection) -> BurstFeatures {
    let (name, image_name, size) = (source.name.clone(), image_name(source), burst.size());
    let keypoints = detection.features.iter().map(ColmapKeypoint::from).collect();
    let blobs = detection.features.iter().map(Blob::from).collect();
    let (frames, resumed, slopes, seconds) = (detection.frames_used.len(), false, None, 0.0);
    let descriptors = detection.descriptors.clone();
    BurstFeatures { name, image_name, size, frames, keypoints, descriptors, blobs, resumed, slopes, seconds }
}

/// Whether the other bursts cannot continue. A parameter error after the first checks concerns one burst.
fn concerns_all(kind: ErrorKind) -> bool {
    use ErrorKind::{Cancelled, Failed, InTheWay, Locked, Refused, Unwritten};
    matches!(kind, Cancelled | Unwritten | Refused | InTheWay | Locked | Failed)
}

/// The name of the picture of a burst, below the folder of images; also its name in COLMAP.
pub fn image_name(source: &BurstFiles) -> String {
    format!("{}.png", safe_file_name(&source.name))
}

/// Finds the features of all `bursts` in turn; `on` is called with every event.
///
/// # Errors
/// One that concerns all bursts, or cancellation. Other bursts are reported as [`BurstEvent::Failed`] and left out.
pub fn detect_all(
    store: &mut FeatureStore,
    bursts: &[BurstFiles],
    cameras: &BurstCameras,
    on: &mut dyn FnMut(BurstEvent<'_>),
    monitor: &Monitor,
) -> Result<()> {
    store.job.detector.validate()?;
    store.job.images.check(store.job.detector.method)?;
    // Before the first burst: a refusal after hours of search would lose them.
    store.protect(bursts)?;
    let share = 1.0 / bursts.len().max(1) as f32;
    for (index, source) in bursts.iter().enumerate() {
        on(BurstEvent::Begin(index));
        let camera = cameras.of_burst(&source.name);
        match store.features(source, camera, &monitor.part(index as f32 * share, share)) {
            Ok(features) => on(BurstEvent::Done(index, &features)),
            // A full disk, say, would fail for every burst.
            Err(error) if concerns_all(error.kind) => return Err(error),
            Err(error) => on(BurstEvent::Failed(index, &error)),
        }
    }
    Ok(monitor.check()?)
}
