//! State of a dataset on disk, so that an interrupted run continues.
//!
//! `manifest.json`, the folder's mark, is written first and claims the program and settings. Each finished burst has a
//! record, `records/NAME.png.json`, of all that its features were made from and the checksum of their file. A burst
//! without one, or with other settings, is computed again: features of two detectors match worse than those of one.
//! Matched pairs lie in a folder beside the records.

use super::{ImageKind, blobs::StoredBlobs, stamp::FileStamp};
use crate::burst::{OpenOptions, files_at};
use crate::error::{Error, Result};
use crate::export::{MadeFrom, RECORDS_FOLDER, Record, write_whole};
use crate::files::mark::{Checksum, OutputKind, claiming, claims};
use crate::{
    detector::{SearchParams, SlopeGrid},
    monitor::Monitor,
};
use crate::{files::unfinished::remove_abandoned, matching::aligned::Seen};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::{collections::BTreeSet, io::Write};

pub(super) const DETECTOR_KEY: &str = "detector";

pub(super) type BurstRecord = Record<KeptBurst>;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct KeptBurst {
    pub files: Vec<FileStamp>,
    /// Size of its frames (columns, rows).
    pub size: (usize, usize),
    /// Number of frames in which its features were found.
    pub frames: usize,
    pub features: usize,
    /// Slopes that were searched, for a picture that is made later; absent in records of before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slopes: Option<SlopeGrid>,
    /// Checksum of the file of features.
    pub content: Checksum,
    pub blobs: StoredBlobs,
    pub seen: Seen,
    pub picture: ImageKind,
    pub picture_content: Checksum,
    pub seconds: f64,
}

impl KeptBurst {
    /// Checksums of all sources of a pair in this burst: features, and whatever else was `made_from` the frames.
    #[cfg(feature = "colmap")]
    pub fn key(&self, made_from: &MadeFrom) -> Value {
        let frames: Vec<Value> = self.files.iter().map(FileStamp::content).collect();
        let search = json!([made_from, frames, self.blobs, self.seen]).to_string();
        json!({ "features": self.content, "search": Checksum::of(search.as_bytes()) })
    }
}

/// Settings that decide on the features of a burst, as records and the manifest hold them.
pub(super) fn settings_of(detector: &SearchParams, open: &OpenOptions) -> Result<Value> {
    let contents = |path: &Option<PathBuf>| -> Result<Vec<Value>> {
        let stamps = FileStamp::with_checksums(&calibration_files(path)?, &Monitor::default())?;
        Ok(stamps.iter().map(FileStamp::content).collect())
    };
    let mut settings = json!({
        // Through text, because that is the file's form: a number may look different as a value.
        DETECTOR_KEY: detector.to_toml(),
        "bias": contents(&open.bias)?,
        "full_scale": open.full_scale,
        "flat": contents(&open.flat)?,
        "black_level": open.black_level,
        "raw_colour": open.raw_colour,
        "linearise": open.linearise,
        "accept_damaged": open.accept_damaged,
    });
    // Absent where they are not given, as in records of versions that did not have them.
    let layout = json!({ "mosaic": open.mosaic, "raw": open.raw, "axis": open.axis, "array": open.array,
                "topic": open.topic, "take": open.take, "times": open.times, "views": open.views });
    for (name, value) in layout.as_object().into_iter().flatten().filter(|(_, value)| !value.is_null()) {
        settings[name] = value.clone();
    }
    if open.mask_saturated {
        settings["mask_saturated"] = json!(true);
    }
    Ok(settings)
}

pub(super) fn calibration_files(path: &Option<PathBuf>) -> Result<Vec<PathBuf>> {
    path.as_ref().map_or(Ok(Vec::new()), |path| files_at(std::slice::from_ref(path)))
}

/// Folder of the matched pairs of the `dataset`: one in it for each first image, with a file for each second.
pub(super) fn pairs_folder(dataset: &Path) -> PathBuf {
    dataset.join(RECORDS_FOLDER).join("pairs")
}

/// Removes what killed runs have left among the pairs of the `dataset` in this folder.
///
/// # Errors
/// A folder of pairs is a link, which would lead out of the dataset.
pub(super) fn tidy_pairs(dataset: &Path) -> Result<()> {
    let folder = pairs_folder(dataset);
    let below = std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|entry| entry.path());
    for folder in [folder.clone()].into_iter().chain(below) {
        if folder.is_symlink() {
            return Err(Error::link(&folder));
        }
        remove_abandoned(&folder);
    }
    Ok(())
}

/// Reason why the features of a burst are found again although stored features exist.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotKept {
    /// The folder has no record of this burst: the burst is not finished there.
    #[error("it is not finished there")]
    NoRecord,
    /// The features were found by another version of the program.
    #[error("another version of the program found its features")]
    OtherProgram,
    /// The features were found with other options; these are named.
    #[error("its features were found with other options ({})", .0.join(", "))]
    OtherOptions(Vec<String>),
    /// The features were found in other frames.
    #[error("its features were found in other frames, or the frames have changed since")]
    OtherFiles,
    /// The file of features is missing or was altered.
    #[error("its file of features is missing or was altered")]
    Altered,
    /// The check failed.
    #[error(transparent)]
    Failed(#[from] Error),
}

pub(super) fn write_manifest(folder: &Path, made_from: &MadeFrom) -> Result<()> {
    let mut manifest = json!(made_from);
    manifest["commit"] = json!(crate::COMMIT);
    if claims(folder, OutputKind::Dataset).as_ref() == Some(&manifest) {
        return Ok(());
    }
    let text = claiming(OutputKind::Dataset, &manifest);
    write_whole(&folder.join(OutputKind::Dataset.file()), |out| out.write_all(text.as_bytes()))
}

/// The detector's parameters, as text, with which this program, and no other, found the features in `folder`.
pub(super) fn detector_text(folder: &Path) -> Option<String> {
    let manifest = claims(folder, OutputKind::Dataset).filter(MadeFrom::is_of_this_program)?;
    manifest.settings().get(DETECTOR_KEY)?.as_str().map(str::to_owned)
}

/// Names of the settings in which `other` differs from `ours`: `detector` is replaced by the names of its parameters.
pub(super) fn differences(ours: &MadeFrom, other: &MadeFrom) -> Vec<String> {
    let keys = |made: &MadeFrom| made.settings().as_object().map(|map| map.keys().cloned().collect::<BTreeSet<_>>());
    let all: BTreeSet<String> = [ours, other].into_iter().filter_map(keys).flatten().collect();
    let mut names = Vec::new();
    for key in all.into_iter().filter(|key| ours.settings().get(key) != other.settings().get(key)) {
        let table = |made: &MadeFrom| made.settings().get(&key)?.as_str()?.parse::<toml::Table>().ok();
        match (key.as_str(), table(ours), table(other)) {
            // The user set parameters, not a text: only those that differ are named.
            (DETECTOR_KEY, Some(own), Some(others)) => {
                let named: BTreeSet<&String> = own.keys().chain(others.keys()).collect();
                names.extend(named.into_iter().filter(|name| own.get(*name) != others.get(*name)).cloned());
            }
            _ => names.push(key),
        }
    }
    // As on the command line.
    names.iter().map(|name| name.replace('_', "-")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::REVISION;

    fn begun(change: impl FnOnce(&mut Value)) -> tempfile::TempDir {
        let home = tempfile::tempdir().expect("a folder");
        let manifest = MadeFrom::new(json!({ DETECTOR_KEY: "levels = 4" }));
        let mut value = serde_json::to_value(&manifest).expect("plain values");
        change(&mut value);
        std::fs::write(home.path().join(OutputKind::Dataset.file()), claiming(OutputKind::Dataset, &value))
            .expect("written");
        home
    }

    #[test]
    fn the_parameters_of_a_folder_are_those_that_this_program_would_find_again() {
        assert_eq!(detector_text(begun(|_| ()).path()).as_deref(), Some("levels = 4"));
        let changes: [fn(&mut Value); 5] = [
            |manifest| manifest["detector_revision"] = json!(REVISION + 1),
            |manifest| manifest["detector_revision"] = Value::Null,
            |manifest| drop(manifest.as_object_mut().expect("an object").remove("detector_revision")),
            |manifest| manifest["version"] = json!("0.0.1"),
            |manifest| *manifest = json!([1, 2]),
        ];
        for change in changes {
            assert_eq!(detector_text(begun(change).path()), None);
        }
    }

    #[test]
    fn what_differs_is_named_as_it_is_asked_for() {
        let ours = MadeFrom::new(json!({ DETECTOR_KEY: "levels = 4\nedge_threshold = 10\n", "bias": [] }));
        let other = |change: fn(&mut Value)| {
            let mut value = serde_json::to_value(&ours).expect("plain values");
            change(&mut value["settings"]);
            differences(&serde_json::from_value(value).expect("a manifest"), &ours)
        };
        assert_eq!(other(|_| ()), Vec::<String>::new());
        assert_eq!(other(|s| s[DETECTOR_KEY] = json!("levels = 4\nedge_threshold = 5\n")), ["edge-threshold"]);
        assert_eq!(other(|s| s["black_level"] = json!(3)), ["black-level"]);
        assert_eq!(other(|s| s[DETECTOR_KEY] = json!(3)), ["detector"]);
        assert_eq!(other(|s| *s = json!(null)), ["bias", "detector"]);
    }
}
