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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparsePoint {
    /// Place in the model's world.
    pub position: [f64; 3],
    /// Mean reprojection error over its keypoints, pixels.
    pub reprojection_error_px: f64,
    /// Number of keypoints of the track.
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
            let problem = format!("there are two images of the id {}", pair[0].id);
            return Err(corrupt(name, "images", problem));
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const IMAGES: &str = "# Image list with two lines of data per image:\n\
    3 1 0 0 0 1 2 3 1 a/second one.png\n10.5 20.5 7 11 21 -1 12 22 8\n\
    2 0.70710678118654757 0 0 0.70710678118654757 1 0 0 1 first.png\n\n";
    const POINTS: &str = "# 3D point list\n7 1 2 3 255 0 0 0.5 3 0 2 5\n8 1 2 4 0 0 0 1.5 3 2 2 1 5 9 4 4\n";

    fn binary_files() -> (Vec<u8>, Vec<u8>) {
        let mut images = 2u64.to_le_bytes().to_vec();
        let half = 0.5f64.sqrt();
        for (id, pose, name, keypoints) in [
            (3u32, [1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0], "a/second one.png", vec![7u64, u64::MAX, 8]),
            (2, [half, 0.0, 0.0, half, 1.0, 0.0, 0.0], "first.png", vec![]),
        ] {
            images.extend(id.to_le_bytes());
            pose.iter().for_each(|x: &f64| images.extend(x.to_le_bytes()));
            images.extend(1u32.to_le_bytes());
            images.extend(name.as_bytes());
            images.push(0);
            images.extend((keypoints.len() as u64).to_le_bytes());
            for (k, point) in keypoints.iter().enumerate() {
                [10.5 + k as f64, 20.5 + k as f64].iter().for_each(|x| images.extend(x.to_le_bytes()));
                images.extend(point.to_le_bytes());
            }
        }
        let mut points = 2u64.to_le_bytes().to_vec();
        for (id, error, track) in [(7u64, 0.5f64, 2u64), (8, 1.5, 4)] {
            points.extend(id.to_le_bytes());
            [1.0, 2.0, 3.0].iter().for_each(|x: &f64| points.extend(x.to_le_bytes()));
            points.extend([255, 0, 0]);
            points.extend(error.to_le_bytes());
            points.extend(track.to_le_bytes());
            (0..track).for_each(|k| points.extend([(k as u32).to_le_bytes(), 0u32.to_le_bytes()].concat()));
        }
        (images, points)
    }

    fn binary<'a>(bytes: &'a [u8], path: &Path) -> Reader<&'a [u8]> {
        Reader::new(bytes, Some(bytes.len() as u64), path)
    }

    fn written(folder: &Path, format: &str) {
        std::fs::create_dir_all(folder).expect("made");
        let (images, points) = match format {
            "bin" => binary_files(),
            _ => (IMAGES.into(), POINTS.into()),
        };
        std::fs::write(folder.join(format!("images.{format}")), images).expect("written");
        std::fs::write(folder.join(format!("points3D.{format}")), points).expect("written");
    }

    #[test]
    fn text_and_binary_say_the_same() {
        let home = tempfile::tempdir().expect("a folder");
        for format in ["bin", "txt"] {
            let folder = home.path().join(format);
            written(&folder, format);
            let model = read_sparse_model(&folder).expect(format);
            let [first, second] = &model.images[..] else { panic!("two images") };
            assert_eq!((first.id, second.id, second.name.as_str()), (2, 3, "a/second one.png"));
            assert_eq!((second.keypoints, second.points, first.keypoints), (3, 2, 0));
            // The world is turned a quarter about z and moved by (1, 0, 0): the centre −Rᵀt is (0, 1, 0).
            let centre = first.world_from_camera.translation.vector;
            assert!((centre - nalgebra::Vector3::new(0.0, 1.0, 0.0)).norm() < 1e-12, "{centre}");
            let summary = model.summary();
            assert_eq!((summary.registered_images, summary.points, summary.points_per_image), (2, 2, 1.0));
            assert_eq!((summary.mean_track_length, summary.mean_reprojection_error_px), (3.0, 1.0));
            assert!(model.points.iter().all(|p| p.position[..2] == [1.0, 2.0]), "{:?}", model.points);
            let poses = model.poses();
            assert_eq!((poses[0].order, poses[0].label.as_str(), poses[0].time), (1, "first.png", None));
        }
    }

    #[test]
    fn the_largest_part_of_a_reconstruction_is_taken() {
        let home = tempfile::tempdir().expect("a folder");
        written(&home.path().join("1"), "txt");
        std::fs::create_dir(home.path().join("notes")).expect("made");
        let small = home.path().join("0");
        written(&small, "txt");
        std::fs::write(small.join("images.txt"), "1 1 0 0 0 0 0 0 1 a.png\n\n").expect("written");
        let model = read_sparse_model(home.path()).expect("a model");
        assert_eq!((model.images.len(), &model.folder), (2, &home.path().join("1")));
        assert_eq!(model.taken(), Some(format!("took {}, the largest of 2 parts", model.folder.display())));
        assert_eq!(SparseModel { other_models: 0, ..model }.taken(), None);
    }

    #[test]
    fn what_is_no_model_says_so() {
        let home = tempfile::tempdir().expect("a folder");
        let words = |folder: &Path| read_sparse_model(folder).expect_err("no model").to_string();
        assert!(words(home.path()).contains("no sparse model"));
        assert!(words(&home.path().join("gone")).contains("no such file"));
        written(home.path(), "txt");
        for (file, text, message) in [
            ("images.txt", "# nothing\n", "no pose"),
            ("images.txt", "1 1 0 0 0 0 0 0 1\n", "line 1: it ends too early"),
            ("images.txt", "1 1 0 0 0 x 0 0 1 a.png\n", "'x' is not a number"),
            ("images.txt", "1 0 0 0 0 0 0 0 1 a.png\n", "length is 0.000"),
            ("images.txt", "1 1 0 0 0 inf 0 0 1 a.png\n", "value inf"),
            ("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n1 2\n", "line 2: 2 values"),
            ("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n1 1 0 0 0 0 0 0 1 b.png\n\n", "two images of the id 1"),
            ("points3D.txt", "1 1 1 1 0 0 0\n", "line 1: it ends too early"),
            ("points3D.txt", "1 1 1 1 0 0 0 0.5 1 2 3\n", "track has 3 values"),
        ] {
            written(home.path(), "txt");
            std::fs::write(home.path().join(file), text).expect("written");
            let error = words(home.path());
            assert!(error.contains(message) && error.contains(home.path().to_str().expect("plain")), "{error}");
        }
    }

    #[test]
    fn counts_that_cannot_be_are_not_believed() {
        let (mut images, mut points) = binary_files();
        images[..8].copy_from_slice(&u64::MAX.to_le_bytes());
        points[..8].copy_from_slice(&(1u64 << 40).to_le_bytes());
        let path = Path::new("x.bin");
        let error = binary(&images, path).images().expect_err("too many").to_string();
        assert!(error.starts_with("the number of images: it announces 18446744073709551615 entries"), "{error}");
        let error = binary(&points, path).points().expect_err("too many").to_string();
        assert!(error.contains("1099511627776"), "{error}");
        // A name without an end.
        let mut endless = binary_files().0;
        endless.truncate(8 + 4 + 56 + 4);
        endless.extend([b'a'; 10_000]);
        let error = binary(&endless, path).images().expect_err("no name").to_string();
        assert!(error.contains("image 1 of 2") && error.contains("4096"), "{error}");
    }

    proptest! {
        #[test]
        fn truncated_files_say_so(part in 0.0f64..1.0) {
            let (images, points) = binary_files();
            let cut = |bytes: &[u8]| bytes[..(bytes.len() as f64 * part) as usize].to_vec();
            let (images, points) = (cut(&images), cut(&points));
            let path = Path::new("x.bin");
            prop_assert!(binary(&images, path).images().is_err());
            prop_assert!(binary(&points, path).points().is_err());
        }
    }
}
