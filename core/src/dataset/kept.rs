//! Why features that were kept are not taken for those of a burst.

use super::DatasetError;

/// Why the features of a burst are found anew, though a folder of kept features is there.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotKept {
    /// The folder has no record of this burst: it is not finished there.
    #[error("it is not finished there")]
    NoRecord,
    /// Another version of the program found them.
    #[error("another version of the program found its features")]
    OtherProgram,
    /// They were found with other options, which are named.
    #[error("its features were found with other options ({})", .0.join(", "))]
    OtherOptions(Vec<String>),
    /// They were found in other frames.
    #[error("its features were found in other frames, or the frames have changed since")]
    OtherFiles,
    /// The file of features is not the one that was written.
    #[error("its file of features is missing or was altered")]
    Altered,
    /// It could not be looked at.
    #[error(transparent)]
    Failed(#[from] DatasetError),
}
