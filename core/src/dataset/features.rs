//! The features of each burst of a dataset: found once, kept in files, and taken from there the next time.

use super::lock::FolderLock;
use super::manifest::{Checksum, DETECTOR_KEY, FileStamp, Manifest, Record};
use super::picture::{ImageKind, write_picture};
use super::{CameraChoice, DatasetError};
use crate::baseline::{Searched, check_memory, search};
use crate::burst::{Burst, BurstSource, OpenOptions, RawColour};
use crate::detector::{Descriptor, SearchParams, SlopeFinding};
use crate::export::{
    ColmapKeypoint, ExportError, parse_colmap, remove_temporary_files, safe_file_name, write_colmap_keypoints,
};
use crate::monitor::Monitor;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The features of one burst, in COLMAP's convention.
#[derive(Debug, Clone, PartialEq)]
pub struct BurstFeatures {
    /// The burst's name.
    pub name: String,
    /// The name of its picture, below the folder of images.
    pub image_name: String,
    /// (columns, rows).
    pub size: (usize, usize),
    /// Places, scales and orientations, strongest first.
    pub keypoints: Vec<ColmapKeypoint>,
    /// A descriptor for each.
    pub descriptors: Vec<Descriptor>,
    /// Whether they were taken from files that an earlier run wrote.
    pub resumed: bool,
    /// What was found of the burst's slopes, if they were to be found and were not found by an earlier run.
    pub slopes: Option<SlopeFinding>,
    /// How long it took to open the burst and find them, seconds; `None` if an earlier version of the program did not
    /// say.
    pub seconds: Option<f64>,
}

impl BurstFeatures {
    /// What is told of a finished burst without its features.
    pub fn summary(&self) -> FinishedBurst {
        FinishedBurst { features: self.keypoints.len(), seconds: self.seconds }
    }
}

/// A finished burst in numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinishedBurst {
    /// Number of features.
    pub features: usize,
    /// How long it took to open the burst and find them, seconds; `None` if an earlier version of the program did not
    /// say.
    pub seconds: Option<f64>,
}

/// How features are found, and what is kept of each burst.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureJob {
    /// The detector's parameters, and how the slopes are chosen.
    pub detector: SearchParams,
    /// How bursts are opened.
    pub open: OpenOptions,
    /// The picture that stands for a burst.
    pub images: ImageKind,
}

/// The folder of pictures in the dataset's folder.
pub const IMAGES_FOLDER: &str = "images";
/// The folder of feature files in the dataset's folder.
pub const FEATURES_FOLDER: &str = "features";

/// What happens to the bursts of a dataset, as it happens.
#[derive(Debug)]
pub enum BurstEvent<'a> {
    /// A burst is begun.
    Begin {
        /// Its place in the dataset, from 0.
        index: usize,
    },
    /// A burst is finished.
    Done {
        /// Its place in the dataset, from 0.
        index: usize,
        /// What was found, now or earlier.
        features: BurstFeatures,
    },
    /// A burst cannot be opened; the others go on.
    Failed {
        /// Its place in the dataset, from 0.
        index: usize,
        /// Why.
        error: &'a DatasetError,
    },
}

/// The files of a dataset: what is finished and what is not.
#[derive(Debug)]
pub struct FeatureStore {
    folder: PathBuf,
    job: FeatureJob,
    /// With what features are found now.
    made_with: Manifest,
    /// Taken when something is written first.
    lock: Option<FolderLock>,
}

impl FeatureStore {
    /// The dataset in `folder`, begun or to begin. Nothing is written.
    ///
    /// # Errors
    /// [`DatasetError::Occupied`] when the folder holds something else, [`DatasetError::Open`] when the bias frame
    /// cannot be looked at.
    pub fn open(folder: &Path, job: &FeatureJob) -> Result<Self, DatasetError> {
        let stamps = |path: &Option<PathBuf>| match path {
            Some(path) => FileStamp::of(&BurstSource { name: String::new(), paths: vec![path.clone()] }.files()?),
            None => Ok(Vec::new()),
        };
        // By way of text, because that is how the file has it: a number may look different as a value.
        let mut settings = Map::new();
        settings.insert(DETECTOR_KEY.to_owned(), Value::String(job.detector.to_toml()));
        settings.insert("bias".to_owned(), json!(stamps(&job.open.bias)?));
        settings.insert("full_scale".to_owned(), json!(job.open.full_scale));
        // Named only where they are asked for, so that folders of before go on.
        if job.open.flat.is_some() {
            settings.insert("flat".to_owned(), json!(stamps(&job.open.flat)?));
        }
        if job.open.black_level.is_some() {
            settings.insert("black_level".to_owned(), json!(job.open.black_level));
        }
        if job.open.raw_colour != RawColour::default() {
            settings.insert("raw_colour".to_owned(), json!(job.open.raw_colour));
        }
        if job.open.linearise {
            settings.insert("linearise".to_owned(), json!(true));
        }
        if job.open.accept_damaged {
            settings.insert("accept_damaged".to_owned(), json!(true));
        }
        Manifest::check_folder(folder)?;
        let made_with = Manifest::new(Value::Object(settings));
        Ok(Self { folder: folder.into(), job: job.clone(), made_with, lock: None })
    }

    /// The files of another folder, for the same job.
    pub(super) fn like(&self, folder: &Path) -> Self {
        Self { folder: folder.into(), job: self.job.clone(), made_with: self.made_with.clone(), lock: None }
    }

    /// The dataset's folder.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The parameters with which the features in `folder` were found; `None` where there are none, or where another
    /// version of the program or another revision of the detector found them: the same parameters would not bring those
    /// back.
    pub fn params_in(folder: &Path) -> Option<SearchParams> {
        SearchParams::from_toml(&Manifest::detector_text(folder)?).ok()
    }

    /// Whether `source` is finished, as far as can be told without reading its features.
    pub fn finished(&self, source: &BurstSource) -> Option<FinishedBurst> {
        let Record { features, content, seconds, .. } = self.record(source)?;
        let there = content.is_as_long_as(&self.feature_file(&image_name(source)));
        there.then_some(FinishedBurst { features, seconds })
    }

    /// The features of `source` if it is finished, from its files.
    pub fn kept(&self, source: &BurstSource) -> Option<BurstFeatures> {
        let Record { size, features, content, seconds, .. } = self.record(source)?;
        let (name, image_name) = (source.name.clone(), image_name(source));
        let path = self.feature_file(&image_name);
        // A file of another length was altered; it is not even read.
        let bytes = content.is_as_long_as(&path).then(|| std::fs::read(&path).ok())??;
        if Checksum::of(&bytes) != content {
            return None;
        }
        let (keypoints, descriptors) = parse_colmap(&path, &String::from_utf8(bytes).ok()?).ok()?;
        let whole = keypoints.len() == features;
        whole.then_some(BurstFeatures {
            name,
            image_name,
            size,
            keypoints,
            descriptors,
            resumed: true,
            slopes: None,
            seconds,
        })
    }

    /// The features of `source`, from its files if it is finished. Otherwise they are found, and written with its
    /// picture.
    ///
    /// # Errors
    /// [`DatasetError`]; what was finished before stays finished.
    pub fn features(
        &mut self,
        source: &BurstSource,
        camera: &CameraChoice,
        monitor: &Monitor,
    ) -> Result<BurstFeatures, DatasetError> {
        let stamps = FileStamp::of(&source.files()?)?;
        let image_name = image_name(source);
        let picture_file = self.folder.join(IMAGES_FOLDER).join(&image_name);
        let (found, opened) = match self.kept(source) {
            Some(kept) => (kept, None),
            None => {
                let (found, burst) = self.find(source, camera, monitor)?;
                (found, Some(burst))
            }
        };
        camera.for_images(found.size)?;
        let same_picture = self.record(source).is_some_and(|record| record.picture == self.job.images);
        if found.resumed && same_picture && picture_file.is_file() {
            return Ok(found);
        }
        self.begin_writing()?;
        let path = self.feature_file(&image_name);
        if opened.is_some() {
            Record::remove(&self.folder, &image_name)?;
            write_colmap_keypoints(&path, &found.keypoints, &found.descriptors)?;
        }
        let content = Checksum::of(&std::fs::read(&path).map_err(|e| ExportError::write(&path, &e))?);
        let burst = match opened {
            Some(burst) => burst,
            None => self.burst(source, monitor)?,
        };
        write_picture(&picture_file, &burst, self.job.images, &self.job.detector.detector, monitor)?;
        let record = Record {
            made_with: self.made_with.clone(),
            files: stamps,
            size: found.size,
            features: found.keypoints.len(),
            content,
            picture: self.job.images,
            seconds: found.seconds,
        };
        record.write(&self.folder, &image_name)?;
        Ok(found)
    }

    /// Before anything is written: takes the folder for this process, clears what a killed run left, and says with what
    /// the dataset is made.
    ///
    /// # Errors
    /// [`DatasetError::Locked`] when another process has the folder, or what cannot be written.
    pub(super) fn begin_writing(&mut self) -> Result<(), DatasetError> {
        if self.lock.is_none() {
            let lock = FolderLock::take(&self.folder)?;
            let folders = [IMAGES_FOLDER, FEATURES_FOLDER].map(|name| self.folder.join(name));
            for folder in folders.iter().chain([&self.folder, &Record::folder(&self.folder)]) {
                remove_temporary_files(folder);
            }
            self.made_with.write(&self.folder)?;
            self.lock = Some(lock);
        }
        Ok(())
    }

    /// Finds the features.
    fn find(
        &self,
        source: &BurstSource,
        camera: &CameraChoice,
        monitor: &Monitor,
    ) -> Result<(BurstFeatures, Burst), DatasetError> {
        let started = Instant::now();
        check_memory(&source.paths, &self.job.open, &self.job.detector)?;
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
            seconds: Some(started.elapsed().as_secs_f64()),
        };
        Ok((found, burst))
    }

    /// The record of `source`, if it was made with what is asked for now from files that are as they were.
    fn record(&self, source: &BurstSource) -> Option<Record> {
        let record = Record::read(&self.folder, &image_name(source))?;
        let stamps = FileStamp::of(&source.files().ok()?).ok()?;
        (record.made_with == self.made_with && record.files == stamps).then_some(record)
    }

    fn burst(&self, source: &BurstSource, monitor: &Monitor) -> Result<Burst, DatasetError> {
        Ok(Burst::open_with(&source.paths, &self.job.open, monitor)?)
    }

    /// COLMAP's importer looks for the features of `a.png` in `a.png.txt`.
    fn feature_file(&self, image_name: &str) -> PathBuf {
        self.folder.join(FEATURES_FOLDER).join(format!("{image_name}.txt"))
    }
}

/// The name of the picture of a burst, below the folder of images; COLMAP calls its camera so.
pub fn image_name(source: &BurstSource) -> String {
    format!("{}.png", safe_file_name(&source.name))
}

/// The features of every one of `bursts` in turn; `on` is handed what was found. `monitor` hears of the progress
/// through all of them.
///
/// # Errors
/// [`DatasetError`] when it concerns all bursts, or it was cancelled. A burst that cannot be opened is told by
/// [`BurstEvent::Failed`] and left out.
pub fn detect_all(
    store: &mut FeatureStore,
    bursts: &[BurstSource],
    camera: &CameraChoice,
    on: &mut dyn FnMut(BurstEvent<'_>),
    monitor: &Monitor,
) -> Result<(), DatasetError> {
    let share = 1.0 / bursts.len().max(1) as f32;
    for (index, source) in bursts.iter().enumerate() {
        on(BurstEvent::Begin { index });
        match store.features(source, camera, &monitor.part(index as f32 * share, share)) {
            Ok(features) => on(BurstEvent::Done { index, features }),
            Err(error) if error.is_final() => return Err(error),
            Err(error) => on(BurstEvent::Failed { index, error: &error }),
        }
    }
    Ok(monitor.check()?)
}
