//! Errors of reading and comparing poses.

use std::path::{Path, PathBuf};

/// Reason why poses could not be read or compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// The file or folder could not be read.
    #[error("cannot read this: {reason}: {}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// The folder holds no sparse model.
    #[error(
        "this folder holds no sparse model (images.bin and points3D.bin, or images.txt and points3D.txt), nor do its subfolders; \
         name the folder that COLMAP's mapper wrote: {}",
        path.display()
    )]
    NoModel {
        /// The folder.
        path: PathBuf,
    },
    /// The file's content does not fit its kind.
    #[error("{place}: {problem}: {}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// Place in the file, such as "line 3" or "image 2 of 5".
        place: String,
        /// Problem, and what would be right.
        problem: String,
    },
    /// The file or model has no pose.
    #[error("there is no pose in this; a reconstruction that failed has none: {}", path.display())]
    Empty {
        /// The file or folder.
        path: PathBuf,
    },
    /// The poses of estimate and truth cannot be paired.
    #[error("the poses of estimate and truth cannot be paired {by}: {problem}")]
    Unpaired {
        /// The rule that was tried, such as "by name".
        by: &'static str,
        /// Reason, and what would help.
        problem: String,
    },
    /// Too few pairs, or cameras that do not move.
    #[error("the trajectories cannot be aligned: {0}")]
    Degenerate(String),
    /// A parameter of the study makes no sense.
    #[error("{parameter}: {problem}; {remedy}")]
    Param {
        /// Name of the parameter to change, as on the command line without the dashes.
        parameter: &'static str,
        /// Problem with its value.
        problem: String,
        /// Suggested change.
        remedy: &'static str,
    },
}

impl PoseError {
    pub(super) fn read(path: &Path, error: &std::io::Error) -> Self {
        let reason = match error.kind() {
            std::io::ErrorKind::NotFound => "there is no such file or folder; check the spelling".to_owned(),
            _ => error.to_string(),
        };
        Self::Read { path: path.into(), reason }
    }

    pub(super) fn corrupt(path: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Corrupt { path: path.into(), place: place.into(), problem: problem.into() }
    }
}
