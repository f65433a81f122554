//! Camera poses: errors of an estimated trajectory against a known one.
//!
//! Structure from motion returns cameras in a world of its own: its origin, directions and scale are arbitrary. So
//! corresponding poses are [paired](mod@associate), the similarity that best aligns the estimate with the truth is
//! [found](mod@align), and the remaining difference is the [error](report): of each pose by itself (absolute trajectory
//! error) and from one pose to the next (relative pose error). [`evaluate_poses`] does all of it.
//!
//! Poses come from COLMAP's [sparse models](sparse) and from [trajectory files](tum). A [`Pose`] always holds the
//! camera in the world (its centre and the rotation from camera to world axes), whatever the file holds.

pub mod align;
pub mod associate;
pub mod report;
pub mod sparse;
pub mod tum;

pub use align::{Alignment, PlaneAxes, Projection, Similarity, align};
pub use associate::{Association, Pairing, associate};
pub use report::{ErrorSummary, PairReport, PoseErrors, PoseReport, PoseStudy, evaluate_poses};
pub use sparse::{ModelSummary, SparseModel, read_sparse_model};
pub use tum::read_tum;

use nalgebra::Isometry3;
use std::path::{Path, PathBuf};

/// The pose of a camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// Name of the image, or the time as written in the file.
    pub label: String,
    /// Position in its sequence, from 0; images that were not registered leave gaps.
    pub order: u32,
    /// Time stamp, in the file's unit; models have none.
    pub time: Option<f64>,
    /// Map from camera coordinates to world coordinates: its translation is the camera's centre.
    pub world_from_camera: Isometry3<f64>,
}

/// Trajectory of an estimate or a truth, as read from files.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Poses, in ascending [`Pose::order`].
    pub poses: Vec<Pose>,
    /// The sparse model that the poses come from; absent for a trajectory file.
    pub model: Option<SparseModel>,
}

/// Reads the poses at `path`: the folder of a sparse model (see [`read_sparse_model`]) or a file in it, or a trajectory
/// file (see [`read_tum`]).
///
/// # Errors
/// See [`PoseError`].
pub fn read_trajectory(path: &Path) -> Result<Trajectory, PoseError> {
    let folder = if path.is_dir() { Some(path) } else { sparse::folder_of_file(path) };
    if let Some(folder) = folder {
        let model = read_sparse_model(folder)?;
        Ok(Trajectory { poses: model.poses(), model: Some(model) })
    } else {
        Ok(Trajectory { poses: read_tum(path)?, model: None })
    }
}

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
    fn read(path: &Path, error: &std::io::Error) -> Self {
        let reason = match error.kind() {
            std::io::ErrorKind::NotFound => "there is no such file or folder; check the spelling".to_owned(),
            _ => error.to_string(),
        };
        Self::Read { path: path.into(), reason }
    }

    fn corrupt(path: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Corrupt { path: path.into(), place: place.into(), problem: problem.into() }
    }
}
