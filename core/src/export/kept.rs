//! Records of finished work, so that an interrupted run continues: what each result was made from.
//!
//! A folder of results has a record for each finished one, `records/NAME.json`: the program, the revision of its
//! detector and the settings that made the result ([`MadeFrom`]), and what else tells whether its files are still
//! those. A record is removed before the result's files are written and written after them, so whenever a run ends,
//! either the record describes the existing files or there is no record. A result is used again if its record was made
//! from the same by this program; otherwise it is made again. A folder that holds files, but none of these records, is
//! somebody else's and refused.

use super::atomic::{remove_temporary_files, write_whole};
use super::error::ExportError;
use crate::detector::REVISION;
use crate::files::lock::is_free;
use crate::files::{MAX_SESSION_BYTES, read_text};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Folder of records in a folder of results.
const RECORDS_FOLDER: &str = "records";

/// Program and settings that made a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct MadeFrom {
    /// Version of the program.
    version: String,
    /// Revision of the detector, [`REVISION`].
    detector_revision: u32,
    /// All settings that affect the result.
    settings: Value,
}

impl MadeFrom {
    /// This program with `settings`.
    pub fn new(settings: impl Into<Value>) -> Self {
        let version = env!("CARGO_PKG_VERSION").to_owned();
        Self { version, detector_revision: REVISION, settings: settings.into() }
    }

    /// Whether this program would make the same bits.
    pub fn is_of_this_program(&self) -> bool {
        self.version == env!("CARGO_PKG_VERSION") && self.detector_revision == REVISION
    }

    /// The settings.
    pub fn settings(&self) -> &Value {
        &self.settings
    }
}

/// Record of a finished result: what it was made from, and `of`, what else is known of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record<T> {
    /// Program and settings that made the result.
    #[serde(flatten)]
    pub made_from: MadeFrom,
    /// Facts about the result, such as checksums of its files; an object in JSON.
    #[serde(flatten)]
    pub of: T,
}

/// The records of a folder.
#[derive(Debug, Clone)]
pub(crate) struct Records {
    folder: PathBuf,
}

impl Records {
    /// The records of the results in `folder`.
    pub fn of(folder: &Path) -> Self {
        Self { folder: folder.join(RECORDS_FOLDER) }
    }

    /// The records in the folder `name` among these.
    pub fn below(&self, name: &str) -> Self {
        Self { folder: self.folder.join(name) }
    }

    /// Folder in which the records lie.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Creates the folder, and removes files that killed runs have left there.
    pub fn begin(&self) -> Result<(), ExportError> {
        std::fs::create_dir_all(&self.folder).map_err(|error| ExportError::write(&self.folder, &error))?;
        remove_temporary_files(&self.folder);
        Ok(())
    }

    /// Reads the record `name`, if there is a readable one.
    pub fn read<T: DeserializeOwned>(&self, name: &str) -> Option<Record<T>> {
        read_json(&self.path(name))
    }

    /// Writes the record `name`, after the files that it describes.
    pub fn write<T: Serialize>(&self, name: &str, record: &Record<T>) -> Result<(), ExportError> {
        write_json(&self.path(name), record)
    }

    /// Removes the record `name`, before the files that it describes are changed.
    pub fn remove(&self, name: &str) -> Result<(), ExportError> {
        let path = self.path(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(ExportError::write(&path, &error)),
            _ => Ok(()),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.json"))
    }
}

/// Whether results may be written into `folder`: it holds the file or folder `mark`, which is written before the first
/// result, or nothing. A folder that cannot be listed passes: writing there gives the error.
pub(crate) fn may_begin(folder: &Path, mark: &Path) -> bool {
    folder.join(mark).exists() || is_free(folder).unwrap_or(true)
}

/// Reads a file of JSON that [`write_json`] wrote; `None` for any other.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Option<T> {
    serde_json::from_str(&read_text(path, MAX_SESSION_BYTES).ok()?).ok()
}

/// Writes `value` as JSON, completely or not at all.
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), ExportError> {
    write_whole(path, |out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        out.write_all(b"\n")
    })
}

/// Length and checksum by which an altered file is recognised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Checksum {
    bytes: u64,
    crc32: u32,
}

impl Checksum {
    /// The checksum of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self { bytes: bytes.len() as u64, crc32: crc32fast::hash(bytes) }
    }

    /// The checksum of the file at `path`.
    ///
    /// # Errors
    /// The system's error.
    pub fn of_file(path: &Path) -> io::Result<Self> {
        Ok(Self::of(&std::fs::read(path)?))
    }

    /// Whether the file at `path` has the same length; checked without reading it.
    pub fn is_as_long_as(&self, path: &Path) -> bool {
        std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() == self.bytes)
    }

    /// Whether the file at `path` has this content. A file of another length is not read.
    pub fn is_of(&self, path: &Path) -> bool {
        self.is_as_long_as(path) && Self::of_file(path).is_ok_and(|now| now == *self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde_json::json;

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct Row {
        content: Checksum,
        values: Vec<f64>,
    }

    fn record() -> Record<Row> {
        let of = Row { content: Checksum::of(b"3 128\n"), values: vec![0.1, 2.5e-7] };
        Record { made_from: MadeFrom::new(json!({ "levels": 4 })), of }
    }

    #[test]
    fn records_come_back_and_go() {
        let home = tempfile::tempdir().expect("a folder");
        let records = Records::of(home.path());
        assert_eq!(records.read::<Row>("night"), None);
        records.write("night", &record()).expect("written");
        assert_eq!(records.read("night"), Some(record()));
        assert_eq!(records.read::<Record<String>>("night"), None, "it is no text");
        assert!(record().made_from.is_of_this_program());
        assert_ne!(MadeFrom::new(json!({ "levels": 5 })), record().made_from);
        records.remove("night").expect("removed");
        records.remove("night").expect("it is not there");
        assert_eq!(records.read::<Row>("night"), None);
    }

    #[test]
    fn files_of_an_interrupted_run_are_no_reason_to_refuse_a_folder() {
        let home = tempfile::tempdir().expect("a folder");
        let mark = Path::new("manifest.json");
        std::fs::write(home.path().join(crate::files::lock::LOCK_FILE), "").expect("written");
        std::fs::write(home.path().join(".burstscope-abc.tmp"), "").expect("written");
        assert!(may_begin(home.path(), mark) && may_begin(&home.path().join("new"), mark));
        std::fs::write(home.path().join("holiday.png"), "").expect("written");
        assert!(!may_begin(home.path(), mark));
        std::fs::write(home.path().join(mark), "").expect("written");
        assert!(may_begin(home.path(), mark));
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
                if let Ok(read) = serde_json::from_str::<Record<Row>>(&text) {
                    let again = serde_json::to_string(&read).expect("plain values");
                    prop_assert_eq!(serde_json::from_str::<Record<Row>>(&again).ok(), Some(read));
                }
            }
        }
    }
}
