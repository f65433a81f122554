//! The figures one after the other, into a folder.

use super::page::write_page;
use super::record::{MadeFrom, Pieces, Record, begin, check_folder};
use super::{FigureSize, FiguresError, Made, PaperFigure};
use crate::dataset::Checksum;
use crate::export::{ExportError, OutputRules, write_whole};
use crate::files::lock::FolderLock;
use crate::monitor::Monitor;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Which figures are made, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FiguresJob {
    /// The folder, which is made.
    pub out: PathBuf,
    /// Only these; empty for all.
    pub only: Vec<PaperFigure>,
    /// How large the material is.
    pub size: FigureSize,
    /// COLMAP's program for what it is needed for; without it those columns are said to be missing.
    pub colmap: Option<PathBuf>,
}

/// What happens, as it happens.
#[derive(Debug)]
pub enum FiguresEvent<'a> {
    /// A figure is begun.
    Begin {
        /// Which one.
        figure: PaperFigure,
        /// Its place among those that are made, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A figure is finished, now or by an earlier run.
    Done(&'a FigureReport),
}

/// A figure that is finished.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FigureReport {
    /// Which one.
    pub figure: PaperFigure,
    /// Its picture and its numbers.
    pub files: Vec<PathBuf>,
    /// What a reader must know, such as what is missing; sentences.
    pub notes: Vec<String>,
    /// Whether an earlier run had made it.
    pub resumed: bool,
    /// How long it took, then or now.
    pub seconds: f64,
}

/// What was made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FiguresReport {
    /// The page that shows all.
    pub page: PathBuf,
    /// The size of the material.
    pub size: FigureSize,
    /// The figures that were asked for.
    pub figures: Vec<FigureReport>,
}

/// COLMAP's program where the system looks for programs; `None` where it is not installed.
pub fn find_colmap() -> Option<PathBuf> {
    let names: &[&str] = if cfg!(windows) { &["colmap.exe", "COLMAP.bat"] } else { &["colmap"] };
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    folders.iter().flat_map(|folder| names.iter().map(|name| folder.join(name))).find(|path| path.is_file())
}

impl FiguresJob {
    /// The figures that are made, in order, each once.
    fn wanted(&self) -> Vec<PaperFigure> {
        let is_wanted = |figure: &PaperFigure| self.only.is_empty() || self.only.contains(figure);
        PaperFigure::ALL.into_iter().filter(is_wanted).collect()
    }

    /// Makes the figures that are not finished yet, and the page. `on` hears what happens.
    ///
    /// # Errors
    /// See [`FiguresError`]. Files are written whole or not at all; finished figures stay finished.
    pub fn run(&self, on: &mut dyn FnMut(FiguresEvent<'_>), monitor: &Monitor) -> Result<FiguresReport, FiguresError> {
        check_folder(&self.out)?;
        let lock = FolderLock::take(&self.out).map_err(ExportError::from)?;
        begin(&self.out)?;
        let pieces = Pieces::of(&self.out);
        let wanted = self.wanted();
        let total: f32 = wanted.iter().map(|figure| figure.cost_secs(self.size)).sum();
        let mut figures = Vec::with_capacity(wanted.len());
        let mut done = 0.0;
        for (index, &figure) in wanted.iter().enumerate() {
            monitor.check()?;
            on(FiguresEvent::Begin { figure, index, count: wanted.len() });
            let cost = figure.cost_secs(self.size);
            let report = self.one(figure, &pieces, &lock, &monitor.part(done / total, cost / total))?;
            done += cost;
            on(FiguresEvent::Done(&report));
            figures.push(report);
        }
        lock.check().map_err(ExportError::from)?;
        let page = write_page(&self.out, self.size)?;
        Ok(FiguresReport { page, size: self.size, figures })
    }

    /// One figure: as it is, or made and written.
    fn one(
        &self,
        figure: PaperFigure,
        pieces: &Pieces,
        lock: &FolderLock,
        monitor: &Monitor,
    ) -> Result<FigureReport, FiguresError> {
        let maker = figure.maker(self.size, self.colmap.as_deref());
        let made_from = MadeFrom::new(format!("{maker:?}"));
        let kept = Record::read(&self.out, figure).filter(|record| record.made_from == made_from);
        let resumed = kept.is_some();
        let record = match kept {
            Some(record) => record,
            None => {
                let started = Instant::now();
                let made = maker.make(pieces, monitor)?;
                monitor.check()?;
                lock.check().map_err(ExportError::from)?;
                self.write(figure, made, made_from, started.elapsed().as_secs_f64())?
            }
        };
        let files = record.files.iter().map(|(name, _)| self.out.join(name)).collect();
        Ok(FigureReport { figure, files, notes: record.notes, resumed, seconds: record.seconds })
    }

    fn write(
        &self,
        figure: PaperFigure,
        made: Made,
        made_from: MadeFrom,
        seconds: f64,
    ) -> Result<Record, FiguresError> {
        Record::remove(&self.out, figure)?;
        let mut files = Vec::with_capacity(2);
        for (ending, text) in [("svg", &made.svg), ("csv", &made.csv)] {
            let name = format!("{}.{ending}", figure.name());
            write_text(&self.out.join(&name), text)?;
            files.push((name, Checksum::of(text.as_bytes())));
        }
        let record = Record { figure, made_from, files, notes: made.notes, seconds };
        record.write(&self.out)?;
        Ok(record)
    }
}

fn write_text(path: &Path, text: &str) -> Result<(), FiguresError> {
    OutputRules::default().check_own(path)?;
    Ok(write_whole(path, |out| out.write_all(text.as_bytes()))?)
}
