//! COLMAP's sparse models: registered images with their poses, and the points that they have in common.
//!
//! A model is a folder of files, all in binary or all in text. Only poses and points are read: `images` (pose, name,
//! keypoints that became points) and `points3D` (place, reprojection error, length of the track); intrinsics, positions
//! of keypoints and colours are skipped. Format: <https://colmap.github.io/format.html>.

mod reader;

use super::{Pose, corrupt, no_pose, unread};
use burstscope_core::error::{Error, ErrorKind, Result};
use nalgebra::{Isometry3, Quaternion, Translation3};
use reader::Reader;
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
#[derive(Debug, Clone, PartialEq)]
pub struct SparsePoint {
    /// Place in the model's world.
    pub position: [f64; 3],
    /// Mean reprojection error over its keypoints, pixels.
    pub reprojection_error_px: f64,
    /// Id of the image, and index of the keypoint in it, each time that the point is seen.
    pub track: Box<[[u32; 2]]>,
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
    /// Number of further models: parts that COLMAP could not join with this model.
    pub other_models: usize,
}

/// Statistics of a model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ModelSummary {
    /// Number of images with a pose.
    pub registered_images: usize,
    /// Number of points of the model.
    pub points: usize,
    /// Points that an image sees, mean over the registered images; a point counts in every image that sees it.
    pub points_per_image: f64,
    /// Number of keypoints of a point, mean over the points; NaN (null in JSON) without points.
    pub mean_track_length: f64,
    /// Mean reprojection error of the points, pixels; NaN (null in JSON) without points.
    pub mean_reprojection_error_px: f64,
}

impl SparseModel {
    /// Parses the text of a model; `name` is for messages. Errors as of [`read_sparse_model`].
    pub fn of_text(images: &str, points: &str, name: &Path) -> Result<Self> {
        let of = |text| Reader::new(str::as_bytes(text), None, name);
        Self::of(of(images).images()?, of(points).points()?, name)
    }

    fn of(mut images: Vec<SparseImage>, points: Vec<SparsePoint>, name: &Path) -> Result<Self> {
        if images.is_empty() {
            return Err(no_pose(name));
        }
        // Poses follow the ids, in whatever order the file has them.
        images.sort_by_key(|i| i.id);
        if let Some(pair) = images.windows(2).find(|pair| pair[0].id == pair[1].id) {
            return Err(corrupt(name, "images", format!("there are two images of the id {}", pair[0].id)));
        }
        Ok(Self { folder: name.into(), images, points, other_models: 0 })
    }

    /// Poses of the images. Their order is the id minus 1: ids count up from 1 as images came into the database.
    pub fn poses(&self) -> Vec<Pose> {
        let pose = |image: &SparseImage| Pose {
            label: image.name.clone(),
            order: image.id.saturating_sub(1),
            time: None,
            world_from_camera: image.world_from_camera,
        };
        self.images.iter().map(pose).collect()
    }

    /// Places of the images that see a point, with the indices of their keypoints.
    pub fn seen_by(&self, point: &SparsePoint) -> impl Iterator<Item = (usize, usize)> {
        let place = |id: u32| self.images.binary_search_by_key(&id, |image| image.id).ok();
        point.track.iter().filter_map(move |&[id, keypoint]| Some((place(id)?, keypoint as usize)))
    }

    /// Words on the part that was taken of a reconstruction in several; `None` where it is in one.
    pub fn taken(&self) -> Option<String> {
        let parts = self.other_models + 1;
        (parts > 1).then(|| format!("took {}, the largest of {parts} parts", self.folder.display()))
    }

    /// The statistics of the model.
    pub fn summary(&self) -> ModelSummary {
        let points = self.points.len() as f64;
        let observations: usize = self.images.iter().map(|i| i.points).sum();
        ModelSummary {
            registered_images: self.images.len(),
            points: self.points.len(),
            points_per_image: observations as f64 / self.images.len() as f64,
            mean_track_length: self.points.iter().map(|p| p.track.len() as f64).sum::<f64>() / points,
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

/// Reads the sparse model in `folder`, binary files before text; without one there, the model with the most registered
/// images in its subfolders (COLMAP's mapper writes `0`, `1`, … for parts that it could not join).
///
/// # Errors
/// There is no model, a file of it cannot be read or is damaged, or no image is registered.
pub fn read_sparse_model(folder: &Path) -> Result<SparseModel> {
    if let Some(model) = read_folder(folder) {
        return model;
    }
    let fail = |e: std::io::Error| unread(folder, &e);
    let entries = std::fs::read_dir(folder).map_err(fail)?.collect::<Result<Vec<_>, _>>().map_err(fail)?;
    let mut folders: Vec<PathBuf> = entries.into_iter().map(|e| e.path()).filter(|p| p.is_dir()).collect();
    folders.sort();
    let found = folders.iter().filter_map(|subfolder| read_folder(subfolder));
    // A model without a registered image is no model; a damaged one is reported.
    let found = found.filter(|model| model.as_ref().err().is_none_or(|error| error.kind != ErrorKind::NotFound));
    let models = found.collect::<Result<Vec<SparseModel>>>()?;
    let other_models = models.len().saturating_sub(1);
    // `max_by_key` takes the last of equally large models: in reverse that is the first folder's.
    let largest = models.into_iter().rev().max_by_key(|m| m.images.len());
    largest.map(|model| SparseModel { other_models, ..model }).ok_or_else(|| {
        let problem = "this folder holds no sparse model (images.bin and points3D.bin, or images.txt and \
                       points3D.txt), nor do its subfolders";
        Error::new(ErrorKind::NotFound, problem, "name the folder that COLMAP's mapper wrote").about(folder)
    })
}

/// The model that lies in `folder` itself, if there is one.
fn read_folder(folder: &Path) -> Option<Result<SparseModel>> {
    let is_there = |ending: &&str| ["images", "points3D"].iter().all(|name| file(folder, name, ending).is_file());
    let ending = ["bin", "txt"].into_iter().find(is_there)?;
    let reader = |name| Reader::open(&file(folder, name, ending), ending == "bin");
    let read = || SparseModel::of(reader("images")?.images()?, reader("points3D")?.points()?, folder);
    Some(read())
}

fn file(folder: &Path, name: &str, ending: &str) -> PathBuf {
    folder.join(format!("{name}.{ending}"))
}

/// The camera in the world, from the world in the camera as a model has it: quaternion `w x y z` and translation.
fn world_from_camera(quaternion: [f64; 4], translation: [f64; 3]) -> Result<Isometry3<f64>, String> {
    let [w, x, y, z] = quaternion;
    let rotation = super::tum::rotation(Quaternion::new(w, x, y, z))?;
    if let Some(odd) = translation.iter().find(|t| !t.is_finite()) {
        return Err(format!("its translation has the value {odd}"));
    }
    Ok(Isometry3::from_parts(Translation3::from(translation), rotation).inverse())
}
