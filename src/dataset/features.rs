//! The features of each burst of a dataset: found once, kept in files, and taken from there the next time.

use super::manifest::{FileStamp, Finished, Manifest};
use super::picture::{ImageKind, write_picture};
use super::{CameraChoice, DatasetError};
use crate::baseline::detect;
use crate::burst::{Burst, BurstSource, OpenOptions};
use crate::detector::{Descriptor, DetectorParams};
use crate::export::{ColmapKeypoint, read_colmap, safe_file_name, write_colmap_keypoints};
use crate::monitor::Monitor;
use serde_json::json;
use std::path::{Path, PathBuf};

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
}

/// How features are found, and what is kept of each burst.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureJob {
    /// The detector's parameters.
    pub detector: DetectorParams,
    /// How bursts are opened.
    pub open: OpenOptions,
    /// The picture that stands for a burst.
    pub images: ImageKind,
}

/// The folder of pictures in the dataset's folder.
pub const IMAGES_FOLDER: &str = "images";
/// The folder of feature files in the dataset's folder.
pub const FEATURES_FOLDER: &str = "features";

/// The files of a dataset: what is finished and what is not.
pub(super) struct Store<'a> {
    folder: &'a Path,
    job: &'a FeatureJob,
    manifest: Manifest,
}

impl<'a> Store<'a> {
    /// The dataset in `folder`, begun or to begin.
    ///
    /// # Errors
    /// [`DatasetError::Occupied`] when the folder holds something else, [`DatasetError::Open`] when the bias frame cannot be looked at.
    pub(super) fn open(folder: &'a Path, job: &'a FeatureJob) -> Result<Self, DatasetError> {
        let bias = match &job.open.bias {
            Some(path) => FileStamp::of(&BurstSource { name: String::new(), paths: vec![path.clone()] }.files()?)?,
            None => Vec::new(),
        };
        // By way of text, because that is how the file has it: a number may look different as a value.
        let settings = json!({ "detector": job.detector.to_toml(), "bias": bias, "full_scale": job.open.full_scale });
        Ok(Self { folder, job, manifest: Manifest::read(folder, settings)? })
    }

    /// The features of `source`, from its files if it is finished. Otherwise they are found, and written with its picture.
    ///
    /// # Errors
    /// [`DatasetError`]; what was finished before stays finished.
    pub(super) fn features(
        &mut self,
        source: &BurstSource,
        camera: &CameraChoice,
        monitor: &Monitor,
    ) -> Result<BurstFeatures, DatasetError> {
        let image_name = format!("{}.png", safe_file_name(&source.name));
        let stamps = FileStamp::of(&source.files()?)?;
        let feature_file = self.feature_file(&image_name);
        let picture_file = self.folder.join(IMAGES_FOLDER).join(&image_name);
        let name = source.name.clone();
        let mut opened: Option<Burst> = None;
        let earlier = self.manifest.bursts.get(&source.name).filter(|f| f.files == stamps).cloned();
        let kept = earlier.as_ref().and_then(|finished| {
            let (keypoints, descriptors) = read_colmap(&feature_file).ok()?;
            (keypoints.len() == finished.features).then_some((finished.size, keypoints, descriptors))
        });
        let resumed = kept.is_some();
        let (size, keypoints, descriptors) = match kept {
            Some(kept) => kept,
            None => {
                let burst = self.burst(source, monitor)?;
                camera.for_images(burst.size())?;
                let detection = detect(&burst, &self.job.detector, monitor)?;
                let keypoints: Vec<ColmapKeypoint> = detection.features.iter().map(ColmapKeypoint::from).collect();
                write_colmap_keypoints(&feature_file, &keypoints, &detection.descriptors)?;
                let size = burst.size();
                opened = Some(burst);
                (size, keypoints, detection.descriptors)
            }
        };
        camera.for_images(size)?;
        let has_picture = resumed && earlier.is_some_and(|e| e.picture == self.job.images) && picture_file.is_file();
        if !has_picture {
            let burst = match opened {
                Some(burst) => burst,
                None => self.burst(source, monitor)?,
            };
            write_picture(&picture_file, &burst, self.job.images, &self.job.detector, monitor)?;
        }
        if !(resumed && has_picture) {
            let finished = Finished { files: stamps, size, features: keypoints.len(), picture: self.job.images };
            self.manifest.bursts.insert(name.clone(), finished);
            self.manifest.write(self.folder)?;
        }
        Ok(BurstFeatures { name, image_name, size, keypoints, descriptors, resumed })
    }

    fn burst(&self, source: &BurstSource, monitor: &Monitor) -> Result<Burst, DatasetError> {
        Ok(Burst::open_with(&source.paths, &self.job.open, monitor)?)
    }

    /// COLMAP's importer looks for the features of `a.png` in `a.png.txt`.
    fn feature_file(&self, image_name: &str) -> PathBuf {
        self.folder.join(FEATURES_FOLDER).join(format!("{image_name}.txt"))
    }
}
