//! Records of finished figures, so that an interrupted run continues: see [`Records`].
//!
//! `records/NAME.json` names all that a figure was made from and the checksums of its files. [`Pieces`] stores, in the
//! same way, parts that take long and are used by several figures.

use super::PaperFigure;
use burstscope_core::error::{Error, ErrorKind, Result};
use burstscope_core::export::{MadeFrom, RECORDS_FOLDER, Record, Records, may_begin, write_whole};
use burstscope_core::files::mark::{Checksum, OutputKind, claiming};
use burstscope_core::files::unfinished::{Unfinished, remove_abandoned};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::{io::Write, path::Path};

const PIECES_FOLDER: &str = "pieces";

pub(super) type FigureRecord = Record<KeptFigure>;

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

#[derive(Serialize, Deserialize)]
struct Piece<T> {
    value: T,
}

impl Pieces {
    pub fn of(folder: &Path) -> Self {
        Self { records: Records::of(folder).below(PIECES_FOLDER) }
    }

    /// The piece `name` of these settings: the kept one, or else the result of `make`, which is kept then.
    pub fn kept_or<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        settings: &str,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        let made_from = MadeFrom::new(settings);
        let kept = self.records.read::<Piece<T>>(name).filter(|kept| kept.made_from == made_from);
        if let Some(kept) = kept {
            return Ok(kept.of.value);
        }
        let value = make()?;
        self.records.write(name, &Record { made_from, of: Piece { value: &value } })?;
        Ok(value)
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
    fn pieces_are_of_their_settings() {
        let home = tempfile::tempdir().expect("a folder");
        begin(home.path()).expect("begun");
        let pieces = Pieces::of(home.path());
        for (settings, made, kept) in [("seed 1", 1.5, 1.5), ("seed 1", 2.0, 1.5), ("seed 2", 2.0, 2.0)] {
            assert_eq!(pieces.kept_or("row", settings, || Ok(made)), Ok(kept));
        }
        assert_eq!(pieces.kept_or("row", "seed 2", || Ok("text".to_owned())), Ok("text".to_owned()));
    }
}
