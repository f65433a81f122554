//! Errors of a detection.

use super::params::ParamError;
use crate::monitor::Cancelled;

/// Reason why there is no detection.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DetectError {
    /// A parameter makes no sense for this burst.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The detection was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
