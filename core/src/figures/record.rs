//! Records of finished figures, so that an interrupted run continues.
//!
//! `records/NAME.json` names all that a figure was made from and the checksums of its files. It is removed before the
//! files are written and written after them, so whenever a run ends, either the record describes the existing files or
//! there is no record. [`Pieces`] stores, in the same way, parts that take long and are used by several figures.

use super::{FiguresError, PaperFigure};
use crate::dataset::Checksum;
use crate::detector::REVISION;
use crate::export::{ExportError, remove_temporary_files, write_whole};
use crate::files::lock::is_free;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Folder of records in the figures' folder.
const RECORDS_FOLDER: &str = "records";
/// Folder of pieces among the records.
const PIECES_FOLDER: &str = "pieces";

/// Program and settings that made something.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct MadeFrom {
    /// Version of the program.
    version: String,
    /// The detector's [`REVISION`].
    detector_revision: u32,
    /// Every parameter, as text.
    settings: String,
}

impl MadeFrom {
    /// This program's version with these settings.
    pub fn new(settings: String) -> Self {
        Self { version: env!("CARGO_PKG_VERSION").to_owned(), detector_revision: REVISION, settings }
    }
}

/// Record of a finished figure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// The figure.
    pub figure: PaperFigure,
    /// Program and settings that it was made from.
    pub made_from: MadeFrom,
    /// Names and checksums of its files.
    pub files: Vec<(String, Checksum)>,
    /// Notes for the reader.
    pub notes: Vec<String>,
    /// Time that it took, seconds.
    pub seconds: f64,
}

impl Record {
    /// Reads the record of a figure in `folder`, if there is one whose files are unchanged.
    pub fn read(folder: &Path, figure: PaperFigure) -> Option<Self> {
        let record: Self = read_json(&Self::path(folder, figure))?;
        let is_whole = |(name, content): &(String, Checksum)| {
            std::fs::read(folder.join(name)).is_ok_and(|bytes| Checksum::of(&bytes) == *content)
        };
        (record.figure == figure && record.files.iter().all(is_whole)).then_some(record)
    }

    /// Writes the record.
    pub fn write(&self, folder: &Path) -> Result<(), ExportError> {
        write_json(&Self::path(folder, self.figure), self)
    }

    /// Removes the record, before its files are changed.
    pub fn remove(folder: &Path, figure: PaperFigure) -> Result<(), ExportError> {
        let path = Self::path(folder, figure);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(ExportError::write(&path, &error)),
            _ => Ok(()),
        }
    }

    fn path(folder: &Path, figure: PaperFigure) -> PathBuf {
        folder.join(RECORDS_FOLDER).join(format!("{}.json", figure.name()))
    }
}

/// Checks that `folder` is free or holds figures that this program began.
///
/// # Errors
/// [`FiguresError::Occupied`] when `folder` holds files but no records: it belongs to somebody else.
pub(super) fn check_folder(folder: &Path) -> Result<(), FiguresError> {
    let is_begun = folder.join(RECORDS_FOLDER).join(PIECES_FOLDER).is_dir();
    if is_begun || is_free(folder).unwrap_or(false) { Ok(()) } else { Err(FiguresError::Occupied(folder.into())) }
}

/// Creates the folders of records, and removes files that killed runs have left.
pub(super) fn begin(folder: &Path) -> Result<(), ExportError> {
    let pieces = folder.join(RECORDS_FOLDER).join(PIECES_FOLDER);
    let made = std::fs::create_dir_all(&pieces);
    made.map_err(|error| ExportError::write(&pieces, &error))?;
    for folder in [folder, &folder.join(RECORDS_FOLDER), &pieces] {
        remove_temporary_files(folder);
    }
    Ok(())
}

/// Stored parts of figures.
#[derive(Debug, Clone)]
pub(super) struct Pieces {
    folder: PathBuf,
}

/// A part with the program and settings that made it.
#[derive(Serialize, Deserialize)]
struct Piece<T> {
    made_from: MadeFrom,
    value: T,
}

impl Pieces {
    /// The pieces of the figures in `folder`.
    pub fn of(folder: &Path) -> Self {
        Self { folder: folder.join(RECORDS_FOLDER).join(PIECES_FOLDER) }
    }

    /// The piece `name` if it was made from these settings.
    pub fn get<T: DeserializeOwned>(&self, name: &str, settings: &str) -> Option<T> {
        let piece: Piece<T> = read_json(&self.path(name))?;
        (piece.made_from == MadeFrom::new(settings.to_owned())).then_some(piece.value)
    }

    /// Stores the piece `name`.
    pub fn keep<T: Serialize>(&self, name: &str, settings: &str, value: &T) -> Result<(), ExportError> {
        write_json(&self.path(name), &Piece { made_from: MadeFrom::new(settings.to_owned()), value })
    }

    /// A folder for files that are needed only while a piece is made.
    pub fn temporary(&self) -> Result<tempfile::TempDir, ExportError> {
        let made = tempfile::Builder::new().prefix(".work-").tempdir_in(&self.folder);
        made.map_err(|error| ExportError::write(&self.folder, &error))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.json"))
    }
}

fn read_json<T: DeserializeOwned>(path: &Path) -> Option<T> {
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
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

    #[test]
    fn a_record_speaks_of_the_files_that_are_there() {
        let home = tempfile::tempdir().expect("a folder");
        begin(home.path()).expect("begun");
        let path = home.path().join("fig7.svg");
        std::fs::write(&path, "<svg/>").expect("written");
        let record = Record {
            figure: PaperFigure::Fig7,
            made_from: MadeFrom::new("all".into()),
            files: vec![("fig7.svg".into(), Checksum::of(b"<svg/>"))],
            notes: Vec::new(),
            seconds: 1.0,
        };
        record.write(home.path()).expect("written");
        assert_eq!(Record::read(home.path(), PaperFigure::Fig7), Some(record));
        assert_eq!(Record::read(home.path(), PaperFigure::Fig8), None);
        std::fs::write(&path, "<svg></svg>").expect("altered");
        assert_eq!(Record::read(home.path(), PaperFigure::Fig7), None, "another content");
        Record::remove(home.path(), PaperFigure::Fig7).expect("removed");
        Record::remove(home.path(), PaperFigure::Fig7).expect("it is not there");
    }

    #[test]
    fn pieces_are_of_their_settings_and_other_peoples_folders_are_left_alone() {
        let home = tempfile::tempdir().expect("a folder");
        std::fs::write(home.path().join("thesis.txt"), "").expect("written");
        assert!(matches!(check_folder(home.path()), Err(FiguresError::Occupied(_))));
        assert!(check_folder(&home.path().join("new")).is_ok());
        begin(home.path()).expect("begun");
        assert!(check_folder(home.path()).is_ok());
        let pieces = Pieces::of(home.path());
        pieces.keep("row", "seed 1", &vec![1.5, 2.0]).expect("kept");
        assert_eq!(pieces.get::<Vec<f64>>("row", "seed 1"), Some(vec![1.5, 2.0]));
        assert_eq!(pieces.get::<Vec<f64>>("row", "seed 2"), None);
        assert_eq!(pieces.get::<String>("row", "seed 1"), None, "it is no text");
    }
}
