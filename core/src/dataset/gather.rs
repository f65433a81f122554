//! What several runs have found, brought into one folder.
//!
//! A dataset that outgrows one machine is split: each run takes some of its bursts and keeps their features in a folder
//! of its own. Afterwards one run gathers them: of each burst that is not finished yet, the files of a run that found
//! them with the same parameters in the same frames are copied. Nothing else is trusted, so what does not fit is found
//! again.

use super::DatasetError;
use super::features::{FEATURES_FOLDER, FeatureStore, IMAGES_FOLDER, image_name};
use super::manifest::Record;
use crate::burst::BurstSource;
use crate::export::{ExportError, write_whole};
use crate::monitor::Monitor;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Copies into the folder of `store` what the runs in `folders` have finished of `bursts`; answers how many bursts were
/// brought.
///
/// # Errors
/// A folder that is none, a file that cannot be read or written, a folder in which another process writes, or that it
/// was cancelled.
pub fn gather(
    store: &mut FeatureStore,
    bursts: &[BurstSource],
    folders: &[PathBuf],
    monitor: &Monitor,
) -> Result<usize, DatasetError> {
    if let Some(missing) = folders.iter().find(|folder| !folder.is_dir()) {
        let reason = "there is no such folder of kept features".to_owned();
        return Err(ExportError::Read { path: missing.clone(), reason }.into());
    }
    let others = folders.iter().map(|folder| store.like(folder)).collect::<Vec<_>>();
    let mut brought = 0;
    for source in bursts {
        monitor.check()?;
        if store.finished(source).is_some() {
            continue;
        }
        // A file that was altered is not kept, see there.
        let Some(other) = others.iter().find(|other| other.kept(source).is_some()) else { continue };
        let image = image_name(source);
        let Some(record) = Record::read(other.folder(), &image) else { continue };
        store.begin_writing()?;
        Record::remove(store.folder(), &image)?;
        let feature_file = Path::new(FEATURES_FOLDER).join(format!("{image}.txt"));
        for file in [feature_file, Path::new(IMAGES_FOLDER).join(&image)] {
            copy(&other.folder().join(&file), &store.folder().join(&file))?;
        }
        record.write(store.folder(), &image)?;
        brought += 1;
    }
    Ok(brought)
}

/// Copies a file whole or not at all.
fn copy(from: &Path, to: &Path) -> Result<(), ExportError> {
    let bytes = std::fs::read(from).map_err(|e| ExportError::Read { path: from.into(), reason: e.to_string() })?;
    write_whole(to, |out| out.write_all(&bytes))
}
