//! What has been done already: a small file beside the features, so that a dataset that was interrupted goes on where
//! it was.
//!
//! A burst is finished when its features were found by the same version of the program and the same revision of its
//! detector, with the same parameters from the same files (of the same size and time), and the feature file is still
//! there. Anything else is done again: features of two detectors do not match one another as well as those of one.

use super::DatasetError;
use crate::burst::OpenError;
use crate::detector::REVISION;
use crate::export::{ExportError, write_whole};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// The name of the file.
pub(super) const MANIFEST_FILE: &str = "manifest.json";

/// The detector's parameters among the settings.
pub(super) const DETECTOR_KEY: &str = "detector";

/// A file as it was when it was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct FileStamp {
    path: PathBuf,
    bytes: u64,
    /// Nanoseconds since 1970; 0 where the system does not say.
    modified_ns: u64,
}

impl FileStamp {
    /// Of each of `files`.
    pub(super) fn of(files: &[PathBuf]) -> Result<Vec<Self>, DatasetError> {
        files.iter().map(|path| Self::of_one(path)).collect()
    }

    fn of_one(path: &Path) -> Result<Self, DatasetError> {
        let unread = |e: std::io::Error| OpenError::Read { path: path.into(), reason: e.to_string() };
        let metadata = std::fs::metadata(path).map_err(unread)?;
        let modified = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        Ok(Self {
            path: std::path::absolute(path).unwrap_or_else(|_| path.into()),
            bytes: metadata.len(),
            modified_ns: modified.map_or(0, |since| since.as_nanos() as u64),
        })
    }
}

/// What is known of a finished burst.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Finished {
    /// Its files.
    pub files: Vec<FileStamp>,
    /// (columns, rows) of its frames.
    pub size: (usize, usize),
    /// Number of features.
    pub features: usize,
    /// The kind of picture that was written.
    pub picture: super::ImageKind,
    /// How long it took to open the burst and find the features, seconds; absent in older files.
    #[serde(default)]
    pub seconds: Option<f64>,
}

/// The content of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Manifest {
    /// The program's version.
    version: String,
    /// The detector's [`REVISION`]; absent in files of programs that had none.
    #[serde(default)]
    detector_revision: Option<u32>,
    /// Everything that decides the features, beside the burst's own files.
    settings: serde_json::Value,
    /// Finished bursts by their names.
    pub bursts: BTreeMap<String, Finished>,
}

impl Manifest {
    /// The manifest of `folder` for `settings`: what was finished with just these, or nothing.
    ///
    /// # Errors
    /// [`DatasetError::Occupied`] when the folder holds files but no manifest: it is somebody's own.
    pub(super) fn read(folder: &Path, settings: serde_json::Value) -> Result<Self, DatasetError> {
        let fresh = Self::fresh(settings);
        let Ok(text) = std::fs::read_to_string(folder.join(MANIFEST_FILE)) else {
            let empty = std::fs::read_dir(folder).map_or(true, |mut entries| entries.next().is_none());
            return if empty { Ok(fresh) } else { Err(DatasetError::Occupied(folder.into())) };
        };
        let earlier = serde_json::from_str::<Self>(&text).ok();
        Ok(earlier.filter(|e| e.is_of_this_program() && e.settings == fresh.settings).unwrap_or(fresh))
    }

    /// Nothing is finished yet.
    fn fresh(settings: serde_json::Value) -> Self {
        let version = env!("CARGO_PKG_VERSION").to_owned();
        Self { version, detector_revision: Some(REVISION), settings, bursts: BTreeMap::new() }
    }

    /// Whether this program would find the same bits.
    fn is_of_this_program(&self) -> bool {
        self.version == env!("CARGO_PKG_VERSION") && self.detector_revision == Some(REVISION)
    }

    /// The detector's parameters, as text, with which this program found the features in `folder`; `None` where it did
    /// not.
    pub(super) fn detector_text(folder: &Path) -> Option<String> {
        let text = std::fs::read_to_string(folder.join(MANIFEST_FILE)).ok()?;
        let manifest: Self = serde_json::from_str(&text).ok()?;
        manifest.settings.get(DETECTOR_KEY).filter(|_| manifest.is_of_this_program())?.as_str().map(str::to_owned)
    }

    /// Writes it into `folder`.
    pub(super) fn write(&self, folder: &Path) -> Result<(), ExportError> {
        write_whole(&folder.join(MANIFEST_FILE), |out| {
            serde_json::to_writer_pretty(&mut *out, self)?;
            out.write_all(b"\n")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// A folder with a manifest in which burst `night` is finished, changed by `change`.
    fn kept(change: impl FnOnce(&mut Value)) -> (tempfile::TempDir, Value) {
        let home = tempfile::tempdir().expect("a folder");
        let settings = json!({ DETECTOR_KEY: "levels = 4" });
        let mut manifest = Manifest::fresh(settings.clone());
        let picture = super::super::ImageKind::Middle;
        let finished = Finished { files: Vec::new(), size: (8, 6), features: 3, picture, seconds: None };
        manifest.bursts.insert("night".to_owned(), finished);
        let mut value = serde_json::to_value(&manifest).expect("plain values");
        change(&mut value);
        std::fs::write(home.path().join(MANIFEST_FILE), value.to_string()).expect("written");
        (home, settings)
    }

    #[test]
    fn what_this_detector_found_is_finished() {
        let (home, settings) = kept(|_| ());
        let read = Manifest::read(home.path(), settings).expect("a manifest");
        assert_eq!(read.bursts.keys().collect::<Vec<_>>(), ["night"]);
        assert_eq!(Manifest::detector_text(home.path()).as_deref(), Some("levels = 4"));
        read.write(home.path()).expect("written");
        let text = std::fs::read_to_string(home.path().join(MANIFEST_FILE)).expect("a file");
        let written: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(written["detector_revision"], json!(REVISION));
    }

    #[test]
    fn what_another_detector_found_is_not() {
        let changes: [fn(&mut Value); 4] = [
            |manifest| manifest["detector_revision"] = json!(REVISION + 1),
            |manifest| manifest["detector_revision"] = Value::Null,
            |manifest| drop(manifest.as_object_mut().expect("an object").remove("detector_revision")),
            |manifest| manifest["version"] = json!("0.0.1"),
        ];
        for change in changes {
            let (home, settings) = kept(change);
            let read = Manifest::read(home.path(), settings.clone()).expect("a manifest");
            assert_eq!(read, Manifest::fresh(settings));
            assert_eq!(Manifest::detector_text(home.path()), None);
        }
    }
}
