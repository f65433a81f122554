//! Gathering the features that several runs have found into one folder.
//!
//! For each burst of a dataset that is not finished yet, the files of a run that found its features with the same
//! parameters in the same frames are copied. Files that do not fit are reported, and their features found again.

use super::BurstFeatures;
use super::features::{FEATURES_FOLDER, FeatureStore, IMAGES_FOLDER, image_name};
use super::kept::{KeptBurst, NotKept};
use crate::error::{Error, Result};
use crate::files::{read_bytes, serialize_path};
use crate::{burst::BurstFiles, export::write_whole, monitor::Monitor};
use serde::{Serialize, Serializer};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Report of gathering.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct GatherReport {
    /// Names of the bursts whose features were copied.
    pub brought: Vec<String>,
    /// Bursts whose features in some folder were not used, and which no other folder provided.
    pub left_out: Vec<LeftOut>,
    /// Folders that hold none of the bursts.
    #[serde(serialize_with = "crate::files::serialize_paths")]
    pub strange_folders: Vec<PathBuf>,
}

/// A burst whose features in a folder were not used.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// Folder of the features.
    #[serde(serialize_with = "serialize_path")]
    pub folder: PathBuf,
    /// Name of the burst.
    pub burst: String,
    /// Reason why they were not used.
    #[serde(serialize_with = "as_text")]
    pub reason: NotKept,
}

fn as_text<S: Serializer>(reason: &NotKept, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(reason)
}

/// Copies the finished ones among `bursts` from the `folders` of other runs into the folder of `store`.
///
/// # Errors
/// A path that is no folder, a file that cannot be read or written, a folder in use by another process, cancellation.
pub fn gather(
    store: &mut FeatureStore,
    bursts: &[BurstFiles],
    folders: &[PathBuf],
    monitor: &Monitor,
) -> Result<GatherReport> {
    if let Some(missing) = folders.iter().find(|folder| !folder.is_dir()) {
        return Err(Error::unread_file(missing, "there is no such folder of kept features"));
    }
    store.protect(bursts)?;
    // The same job in each folder: features count only if these parameters would find them.
    let others = folders.iter().map(|folder| store.like(folder)).collect::<Vec<_>>();
    let mut knows_one = vec![false; folders.len()];
    let mut report = GatherReport::default();
    for source in bursts {
        monitor.check()?;
        let is_finished = store.finished(source).is_some();
        let (mut brought, mut left_out) = (false, Vec::new());
        for (other, knows_one) in others.iter().zip(&mut knows_one) {
            if is_finished || brought {
                // Looked at only to see whether the folder is of this dataset.
                *knows_one = *knows_one || other.records().read::<KeptBurst>(&image_name(source)).is_some();
                continue;
            }
            match other.kept(source, monitor) {
                Ok(features) => {
                    (brought, *knows_one) = (true, true);
                    bring(store, other, &features)?;
                }
                Err(NotKept::Failed(error)) if error.is_cancelled() => return Err(error),
                // Nothing of this burst is there, which is no fault.
                Err(NotKept::NoRecord) => {}
                Err(reason) => {
                    *knows_one = true;
                    left_out.push(LeftOut { folder: other.folder.clone(), burst: source.name.clone(), reason });
                }
            }
        }
        if brought {
            report.brought.push(source.name.clone());
        } else {
            // Reported only where no folder has provided the features.
            report.left_out.append(&mut left_out);
        }
    }
    let strange = folders.iter().zip(knows_one).filter(|(_, knows_one)| !knows_one);
    report.strange_folders.extend(strange.map(|(folder, _)| folder.clone()));
    Ok(report)
}

/// Copies the files of a burst that is finished in `other`. A picture that is missing there is made later.
fn bring(store: &mut FeatureStore, other: &FeatureStore, features: &BurstFeatures) -> Result<()> {
    let image = &features.image_name;
    let Some(record) = other.records().read::<KeptBurst>(image) else { return Ok(()) };
    store.begin_writing()?;
    // The record goes first and comes last: files in between count as none.
    store.records().remove(image)?;
    let feature_file = Path::new(FEATURES_FOLDER).join(format!("{image}.txt"));
    let picture_file = Path::new(IMAGES_FOLDER).join(image);
    let has_picture = other.folder.join(&picture_file).is_file();
    for file in [Some(feature_file), has_picture.then_some(picture_file)].into_iter().flatten() {
        let to = store.folder.join(&file);
        store.check_output(&to)?;
        let from = other.folder.join(&file);
        let bytes = read_bytes(&from, u64::MAX).map_err(|e| Error::unread_file(&from, e))?;
        write_whole(&to, |out| out.write_all(&bytes))?;
    }
    store.records().write(image, &record)
}
