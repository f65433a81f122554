//! Errors of requests.

use super::source::BurstSource;
use crate::dataset::DatasetError;
use crate::detector::DetectError;
use crate::evaluate::EvaluateError;
use crate::figures::FiguresError;
use crate::inspect::ProbeError;
use crate::matching::MatchError;
use crate::monitor::Cancelled;

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum JobError {
    #[error("cancelled")]
    Cancelled,
    #[error("a newer request took its place")]
    Superseded,
    /// The input, a parameter or a limit is at fault; the message says which and what would be right.
    #[error("{0}")]
    Failed(String),
    #[error("there are {} bursts here; open one of them", .0.len())]
    Several(Vec<BurstSource>),
    #[error("this is a mistake in Burstscope, please report it: {message} (at {place})")]
    Panicked {
        message: String,
        /// File, line and column.
        place: String,
    },
}

impl JobError {
    pub(super) fn failed(error: impl std::fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }

    fn of(error: &impl std::fmt::Display, is_cancelled: bool) -> Self {
        if is_cancelled { Self::Cancelled } else { Self::failed(error) }
    }
}

impl From<Cancelled> for JobError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<DetectError> for JobError {
    fn from(error: DetectError) -> Self {
        Self::of(&error, matches!(error, DetectError::Cancelled(_)))
    }
}

impl From<MatchError> for JobError {
    fn from(error: MatchError) -> Self {
        Self::of(&error, matches!(error, MatchError::Cancelled(_)))
    }
}

impl From<ProbeError> for JobError {
    fn from(error: ProbeError) -> Self {
        Self::of(&error, matches!(error, ProbeError::Cancelled(_)))
    }
}

impl From<DatasetError> for JobError {
    fn from(error: DatasetError) -> Self {
        Self::of(&error, matches!(error, DatasetError::Cancelled(_)))
    }
}

impl From<EvaluateError> for JobError {
    fn from(error: EvaluateError) -> Self {
        Self::of(&error, matches!(error, EvaluateError::Cancelled(_)))
    }
}

impl From<FiguresError> for JobError {
    fn from(error: FiguresError) -> Self {
        Self::of(&error, matches!(error, FiguresError::Cancelled(_)))
    }
}
