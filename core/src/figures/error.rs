//! Errors of making figures.

use crate::dataset::DatasetError;
use crate::detector::DetectError;
use crate::evaluate::EvaluateError;
use crate::export::ExportError;
use crate::matching::MatchError;
use crate::monitor::Cancelled;
use crate::synth::{SynthError, WriteBurstError};
use std::path::PathBuf;

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

impl From<MatchError> for FiguresError {
    fn from(error: MatchError) -> Self {
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
