//! COLMAP's sparse models: registered images with their poses, and the points that they have in common.
//!
//! A model is a folder of files, all in binary or all in text. Only data about poses and points is read: `images`
//! (pose, name, the keypoints that became points) and `points3D` (reprojection error, length of the track); intrinsics,
//! positions of keypoints and colours are skipped. Format: <https://colmap.github.io/format.html>.

mod binary;
mod text;

use super::{Pose, PoseError};
use nalgebra::{Isometry3, Quaternion, Translation3};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A registered image.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseImage {
    /// Id in the database, 1 or more.
    pub id: u32,
    /// Name of its file, relative to the folder of images.
    pub name: String,
    /// Number of keypoints.
    pub keypoints: usize,
    /// Number of keypoints that became points of the model.
    pub points: usize,
    /// Map from camera coordinates (x right, y down, z ahead) to those of the model's world.
    pub world_from_camera: Isometry3<f64>,
}

/// A point of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparsePoint {
    /// Mean reprojection error over its keypoints, pixels.
    pub reprojection_error_px: f64,
    /// Number of keypoints in which it was seen.
    pub track_length: usize,
}

/// A sparse model.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseModel {
    /// The folder that it was read from.
    pub folder: PathBuf,
    /// Registered images, in ascending id.
    pub images: Vec<SparseImage>,
    /// Points, in the file's order.
    pub points: Vec<SparsePoint>,
    /// Number of further models beside this one: parts that could not be joined with it.
    pub other_models: usize,
}

/// Statistics of a model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ModelSummary {
    /// Number of images with a pose.
    pub registered_images: usize,
    /// Number of points of the model.
    pub points: usize,
    /// Number of points that an image sees, mean over the registered images. (Each point is counted in every image that
    /// sees it.)
    pub points_per_image: f64,
    /// Number of keypoints of a point, mean over the points; NaN (null in JSON) without points.
    pub mean_track_length: f64,
    /// Mean reprojection error of the points, pixels; NaN (null in JSON) without points.
    pub mean_reprojection_error_px: f64,
}

impl SparseModel {
    /// The poses of its images. Their order is their id minus 1, because ids count up from 1 in the order in which
    /// images came into the database.
    pub fn poses(&self) -> Vec<Pose> {
        let pose = |image: &SparseImage| Pose {
            label: image.name.clone(),
            order: image.id.saturating_sub(1),
            time: None,
            world_from_camera: image.world_from_camera,
        };
        self.images.iter().map(pose).collect()
    }

    /// The statistics of the model.
    pub fn summary(&self) -> ModelSummary {
        let points = self.points.len() as f64;
        let observations: usize = self.images.iter().map(|i| i.points).sum();
        ModelSummary {
            registered_images: self.images.len(),
            points: self.points.len(),
            points_per_image: observations as f64 / self.images.len() as f64,
            mean_track_length: self.points.iter().map(|p| p.track_length as f64).sum::<f64>() / points,
            mean_reprojection_error_px: self.points.iter().map(|p| p.reprojection_error_px).sum::<f64>() / points,
        }
    }
}

/// The folder of a sparse model that `path` is a file of, judging by the file's name.
pub(super) fn folder_of_file(path: &Path) -> Option<&Path> {
    let stem = path.file_stem()?.to_str()?;
    let ending = path.extension()?.to_str()?;
    let of_model =
        ["images", "points3D", "cameras", "rigs", "frames"].contains(&stem) && ["bin", "txt"].contains(&ending);
    path.parent().filter(|_| of_model).map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p })
}

/// Reads the sparse model in `folder`; binary files are preferred to text. If there is none in the folder itself but
/// some in its subfolders (COLMAP's mapper writes `0`, `1`, … for parts that it could not join), reads the one with the
/// most registered images.
///
/// # Errors
/// [`PoseError`] when there is no model, a file of it cannot be read or is damaged, or no image is registered.
pub fn read_sparse_model(folder: &Path) -> Result<SparseModel, PoseError> {
    if let Some(reader) = Format::of(folder) {
        return reader.read(folder);
    }
    let fail = |e: std::io::Error| PoseError::read(folder, &e);
    let entries = std::fs::read_dir(folder).map_err(fail)?.collect::<Result<Vec<_>, _>>().map_err(fail)?;
    let mut folders: Vec<PathBuf> = entries.into_iter().map(|e| e.path()).filter(|p| p.is_dir()).collect();
    folders.sort();
    let mut models = Vec::new();
    for subfolder in folders {
        if let Some(reader) = Format::of(&subfolder) {
            match reader.read(&subfolder) {
                Err(PoseError::Empty { .. }) => {}
                model => models.push(model?),
            }
        }
    }
    let other_models = models.len().saturating_sub(1);
    // The first of several of equal size.
    let largest = models.into_iter().rev().max_by_key(|m| m.images.len());
    match largest {
        Some(model) => Ok(SparseModel { other_models, ..model }),
        None => Err(PoseError::NoModel { path: folder.into() }),
    }
}

/// Format of a model's files.
#[derive(Debug, Clone, Copy)]
enum Format {
    Binary,
    Text,
}

impl Format {
    /// The format of the model in `folder`, if there is one.
    fn of(folder: &Path) -> Option<Self> {
        let has = |name: &str| folder.join(name).is_file();
        if has("images.bin") && has("points3D.bin") {
            Some(Self::Binary)
        } else if has("images.txt") && has("points3D.txt") {
            Some(Self::Text)
        } else {
            None
        }
    }

    fn read(self, folder: &Path) -> Result<SparseModel, PoseError> {
        let (mut images, points) = match self {
            Self::Binary => {
                (binary::read_images(&folder.join("images.bin"))?, binary::read_points(&folder.join("points3D.bin"))?)
            }
            Self::Text => {
                (text::read_images(&folder.join("images.txt"))?, text::read_points(&folder.join("points3D.txt"))?)
            }
        };
        if images.is_empty() {
            return Err(PoseError::Empty { path: folder.into() });
        }
        images.sort_by_key(|i| i.id);
        if let Some(pair) = images.windows(2).find(|pair| pair[0].id == pair[1].id) {
            let problem = format!("there are two images of the id {}", pair[0].id);
            return Err(PoseError::corrupt(folder, "images", problem));
        }
        Ok(SparseModel { folder: folder.into(), images, points, other_models: 0 })
    }
}

/// The camera in the world from the values in a model, which give the world in the camera: quaternion `w x y z` and
/// translation.
fn world_from_camera(quaternion: [f64; 4], translation: [f64; 3]) -> Result<Isometry3<f64>, String> {
    let [w, x, y, z] = quaternion;
    let rotation = super::tum::rotation(Quaternion::new(w, x, y, z))?;
    if let Some(odd) = translation.iter().find(|t| !t.is_finite()) {
        return Err(format!("its translation has the value {odd}"));
    }
    Ok(Isometry3::from_parts(Translation3::from(translation), rotation).inverse())
}

#[cfg(test)]
pub(super) mod tests;
