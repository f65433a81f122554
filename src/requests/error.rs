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
    /// There is more than one burst at the place that was to be opened.
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
}

impl From<Cancelled> for JobError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<DetectError> for JobError {
    fn from(error: DetectError) -> Self {
        match error {
            DetectError::Cancelled(_) => Self::Cancelled,
            DetectError::Param(error) => Self::failed(error),
        }
    }
}

impl From<MatchError> for JobError {
    fn from(error: MatchError) -> Self {
        match error {
            MatchError::Cancelled(_) => Self::Cancelled,
            MatchError::Param(error) => Self::failed(error),
        }
    }
}

impl From<ProbeError> for JobError {
    fn from(error: ProbeError) -> Self {
        match error {
            ProbeError::Cancelled(_) => Self::Cancelled,
            other => Self::failed(other),
        }
    }
}

impl From<DatasetError> for JobError {
    fn from(error: DatasetError) -> Self {
        match error {
            DatasetError::Cancelled(_) => Self::Cancelled,
            other => Self::failed(other),
        }
    }
}

impl From<EvaluateError> for JobError {
    fn from(error: EvaluateError) -> Self {
        match error {
            EvaluateError::Cancelled(_) => Self::Cancelled,
            other => Self::failed(other),
        }
    }
}

impl From<FiguresError> for JobError {
    fn from(error: FiguresError) -> Self {
        match error {
            FiguresError::Cancelled(_) => Self::Cancelled,
            other => Self::failed(other),
        }
    }
}
