//! Why a detection gives no answer.

use super::params::ParamError;
use crate::monitor::Cancelled;

/// Why there is no detection.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DetectError {
    /// A parameter makes no sense for this burst.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// It was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
