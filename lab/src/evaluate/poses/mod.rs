//! Camera poses: errors of an estimated trajectory against a known one.
//!
//! Structure from motion returns cameras in a world of arbitrary origin, directions and scale. So corresponding poses
//! are [paired](mod@associate), the similarity that best aligns the estimate with the truth is [found](mod@align), and
//! the rest is the [error](report) of poses (absolute) and of motions between them (relative): see [`evaluate_poses`].
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

use burstscope_core::error::{Error, ErrorKind, Result};
use nalgebra::Isometry3;
use std::{fmt::Display, path::Path};

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

/// Reads the poses at `path`: the folder of a sparse model (see [`read_sparse_model`]) or a file in it, a trajectory
/// file (see [`read_tum`]), or one that is built in.
///
/// # Errors
/// The file or model cannot be read, is damaged, or has no pose.
pub fn read_trajectory(path: &Path) -> Result<Trajectory> {
    if let Some(trajectory) = built_in(path) {
        return trajectory;
    }
    let folder = if path.is_dir() { Some(path) } else { sparse::folder_of_file(path) };
    if let Some(folder) = folder {
        let model = read_sparse_model(folder)?;
        Ok(Trajectory { poses: model.poses(), model: Some(model) })
    } else {
        Ok(Trajectory { poses: read_tum(path)?, model: None })
    }
}

fn unread(path: &Path, error: &std::io::Error) -> Error {
    match error.kind() {
        std::io::ErrorKind::NotFound => Error::unread(path, "there is no such file or folder; check the spelling"),
        _ => Error::unread(path, error),
    }
}

/// Error for the content of a file at a place such as "line 3" or "image 2 of 5"; `problem` says what would be right.
fn corrupt(path: &Path, place: &str, problem: impl Display) -> Error {
    Error::new(ErrorKind::Damaged, format!("{place}: {problem}"), "").about(path)
}

fn no_pose(path: &Path) -> Error {
    let problem = "there is no pose in this; a reconstruction that failed has none";
    Error::new(ErrorKind::NotFound, problem, "").about(path)
}

// A reconstruction that is built in, for lessons: eight dark bursts of a way forward and to the side, past 4 planes.
//
// Made by the program from the 300 strongest features of each burst, and by COLMAP's mapper (pycolmap 4.2.1). Stored
// as that wrote it, in text, but without the keypoints that became no points and with fewer digits:
//
// ```sh
// burstscope synth trajectory --motion 2d --bursts 8 --read-noise 80 --out way
// burstscope colmap way/bursts --out rec --camera way/lens.toml --max-features 300
// python3 -c "import pycolmap; pycolmap.incremental_mapping('rec/database.db', 'rec/images', 'rec/sparse')"
// ```

/// Name of the built-in estimate; a folder of that name is given as `./demo-cameras`.
pub const DEMO_ESTIMATE: &str = "demo-cameras";
/// Name of the true poses.
pub const DEMO_TRUTH: &str = "demo-cameras-truth";

/// Whether `path` is the name of a built-in trajectory.
pub fn is_built_in(path: &Path) -> bool {
    [DEMO_ESTIMATE, DEMO_TRUTH].iter().any(|name| path.as_os_str() == *name)
}

fn built_in(path: &Path) -> Option<Result<Trajectory>> {
    let truth = || Ok(Trajectory { poses: tum::parse_tum(include_str!("demo/truth.txt"), path)?, model: None });
    let estimate = || {
        let model = SparseModel::of_text(include_str!("demo/images.txt"), include_str!("demo/points3D.txt"), path)?;
        Ok(Trajectory { poses: model.poses(), model: Some(model) })
    };
    match path.to_str()? {
        DEMO_ESTIMATE => Some(estimate()),
        DEMO_TRUTH => Some(truth()),
        _ => None,
    }
}
