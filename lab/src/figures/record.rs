//! Records of finished figures, so that an interrupted run continues: see [`Records`].
//!
//! `records/NAME.json` names all that a figure was made from and the checksums of its files. [`Pieces`] stores, in the
//! same way, parts that take long and are used by several figures.

use super::PaperFigure;
use burstscope_core::error::{Error, ErrorKind, Result};
use burstscope_core::export::{MadeFrom, RECORDS_FOLDER, Record, Records, may_begin, write_whole};
use burstscope_core::files::mark::{Checksum, OutputKind, claiming};
use burstscope_core::files::unfinished::{Unfinished, remove_abandoned};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::Path;

const PIECES_FOLDER: &str = "pieces";

pub(super) type FigureRecord = Record<KeptFigure>;

/// Facts about a finished figure, kept in its record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct KeptFigure {
    pub figure: PaperFigure,
    pub files: Vec<(String, Checksum)>,
    /// Names and checksums of the files that these replace: a run killed after its record leaves some of both.
    #[serde(default)]
    pub earlier: Vec<(String, Checksum)>,
    pub notes: Vec<String>,
    pub seconds: f64,
}

/// Reads the record of a figure in `folder`, if there is one whose files are unchanged.
pub(super) fn read_record(folder: &Path, figure: PaperFigure) -> Option<FigureRecord> {
    let record: FigureRecord = Records::of(folder).read(figure.name())?;
    let is_whole = |(name, content): &(String, Checksum)| content.is_of(&folder.join(name));
    (record.of.figure == figure && record.of.files.iter().all(is_whole)).then_some(record)
}

/// Checks that `folder` is free or holds figures that this program began, and that no folder of records is a link.
pub(super) fn check_folder(folder: &Path) -> Result<()> {
    let parts = [RECORDS_FOLDER, &format!("{RECORDS_FOLDER}/{PIECES_FOLDER}")];
    if may_begin(folder, OutputKind::Figures, &parts)? {
        return Ok(());
    }
    let problem = "this folder holds files, but no figures that this program began";
    Err(Error::new(ErrorKind::InTheWay, problem, "name a new or an empty folder").about(folder))
}

/// Writes the folder's mark, creates the folders of records, and removes files that killed runs have left.
pub(super) fn begin(folder: &Path) -> Result<()> {
    remove_abandoned(folder);
    let mark = claiming(OutputKind::Figures, &());
    write_whole(&folder.join(OutputKind::Figures.file()), |out| out.write_all(mark.as_bytes()))?;
    Records::of(folder).begin()?;
    Pieces::of(folder).records.begin()
}

#[derive(Debug, Clone)]
pub(super) struct Pieces {
    records: Records,
}

/// Part of a figure, as its record keeps it.
#[derive(Serialize, Deserialize)]
struct Piece<T> {
    value: T,
}

impl Pieces {
    pub fn of(folder: &Path) -> Self {
        Self { records: Records::of(folder).below(PIECES_FOLDER) }
    }

    /// The piece `name` if it was made from these settings.
    pub fn get<T: DeserializeOwned>(&self, name: &str, settings: &str) -> Option<T> {
        let Record { made_from, of } = self.records.read::<Piece<T>>(name)?;
        (made_from == MadeFrom::new(settings)).then_some(of.value)
    }

    pub fn keep<T: Serialize>(&self, name: &str, settings: &str, value: &T) -> Result<()> {
        self.records.write(name, &Record { made_from: MadeFrom::new(settings), of: Piece { value } })
    }

    /// A folder for files that are needed only while a piece is made: [`Unfinished::new_path`], which exists.
    pub fn temporary(&self) -> Result<Unfinished> {
        let place = self.records.folder().join("work");
        let made = Unfinished::beside(&place).and_then(|made| std::fs::create_dir(made.new_path()).map(|()| made));
        made.map_err(|error| Error::unwritten(&place, &error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_of_their_settings_and_other_peoples_folders_are_left_alone() {
        let home = tempfile::tempdir().expect("a folder");
        std::fs::write(home.path().join("thesis.txt"), "").expect("written");
        assert!(check_folder(home.path()).is_err_and(|error| error.kind == ErrorKind::InTheWay));
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
