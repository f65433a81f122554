//! Camera poses: how far an estimated trajectory is from a known one.
//!
//! Structure from motion answers with cameras in a world of its own: its origin, directions and scale mean nothing. So
//! the poses that belong together are [paired](mod@associate), the similarity that lays the estimate on the truth best
//! is [found](mod@align), and what is left over is the [error](errors): of each pose by itself (absolute trajectory
//! error) and from one pose to the next (relative pose error). [`evaluate_poses`] does all of it.
//!
//! Poses come from COLMAP's [sparse models](sparse) and from [trajectory files](tum). A [`Pose`] always holds the
//! camera in the world (its centre and the rotation from camera to world axes), whatever the file holds.

pub mod align;
pub mod associate;
mod error;
pub mod errors;
pub mod plane;
mod report;
pub mod sparse;
pub mod tum;

pub use align::{Alignment, Similarity, align};
pub use associate::{Association, Pairing, associate};
pub use error::PoseError;
pub use errors::{ErrorSummary, PoseErrors};
pub use plane::{PlaneAxes, Projection};
pub use report::{PairReport, PoseReport, PoseStudy, evaluate_poses};
pub use sparse::{ModelSummary, SparseModel, read_sparse_model};
pub use tum::read_tum;

use nalgebra::Isometry3;
use std::path::Path;

/// The pose of a camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// The image's name, or the time as the file writes it.
    pub label: String,
    /// Its place in its sequence, from 0; images that were not registered leave gaps.
    pub order: u32,
    /// The time stamp, in whatever unit the file has; models have none.
    pub time: Option<f64>,
    /// From camera coordinates to those of the world: its translation is the camera's centre.
    pub world_from_camera: Isometry3<f64>,
}

/// What was read of an estimate or a truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// The poses, by rising [`Pose::order`].
    pub poses: Vec<Pose>,
    /// What else a sparse model tells; absent for a trajectory file.
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
