//! Errors of requests.

use super::BurstSource;
use crate::burst::Dump;
use crate::dataset::BurstPicture;
use crate::error::Error;
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
    /// A file without header: why it was not opened, and the shapes that fill it.
    #[error("{0}")]
    NoShape(String, Vec<PossibleShape>),
    #[error("this is a mistake in Burstscope, please report it: {message} (at {place})")]
    Panicked {
        message: String,
        /// File, line and column.
        place: String,
    },
}

#[derive(Debug, Clone, PartialEq)]
pub struct PossibleShape {
    pub dump: Dump,
    pub frames: u64,
    pub picture: BurstPicture,
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

impl From<Error> for JobError {
    fn from(error: Error) -> Self {
        if error.is_cancelled() { Self::Cancelled } else { Self::failed(error) }
    }
}
