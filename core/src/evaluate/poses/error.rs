//! Why there are no poses, or no comparison of them.

use std::path::{Path, PathBuf};

/// Why poses could not be read or compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// The system would not let it be read.
    #[error("cannot read this: {reason}: {}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// A folder without a sparse model.
    #[error(
        "this folder holds no sparse model (images.bin and points3D.bin, or images.txt and points3D.txt), nor do its subfolders; \
         name the folder that COLMAP's mapper wrote: {}",
        path.display()
    )]
    NoModel {
        /// The folder.
        path: PathBuf,
    },
    /// A file that does not hold what its kind should.
    #[error("{place}: {problem}: {}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// Where in the file, such as "line 3" or "image 2 of 5".
        place: String,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// A file or model without a single pose.
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
        /// Why not, and what would help.
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
        /// What is wrong.
        problem: String,
        /// What would be right.
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
