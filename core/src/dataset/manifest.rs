//! State of a dataset on disk, so that an interrupted run continues.
//!
//! `manifest.json` names the program and settings with which the folder was begun; it is written before anything else.
//! Each finished burst has a record of its own, `records/NAME.png.json`, which names all that its features were made
//! from, and the checksum of their file. It is removed before the features are written and written after them, so
//! whenever a run ends, either the record describes the existing file or there is no record. A burst without a record,
//! or with one that differs from the current settings, is computed again: features of two detectors do not match one
//! another as well as those of one.

use super::DatasetError;
use super::stamp::{Checksum, FileStamp};
use crate::detector::REVISION;
use crate::export::{ExportError, write_whole};
use crate::files::lock::is_free;
use crate::files::{MAX_SESSION_BYTES, MAX_SETTINGS_BYTES, read_text};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Name of the manifest file.
pub(super) const MANIFEST_FILE: &str = "manifest.json";
/// Folder of records in the dataset's folder.
const RECORDS_FOLDER: &str = "records";

/// Key of the detector's parameters in the settings.
pub(super) const DETECTOR_KEY: &str = "detector";

/// Program and settings with which features are found; the bursts' own files are not included.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Manifest {
    /// Version of the program.
    version: String,
    /// Revision of the detector, [`REVISION`]; absent in files of programs that had none.
    #[serde(default)]
    detector_revision: Option<u32>,
    /// All settings that affect the features.
    settings: serde_json::Value,
}

impl Manifest {
    /// The manifest of this program with `settings`.
    pub(super) fn new(settings: serde_json::Value) -> Self {
        Self { version: env!("CARGO_PKG_VERSION").to_owned(), detector_revision: Some(REVISION), settings }
    }

    /// Checks that `folder` is free or holds a dataset that this command began.
    ///
    /// # Errors
    /// [`DatasetError::Occupied`] when `folder` holds files but no manifest: it belongs to somebody else.
    pub(super) fn check_folder(folder: &Path) -> Result<(), DatasetError> {
        let is_begun = folder.join(MANIFEST_FILE).is_file();
        // Other errors of reading it also prevent writing; they are reported then.
        let is_usable = is_begun || is_free(folder).unwrap_or(true);
        if is_usable { Ok(()) } else { Err(DatasetError::Occupied(folder.into())) }
    }

    /// The manifest in `folder`, if it can be read.
    fn read(folder: &Path) -> Option<Self> {
        serde_json::from_str(&read_text(&folder.join(MANIFEST_FILE), MAX_SETTINGS_BYTES).ok()?).ok()
    }

    /// Whether this program would find the same bits.
    pub(super) fn is_of_this_program(&self) -> bool {
        self.version == env!("CARGO_PKG_VERSION") && self.detector_revision == Some(REVISION)
    }

    /// The detector's parameters, as text, with which this program found the features in `folder`; `None` where another
    /// one did.
    pub(super) fn detector_text(folder: &Path) -> Option<String> {
        let manifest = Self::read(folder).filter(Self::is_of_this_program)?;
        manifest.settings.get(DETECTOR_KEY)?.as_str().map(str::to_owned)
    }

    /// The names of the settings in which `other` differs: `detector` is replaced by the names of its parameters.
    pub(super) fn differences(&self, other: &Self) -> Vec<String> {
        let keys =
            |manifest: &Self| manifest.settings.as_object().map(|map| map.keys().cloned().collect::<BTreeSet<_>>());
        let all: BTreeSet<String> = [self, other].into_iter().filter_map(keys).flatten().collect();
        let mut names = Vec::new();
        for key in all.into_iter().filter(|key| self.settings.get(key) != other.settings.get(key)) {
            let table = |manifest: &Self| manifest.settings.get(&key)?.as_str()?.parse::<toml::Table>().ok();
            match (key.as_str(), table(self), table(other)) {
                (DETECTOR_KEY, Some(own), Some(others)) => {
                    let named: BTreeSet<&String> = own.keys().chain(others.keys()).collect();
                    names.extend(named.into_iter().filter(|name| own.get(*name) != others.get(*name)).cloned());
                }
                _ => names.push(key),
            }
        }
        names.iter().map(|name| name.replace('_', "-")).collect()
    }

    /// Writes the manifest into `folder`, unless it is there already.
    pub(super) fn write(&self, folder: &Path) -> Result<(), ExportError> {
        if Self::read(folder).as_ref() == Some(self) { Ok(()) } else { write_json(&folder.join(MANIFEST_FILE), self) }
    }
}

/// Record of a finished burst.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// Program and settings with which its features were found.
    #[serde(flatten)]
    pub made_with: Manifest,
    /// Stamps of its files.
    pub files: Vec<FileStamp>,
    /// Size of its frames (columns, rows).
    pub size: (usize, usize),
    /// Number of features.
    pub features: usize,
    /// Checksum of the file of features.
    pub content: Checksum,
    /// Kind of the picture that was written.
    pub picture: super::ImageKind,
    /// Checksum of the picture; absent in records of earlier programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture_content: Option<Checksum>,
    /// Time taken to open the burst and find its features, seconds.
    pub seconds: Option<f64>,
}

impl Record {
    fn path(folder: &Path, image_name: &str) -> PathBuf {
        folder.join(RECORDS_FOLDER).join(format!("{image_name}.json"))
    }

    /// Reads the record of the burst with this image, if there is a readable one.
    pub(super) fn read(folder: &Path, image_name: &str) -> Option<Self> {
        serde_json::from_str(&read_text(&Self::path(folder, image_name), MAX_SESSION_BYTES).ok()?).ok()
    }

    /// Writes the record.
    pub(super) fn write(&self, folder: &Path, image_name: &str) -> Result<(), ExportError> {
        write_json(&Self::path(folder, image_name), self)
    }

    /// Removes the record, before its files are changed.
    pub(super) fn remove(folder: &Path, image_name: &str) -> Result<(), ExportError> {
        let path = Self::path(folder, image_name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(ExportError::write(&path, &error)),
            _ => Ok(()),
        }
    }

    /// The folder of records, in which a killed run may have left temporary files.
    pub(super) fn folder(folder: &Path) -> PathBuf {
        folder.join(RECORDS_FOLDER)
    }
}

fn write_json(path: &Path, value: &impl Serialize) -> Result<(), ExportError> {
    write_whole(path, |out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        out.write_all(b"\n")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Monitor;
    use proptest::prelude::*;
    use serde_json::{Value, json};

    /// A folder with a manifest, changed by `change`.
    fn begun(change: impl FnOnce(&mut Value)) -> tempfile::TempDir {
        let home = tempfile::tempdir().expect("a folder");
        let manifest = Manifest::new(json!({ DETECTOR_KEY: "levels = 4" }));
        let mut value = serde_json::to_value(&manifest).expect("plain values");
        change(&mut value);
        std::fs::write(home.path().join(MANIFEST_FILE), value.to_string()).expect("written");
        home
    }

    #[test]
    fn the_parameters_of_a_folder_are_those_that_this_program_would_find_again() {
        assert_eq!(Manifest::detector_text(begun(|_| ()).path()).as_deref(), Some("levels = 4"));
        let changes: [fn(&mut Value); 5] = [
            |manifest| manifest["detector_revision"] = json!(REVISION + 1),
            |manifest| manifest["detector_revision"] = Value::Null,
            |manifest| drop(manifest.as_object_mut().expect("an object").remove("detector_revision")),
            |manifest| manifest["version"] = json!("0.0.1"),
            |manifest| *manifest = json!([1, 2]),
        ];
        for change in changes {
            assert_eq!(Manifest::detector_text(begun(change).path()), None);
        }
    }

    #[test]
    fn what_differs_is_named_as_it_is_asked_for() {
        let ours = Manifest::new(json!({ DETECTOR_KEY: "levels = 4\nedge_threshold = 10\n", "bias": [] }));
        let other = |change: fn(&mut Value)| {
            let mut value = serde_json::to_value(&ours).expect("plain values");
            change(&mut value["settings"]);
            serde_json::from_value::<Manifest>(value).expect("a manifest").differences(&ours)
        };
        assert_eq!(other(|_| ()), Vec::<String>::new());
        assert_eq!(other(|s| s[DETECTOR_KEY] = json!("levels = 4\nedge_threshold = 5\n")), ["edge-threshold"]);
        assert_eq!(other(|s| s["black_level"] = json!(3)), ["black-level"]);
        assert_eq!(other(|s| s[DETECTOR_KEY] = json!(3)), ["detector"]);
        assert_eq!(other(|s| *s = json!(null)), ["bias", "detector"]);
    }

    #[test]
    fn what_an_interrupted_run_leaves_is_no_reason_to_refuse_a_folder() {
        let home = tempfile::tempdir().expect("a folder");
        std::fs::write(home.path().join(crate::files::lock::LOCK_FILE), "").expect("written");
        std::fs::write(home.path().join(".burstscope-abc.tmp"), "").expect("written");
        assert_eq!(Manifest::check_folder(home.path()), Ok(()));
        std::fs::write(home.path().join("holiday.png"), "").expect("written");
        assert_eq!(Manifest::check_folder(home.path()), Err(DatasetError::Occupied(home.path().into())));
        assert_eq!(Manifest::check_folder(begun(|_| ()).path()), Ok(()));
        assert_eq!(Manifest::check_folder(&home.path().join("new")), Ok(()));
    }

    fn record() -> Record {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        Record {
            made_with: Manifest::new(json!({ DETECTOR_KEY: "levels = 4" })),
            files: FileStamp::with_checksums(&[file], &Monitor::default()).expect("it is there"),
            size: (8, 6),
            features: 3,
            content: Checksum::of(b"3 128\n"),
            picture: super::super::ImageKind::Middle,
            picture_content: Some(Checksum::of(b"PNG")),
            seconds: Some(0.25),
        }
    }

    #[test]
    fn records_come_back_and_go() {
        let home = tempfile::tempdir().expect("a folder");
        let record = record();
        assert_eq!(Record::read(home.path(), "night.png"), None);
        record.write(home.path(), "night.png").expect("written");
        assert_eq!(Record::read(home.path(), "night.png").as_ref(), Some(&record));
        assert_ne!(Checksum::of(b"4 128\n"), record.content);
        Record::remove(home.path(), "night.png").expect("removed");
        Record::remove(home.path(), "night.png").expect("it is not there");
        assert_eq!(Record::read(home.path(), "night.png"), None);
    }

    proptest! {
        /// Unreadable records count as missing; a damaged but readable one must not differ from the original.
        #[test]
        fn damaged_records_are_not_believed(at: prop::sample::Index, noise in prop::collection::vec(any::<u8>(), 1..6), cut: bool) {
            let sound = serde_json::to_vec_pretty(&record()).expect("plain values");
            let mut bytes = sound.clone();
            let place = at.index(bytes.len());
            let end = (place + noise.len()).min(bytes.len());
            if cut { bytes.truncate(place) } else { bytes[place..end].copy_from_slice(&noise[..end - place]) }
            for text in [String::from_utf8_lossy(&bytes).into_owned(), String::from_utf8_lossy(&bytes[place..]).into_owned()] {
                if let Ok(read) = serde_json::from_str::<Record>(&text) {
                    let again = serde_json::to_string(&read).expect("plain values");
                    prop_assert_eq!(serde_json::from_str::<Record>(&again).ok(), Some(read));
                }
            }
        }
    }
}
