//! Errors of datasets.

use crate::burst::OpenError;
use crate::detector::{DetectError, ParamError};
use crate::export::ExportError;
use crate::files::lock::LockError;
use crate::matching::MatchError;
use crate::monitor::Cancelled;
use std::path::PathBuf;

/// Reason why a burst, or the whole dataset, has no result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The work was cancelled. Finished bursts stay finished.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A burst cannot be opened.
    #[error(transparent)]
    Open(OpenError),
    /// A parameter makes no sense.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// A file cannot be written or read back.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The folder holds other files.
    #[error("this folder holds files, but no dataset that was begun by this command; name a new or an empty folder: {}", .0.display())]
    Occupied(PathBuf),
    /// Fewer than two bursts have features.
    #[error(
        "{0} bursts have features, and matching needs two or more; name a folder of bursts, or cut a long sequence with --burst-length"
    )]
    TooFew(usize),
    /// The images have a size that the camera does not have.
    #[error("the camera is given for images of {}×{}, but this burst has {}×{}; give the camera of these images", camera.0, camera.1, images.0, images.1)]
    CameraSize {
        /// (columns, rows) of the camera.
        camera: (usize, usize),
        /// (columns, rows) of the images.
        images: (usize, usize),
    },
}

impl DatasetError {
    /// Whether the error concerns the whole dataset, so that the other bursts cannot continue. (Parameters are checked
    /// before the first burst; a later parameter error concerns only one burst, such as one with too few frames.)
    pub(super) fn is_final(&self) -> bool {
        !matches!(self, Self::Open(_) | Self::Param(_))
    }
}

impl From<LockError> for DatasetError {
    fn from(error: LockError) -> Self {
        Self::Export(error.into())
    }
}

impl From<OpenError> for DatasetError {
    fn from(error: OpenError) -> Self {
        if error.is_cancelled() { Self::Cancelled(Cancelled) } else { Self::Open(error) }
    }
}

impl From<DetectError> for DatasetError {
    fn from(error: DetectError) -> Self {
        match error {
            DetectError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            DetectError::Param(param) => Self::Param(param),
        }
    }
}

impl From<MatchError> for DatasetError {
    fn from(error: MatchError) -> Self {
        match error {
            MatchError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            MatchError::Param(param) => Self::Param(param),
        }
    }
}
