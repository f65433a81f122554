//! Records of finished work, so that an interrupted run continues: what each result was made from.
//!
//! A folder of results has a record for each finished one, `records/NAME.json`: program, detector and settings that
//! made it ([`MadeFrom`]), and what else tells whether its files are still those. A record is removed before the
//! result's files are written and written after them: it describes the existing files, or there is none. A result is
//! used again if it was made from the same by this program. A folder with files but without our mark is refused.

use super::atomic::write_whole;
use crate::detector::REVISION;
use crate::error::{Error, Result};
use crate::files::mark::{OutputKind, claims};
use crate::files::unfinished::{is_free, remove_abandoned};
use crate::files::{MAX_TABLE_BYTES, read_text};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::Value;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Folder of records in a folder of results.
pub const RECORDS_FOLDER: &str = "records";

/// Program and settings that made a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MadeFrom {
    version: String,
    detector_revision: u32,
    settings: Value,
}

impl MadeFrom {
    /// This program with `settings`.
    pub fn new(settings: impl Into<Value>) -> Self {
        Self { version: env!("CARGO_PKG_VERSION").to_owned(), detector_revision: REVISION, settings: settings.into() }
    }

    /// Whether this program would make the same bits.
    pub fn is_of_this_program(&self) -> bool {
        self.version == env!("CARGO_PKG_VERSION") && self.detector_revision == REVISION
    }

    /// Settings that made the result, as JSON.
    pub fn settings(&self) -> &Value {
        &self.settings
    }
}

/// Record of a finished result: what it was made from, and `of`, what else is known of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record<T> {
    /// Program and settings that made the result.
    #[serde(flatten)]
    pub made_from: MadeFrom,
    /// Facts about the result, such as checksums of its files; an object in JSON.
    #[serde(flatten)]
    pub of: T,
}

/// The records of a folder.
#[derive(Debug, Clone)]
pub struct Records {
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
    pub fn begin(&self) -> Result<()> {
        std::fs::create_dir_all(&self.folder).map_err(|error| Error::unwritten(&self.folder, &error))?;
        remove_abandoned(&self.folder);
        Ok(())
    }

    /// Reads the record `name`, if there is a readable one.
    pub fn read<T: DeserializeOwned>(&self, name: &str) -> Option<Record<T>> {
        serde_json::from_str(&read_text(&self.path(name), MAX_TABLE_BYTES).ok()?).ok()
    }

    /// Writes the record `name`, after the files that it describes.
    pub fn write<T: Serialize>(&self, name: &str, record: &Record<T>) -> Result<()> {
        self.check(name)?;
        write_whole(&self.path(name), |out| {
            serde_json::to_writer_pretty(&mut *out, record)?;
            out.write_all(b"\n")
        })
    }

    /// Removes the record `name`, before the files that it describes are changed.
    pub fn remove(&self, name: &str) -> Result<()> {
        self.check(name)?;
        let path = self.path(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Error::unwritten(&path, &error)),
            _ => Ok(()),
        }
    }

    fn check(&self, name: &str) -> Result<()> {
        let path = self.path(name);
        // A file that is no record is somebody's own; an empty one counts as missing.
        let is_other = std::fs::metadata(&path).is_ok_and(|file| file.is_file() && file.len() > 0)
            && self.read::<serde_json::Map<String, Value>>(name).is_none();
        if is_other { Err(Error::in_the_way(&path)) } else { Ok(()) }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.json"))
    }
}

/// Whether results may be written into `folder`: it has the mark of its `kind`, which is written before the first
/// result, or nothing. A folder that cannot be listed passes: writing there gives the error.
///
/// # Errors
/// One of its `parts` is a link, which leads out of the folder.
pub fn may_begin(folder: &Path, kind: OutputKind, parts: &[&str]) -> Result<bool> {
    match parts.iter().map(|part| folder.join(part)).find(|part| part.is_symlink()) {
        Some(path) => Err(Error::link(&path)),
        None => Ok(claims::<Value>(folder, kind).is_some() || is_free(folder).unwrap_or(true)),
    }
}
