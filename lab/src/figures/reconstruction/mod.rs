//! Tables 1 to 3 and Fig. 8: trajectories of dark bursts, matched and reconstructed.
//!
//! A study is a list of runs: one method on one trajectory. A run's numbers are kept as a piece, so that the tables
//! share them and an interrupted study continues; COLMAP's result of a run is a separate piece.

mod mapper;
mod study;
mod tables;

use super::{FigureSize, Made, MakeFigure, record::Pieces};
use burstscope_core::{error::Result, monitor::Monitor};
use std::path::{Path, PathBuf};
use study::Study;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shown {
    /// Table 1.
    Matching,
    /// Table 2.
    Poses,
    /// Table 3.
    Time,
    /// Fig. 8.
    Trajectories,
}

pub(super) struct ReconstructionFigure {
    shown: Shown,
    study: Study,
    colmap: Option<PathBuf>,
}

impl std::fmt::Debug for ReconstructionFigure {
    /// Only the presence of COLMAP counts, not its path.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ReconstructionFigure")
            .field("shown", &self.shown)
            .field("study", &self.study)
            .field("colmap", &self.colmap.is_some())
            .finish()
    }
}

impl ReconstructionFigure {
    pub fn new(shown: Shown, size: FigureSize, colmap: Option<&Path>) -> Self {
        // Without the database COLMAP has no input.
        let colmap = colmap.filter(|_| cfg!(feature = "colmap")).map(Path::to_path_buf);
        Self { shown, study: Study::new(size), colmap }
    }
}

impl MakeFigure for ReconstructionFigure {
    fn make(&self, pieces: &Pieces, monitor: &Monitor) -> Result<Made> {
        let runs = self.study.runs(pieces, self.colmap.as_deref(), monitor)?;
        let missing = self.colmap.is_none().then_some(match cfg!(feature = "colmap") {
            true => "COLMAP's program was not found (pycolmap alone is not enough), so the columns that need a reconstruction are empty (–). Install it and run the command again: finished results are kept.",
            false => "This program was built without the feature colmap, so the columns that need a reconstruction are empty (–).",
        });
        Ok(match self.shown {
            Shown::Matching => tables::matching(&self.study, &runs, missing),
            Shown::Poses => tables::poses(&self.study, &runs, missing),
            Shown::Time => tables::time(&self.study, &runs, missing),
            Shown::Trajectories => tables::trajectories(&runs, missing),
        })
    }
}
