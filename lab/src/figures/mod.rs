//! Every figure and table of the paper, reproduced from our own material: `burstscope figures --out DIR`.
//!
//! A [`PaperFigure`] is one of the paper's; `PaperFigure::NAME.svg` shows it and `NAME.csv` holds its numbers. Its
//! maker is a plain value with all of its parameters (charts, trajectories, methods), and a function from that value to
//! both files. [`FiguresJob`] runs them one after the other into a folder, keeps finished figures (a record names the
//! parameters they were made from), and writes a page, `index.html`, that shows all.
//!
//! Nothing here computes by itself: charts and curves come from [`crate::evaluate`], bursts from [`crate::synth`],
//! pictures of single steps from [`burstscope_core::detector::view`].

mod apparent_motion;
mod architecture;
mod charts;
mod drawing;
mod job;
mod matching;
mod pictures;
mod reconstruction;
mod record;
mod which;

pub use job::{FigureReport, FiguresEvent, FiguresJob, FiguresReport, find_colmap};
pub use which::{FigureSize, PaperFigure};

use crate::evaluate::EvaluateError;
use crate::synth::{SynthError, WriteBurstError};
use burstscope_core::dataset::DatasetError;
use burstscope_core::detector::DetectError;
use burstscope_core::export::ExportError;
use burstscope_core::monitor::{Cancelled, Monitor};
use record::Pieces;
use std::path::PathBuf;

/// Files of a figure, in memory.
#[derive(Debug, Clone, PartialEq)]
struct Made {
    /// The picture, a self-contained SVG.
    svg: String,
    /// Numbers of the figure.
    csv: String,
    /// Notes for the reader, such as missing columns; sentences.
    notes: Vec<String>,
}

/// All parameters of a figure, and the function that makes it. The `Debug` text names everything that the figure
/// depends on.
trait MakeFigure: std::fmt::Debug {
    /// Makes the figure. `pieces` stores parts that take long, for the next figure and the next run.
    fn make(&self, pieces: &Pieces, monitor: &Monitor) -> Result<Made, FiguresError>;
}

/// Reason why figures were not made. Figures finished before are kept.
#[derive(Debug, thiserror::Error)]
pub enum FiguresError {
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The folder holds other files.
    #[error("this folder holds files, but no figures that this program began; name a new or an empty folder: {}", .0.display())]
    Occupied(PathBuf),
    /// A file cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// A dataset cannot be written or read back, or another process writes into the folder.
    #[error(transparent)]
    Dataset(DatasetError),
    /// A study has no report.
    #[error(transparent)]
    Evaluate(EvaluateError),
    /// A burst cannot be written.
    #[error(transparent)]
    WriteBurst(WriteBurstError),
    /// COLMAP cannot be run.
    #[error("cannot run {}: {reason}; install COLMAP anew, or leave it out with --no-colmap", .program.display())]
    Colmap {
        /// Path of the program.
        program: PathBuf,
        /// The system's message.
        reason: String,
    },
}

impl From<EvaluateError> for FiguresError {
    fn from(error: EvaluateError) -> Self {
        match error {
            EvaluateError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Evaluate(other),
        }
    }
}

impl From<SynthError> for FiguresError {
    fn from(error: SynthError) -> Self {
        EvaluateError::from(error).into()
    }
}

impl From<DetectError> for FiguresError {
    fn from(error: DetectError) -> Self {
        EvaluateError::from(error).into()
    }
}

impl From<DatasetError> for FiguresError {
    fn from(error: DatasetError) -> Self {
        match error {
            DatasetError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Dataset(other),
        }
    }
}

impl From<WriteBurstError> for FiguresError {
    fn from(error: WriteBurstError) -> Self {
        match error {
            WriteBurstError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::WriteBurst(other),
        }
    }
}
