//! The features of each burst of a dataset: found once, stored in files, and read from there the next time.

use super::kept::{
    BurstRecord, DETECTOR_KEY, KeptBurst, NotKept, check_folder, detector_text, differences, write_manifest,
};
use super::picture::{ImageKind, write_picture};
use super::stamp::{Comparison, FileStamp};
use super::{CameraChoice, DatasetError};
use crate::burst::{Burst, BurstFiles, OpenError, OpenOptions, files_at};
use crate::detect::{Searched, check_memory, search};
use crate::detector::{Descriptor, SearchParams, SlopeFinding};
use crate::export::{
    ColmapKeypoint, ExportError, MadeFrom, OpenedFiles, OutputRules, Overwrite, RECORDS_FOLDER, Record, Records,
    parse_colmap, safe_file_name, write_colmap_keypoints,
};
use crate::files::lock::FolderLock;
use crate::files::mark::{Checksum, Kind};
use crate::files::unfinished::remove_abandoned;
use crate::monitor::Monitor;
use serde_json::{Value, json};
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
    /// Positions, scales and orientations, strongest first.
    pub keypoints: Vec<ColmapKeypoint>,
    /// Descriptor of each keypoint.
    pub descriptors: Vec<Descriptor>,
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
pub struct FeatureJob {
    /// Parameters of the detector, and the choice of slopes.
    pub detector: SearchParams,
    /// Options for opening bursts.
    pub open: OpenOptions,
    /// Kind of picture that represents a burst.
    pub images: ImageKind,
}

/// Folder of pictures in the dataset's folder.
pub const IMAGES_FOLDER: &str = "images";
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
    Failed(usize, &'a DatasetError),
    /// All bursts are finished, and so many pairs are matched.
    Matching(usize),
}

/// The files of a dataset, with the state of its bursts.
#[derive(Debug)]
pub struct FeatureStore {
    folder: PathBuf,
    job: FeatureJob,
    /// Program and settings with which features are found now.
    made_with: MadeFrom,
    /// Comparison of frames with those of finished bursts.
    comparison: Comparison,
    /// Files that were opened beside frames and calibration, such as parameters.
    opened: Vec<PathBuf>,
    rules: OutputRules,
    /// Lock of the folder, taken with the first write.
    lock: Option<FolderLock>,
}

impl FeatureStore {
    /// Opens the dataset in `folder`, existing or new. Nothing is written.
    ///
    /// # Errors
    /// [`DatasetError::Occupied`] when the folder holds other files, [`DatasetError::Open`] when the bias or flat frame
    /// cannot be read.
    pub fn open(folder: &Path, job: &FeatureJob) -> Result<Self, DatasetError> {
        let contents = |path: &Option<PathBuf>| -> Result<Vec<Value>, DatasetError> {
            let stamps = FileStamp::with_checksums(&calibration_files(path)?, &Monitor::default())?;
            Ok(stamps.iter().map(FileStamp::content).collect())
        };
        let settings = json!({
            // Through text, because that is the file's form: a number may look different as a value.
            DETECTOR_KEY: job.detector.to_toml(),
            "bias": contents(&job.open.bias)?,
            "full_scale": job.open.full_scale,
            "flat": contents(&job.open.flat)?,
            "black_level": job.open.black_level,
            "raw_colour": job.open.raw_colour,
            "linearise": job.open.linearise,
            "accept_damaged": job.open.accept_damaged,
        });
        check_folder(folder, &[IMAGES_FOLDER, FEATURES_FOLDER, RECORDS_FOLDER])?;
        Ok(Self {
            folder: folder.into(),
            job: job.clone(),
            made_with: MadeFrom::new(settings),
            comparison: Comparison::default(),
            opened: Vec::new(),
            rules: OutputRules::default(),
            lock: None,
        })
    }

    /// This store, which also never writes over the files `opened`.
    pub fn and_opened(self, opened: Vec<PathBuf>) -> Self {
        Self { opened, ..self }
    }

    /// This store with another `comparison` of frames with those of finished bursts.
    pub fn comparing(self, comparison: Comparison) -> Self {
        Self { comparison, ..self }
    }

    /// The store of another folder, for the same job.
    pub(super) fn like(&self, folder: &Path) -> Self {
        let (job, made_with) = (self.job.clone(), self.made_with.clone());
        let (opened, rules) = (Vec::new(), OutputRules::default());
        Self { folder: folder.into(), job, made_with, comparison: self.comparison, opened, rules, lock: None }
    }

    pub(super) fn records(&self) -> Records {
        Records::of(&self.folder)
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The parameters with which the features in `folder` were found; `None` where there are none, or where another
    /// version of the program or another revision of the detector found them: with the same parameters this one would
    /// find other features.
    pub fn params_in(folder: &Path) -> Option<SearchParams> {
        SearchParams::from_toml(&detector_text(folder)?).ok()
    }

    /// Ensures, now and with every later write, that no frame of `bursts`, no bias or flat frame, no other opened file
    /// and no file of others is overwritten.
    ///
    /// # Errors
    /// [`ExportError::Input`] for an opened file in the place of an output file, [`ExportError::Link`] for a link,
    /// [`ExportError::InTheWay`] for a file of others.
    pub fn protect(&mut self, bursts: &[BurstFiles]) -> Result<(), DatasetError> {
        let of_bursts = bursts.iter().flat_map(|burst| burst.files().unwrap_or_else(|_| burst.paths.clone()));
        let calibration =
            [&self.job.open.bias, &self.job.open.flat].map(|path| calibration_files(path).unwrap_or_default());
        let settings = self.opened.iter().cloned();
        let inputs = OpenedFiles::of(of_bursts.chain(calibration.into_iter().flatten()).chain(settings));
        self.rules = OutputRules::new(inputs, Overwrite::Refuse);
        for image_name in bursts.iter().map(image_name) {
            for file in [self.feature_file(&image_name), self.picture_file(&image_name)] {
                self.check_output(&file)?;
            }
        }
        self.check_output(&self.folder.join(Kind::Dataset.file()))
    }

    /// Checks whether `file` of the dataset's folder may be written; errors as of [`Self::protect`].
    pub(super) fn check_output(&self, file: &Path) -> Result<(), DatasetError> {
        Ok(self.rules.check_own(file, &[])?)
    }

    /// The numbers of `source` if it is finished, judged without reading its frames or its features.
    pub fn finished(&self, source: &BurstFiles) -> Option<FinishedBurst> {
        let files = source.files().ok()?;
        let KeptBurst { features, content, seconds, .. } =
            self.record(source, &files, Comparison::Glance, &Monitor::default()).ok()?.of;
        let there = content.is_as_long_as(&self.feature_file(&image_name(source)));
        there.then_some(FinishedBurst { features, seconds })
    }

    /// Reads the features of `source` from its files if it is finished.
    ///
    /// # Errors
    /// The reason why they are not used.
    pub fn kept(&self, source: &BurstFiles, monitor: &Monitor) -> Result<BurstFeatures, NotKept> {
        let files = source.files().map_err(DatasetError::from)?;
        Ok(self.kept_with_record(source, &files, monitor)?.0)
    }

    fn kept_with_record(
        &self,
        source: &BurstFiles,
        files: &[PathBuf],
        monitor: &Monitor,
    ) -> Result<(BurstFeatures, BurstRecord), NotKept> {
        let record = self.record(source, files, self.comparison, monitor)?;
        let kept = self.read(source, &record.of)?;
        Ok((kept, record))
    }

    /// Reads the features that this store has found or kept in this run. The frames are not compared again.
    ///
    /// # Errors
    /// [`ExportError::Read`] when the file of features was altered meanwhile.
    #[cfg(feature = "colmap")]
    pub(super) fn written(&self, source: &BurstFiles) -> Result<BurstFeatures, DatasetError> {
        let image_name = image_name(source);
        let record = self.records().read(&image_name).filter(|record| record.made_from == self.made_with);
        let read = record.ok_or(NotKept::NoRecord).and_then(|record| self.read(source, &record.of));
        read.map_err(|reason| {
            ExportError::Read { path: self.feature_file(&image_name), reason: reason.to_string() }.into()
        })
    }

    fn read(&self, source: &BurstFiles, record: &KeptBurst) -> Result<BurstFeatures, NotKept> {
        let image_name = image_name(source);
        let path = self.feature_file(&image_name);
        // A file of another length was altered; it is not read.
        let bytes = record.content.is_as_long_as(&path).then(|| std::fs::read(&path).ok()).flatten();
        let bytes = bytes.filter(|bytes| Checksum::of(bytes) == record.content).ok_or(NotKept::Altered)?;
        let text = String::from_utf8(bytes).map_err(|_| NotKept::Altered)?;
        let (keypoints, descriptors) = parse_colmap(&path, &text).map_err(|_| NotKept::Altered)?;
        if keypoints.len() != record.features {
            return Err(NotKept::Altered);
        }
        let (name, size, seconds) = (source.name.clone(), record.size, record.seconds);
        Ok(BurstFeatures { name, image_name, size, keypoints, descriptors, resumed: true, slopes: None, seconds })
    }

    /// The features of `source`: from its files if it is finished, otherwise found now and written with its picture.
    ///
    /// # Errors
    /// [`DatasetError`]; finished bursts stay finished.
    pub fn features(
        &mut self,
        source: &BurstFiles,
        camera: &CameraChoice,
        monitor: &Monitor,
    ) -> Result<BurstFeatures, DatasetError> {
        let files = source.files()?;
        match self.kept_with_record(source, &files, monitor) {
            Ok((kept, record)) => {
                camera.for_images(kept.size)?;
                self.complete(source, &files, record, monitor)?;
                Ok(kept)
            }
            Err(NotKept::Failed(error @ DatasetError::Cancelled(_))) => Err(error),
            Err(_) => self.make(source, &files, camera, monitor),
        }
    }

    fn make(
        &mut self,
        source: &BurstFiles,
        files: &[PathBuf],
        camera: &CameraChoice,
        monitor: &Monitor,
    ) -> Result<BurstFeatures, DatasetError> {
        // Checked before anything is read.
        check_memory(&source.paths, &self.job.open, &self.job.detector)?;
        let stamps = FileStamp::with_checksums(files, monitor)?;
        let (found, burst) = self.find(source, camera, monitor)?;
        self.begin_writing()?;
        let path = self.feature_file(&found.image_name);
        self.check_output(&path)?;
        self.records().remove(&found.image_name)?;
        write_colmap_keypoints(&path, &found.keypoints, &found.descriptors)?;
        let content = Checksum::of_file(&path).map_err(|e| ExportError::write(&path, &e))?;
        let picture_content = self.write_picture_of(&found.image_name, &burst, monitor)?;
        let of = KeptBurst {
            files: stamps,
            size: found.size,
            features: found.keypoints.len(),
            content,
            picture: self.job.images,
            picture_content,
            seconds: found.seconds,
        };
        let record = Record { made_from: self.made_with.clone(), of };
        self.records().write(&found.image_name, &record)?;
        Ok(found)
    }

    /// Writes the missing files of a burst with stored features: the picture, if another kind is requested than was
    /// written, and the record with the new times of frames whose content is unchanged.
    fn complete(
        &mut self,
        source: &BurstFiles,
        files: &[PathBuf],
        Record { made_from, of }: BurstRecord,
        monitor: &Monitor,
    ) -> Result<(), DatasetError> {
        let image_name = image_name(source);
        let picture_file = self.picture_file(&image_name);
        let is_whole = of.picture_content.is_of(&picture_file);
        let stamps = FileStamp::with_times_of(&of.files, files)?;
        let picture_content = if is_whole && of.picture == self.job.images {
            if stamps == of.files {
                return Ok(());
            }
            self.begin_writing()?;
            of.picture_content
        } else {
            let burst = self.burst(source, monitor)?;
            self.begin_writing()?;
            self.write_picture_of(&image_name, &burst, monitor)?
        };
        let of = KeptBurst { files: stamps, picture: self.job.images, picture_content, ..of };
        Ok(self.records().write(&image_name, &Record { made_from, of })?)
    }

    fn write_picture_of(&self, image_name: &str, burst: &Burst, monitor: &Monitor) -> Result<Checksum, DatasetError> {
        let path = self.picture_file(image_name);
        self.check_output(&path)?;
        write_picture(&path, burst, self.job.images, &self.job.detector.detector, monitor)?;
        Ok(Checksum::of_file(&path).map_err(|e| ExportError::write(&path, &e))?)
    }

    /// Before the first write: locks the folder for this process, removes files that a killed run left, and writes the
    /// manifest. Later: checks that the folder is still the locked one.
    ///
    /// # Errors
    /// A folder that another process has locked, or that was removed meanwhile; a file that cannot be written.
    pub(super) fn begin_writing(&mut self) -> Result<(), DatasetError> {
        if let Some(lock) = &self.lock {
            return Ok(lock.check()?);
        }
        let lock = FolderLock::take(&self.folder)?;
        let folders = [IMAGES_FOLDER, FEATURES_FOLDER].map(|name| self.folder.join(name));
        for folder in folders.iter().chain([&self.folder, &self.records().folder().to_path_buf()]) {
            remove_abandoned(folder);
        }
        write_manifest(&self.folder, &self.made_with)?;
        self.lock = Some(lock);
        Ok(())
    }

    /// Finds the features of `source`; returns them with the opened burst.
    fn find(
        &self,
        source: &BurstFiles,
        camera: &CameraChoice,
        monitor: &Monitor,
    ) -> Result<(BurstFeatures, Burst), DatasetError> {
        let started = Instant::now();
        let burst = self.burst(source, monitor)?;
        camera.for_images(burst.size())?;
        let Searched { detection, finding, .. } = search(&burst, &self.job.detector, monitor)?;
        let image_name = image_name(source);
        let keypoints: Vec<ColmapKeypoint> = detection.features.iter().map(ColmapKeypoint::from).collect();
        let found = BurstFeatures {
            name: source.name.clone(),
            image_name,
            size: burst.size(),
            keypoints,
            descriptors: detection.descriptors,
            resumed: false,
            slopes: finding,
            seconds: started.elapsed().as_secs_f64(),
        };
        Ok((found, burst))
    }

    /// The record of `source`, if it was made with the current settings from `files` as they are now.
    fn record(
        &self,
        source: &BurstFiles,
        files: &[PathBuf],
        comparison: Comparison,
        monitor: &Monitor,
    ) -> Result<BurstRecord, NotKept> {
        let record: BurstRecord = self.records().read(&image_name(source)).ok_or(NotKept::NoRecord)?;
        if record.made_from != self.made_with {
            return Err(match record.made_from.is_of_this_program() {
                true => NotKept::OtherOptions(differences(&record.made_from, &self.made_with)),
                false => NotKept::OtherProgram,
            });
        }
        let agree = FileStamp::all_agree(&record.of.files, files, comparison, monitor)?;
        if agree { Ok(record) } else { Err(NotKept::OtherFiles) }
    }

    fn burst(&self, source: &BurstFiles, monitor: &Monitor) -> Result<Burst, DatasetError> {
        Ok(Burst::open_with(&source.paths, &self.job.open, monitor)?)
    }

    /// The path of a feature file; COLMAP's importer looks for the features of `a.png` in `a.png.txt`.
    fn feature_file(&self, image_name: &str) -> PathBuf {
        self.folder.join(FEATURES_FOLDER).join(format!("{image_name}.txt"))
    }

    fn picture_file(&self, image_name: &str) -> PathBuf {
        self.folder.join(IMAGES_FOLDER).join(image_name)
    }
}

/// The files of a bias or flat frame, which may be a folder of them.
fn calibration_files(path: &Option<PathBuf>) -> Result<Vec<PathBuf>, OpenError> {
    match path {
        Some(path) => files_at(std::slice::from_ref(path)),
        None => Ok(Vec::new()),
    }
}

/// The name of the picture of a burst, below the folder of images; also its name in COLMAP.
pub fn image_name(source: &BurstFiles) -> String {
    format!("{}.png", safe_file_name(&source.name))
}

/// Finds the features of all `bursts` in turn; `on` is called with every event. `monitor` receives the progress through
/// all of them.
///
/// # Errors
/// [`DatasetError`] when it concerns all bursts, or the work was cancelled. A burst that cannot be opened is reported
/// as [`BurstEvent::Failed`] and left out.
pub fn detect_all(
    store: &mut FeatureStore,
    bursts: &[BurstFiles],
    camera: &CameraChoice,
    on: &mut dyn FnMut(BurstEvent<'_>),
    monitor: &Monitor,
) -> Result<(), DatasetError> {
    store.job.detector.validate()?;
    store.protect(bursts)?;
    let share = 1.0 / bursts.len().max(1) as f32;
    for (index, source) in bursts.iter().enumerate() {
        on(BurstEvent::Begin(index));
        match store.features(source, camera, &monitor.part(index as f32 * share, share)) {
            Ok(features) => on(BurstEvent::Done(index, &features)),
            Err(error) if error.is_final() => return Err(error),
            Err(error) => on(BurstEvent::Failed(index, &error)),
        }
    }
    Ok(monitor.check()?)
}
