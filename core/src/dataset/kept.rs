//! Reasons why stored features of a burst are not used.

use super::DatasetError;

/// Reason why the features of a burst are found again although stored features exist.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotKept {
    /// The folder has no record of this burst: the burst is not finished there.
    #[error("it is not finished there")]
    NoRecord,
    /// The features were found by another version of the program.
    #[error("another version of the program found its features")]
    OtherProgram,
    /// The features were found with other options; these are named.
    #[error("its features were found with other options ({})", .0.join(", "))]
    OtherOptions(Vec<String>),
    /// The features were found in other frames.
    #[error("its features were found in other frames, or the frames have changed since")]
    OtherFiles,
    /// The file of features is missing or was altered.
    #[error("its file of features is missing or was altered")]
    Altered,
    /// The check failed.
    #[error(transparent)]
    Failed(#[from] DatasetError),
}
