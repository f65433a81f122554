//! The cameras of a dataset, and the default for an unknown camera.

use crate::burst::BurstFiles;
pub use crate::camera::read_camera;
use crate::camera::{CAMERA_FILE, Camera, CameraModel};
use crate::error::{Error, ErrorKind, Result};
use crate::files::path_text;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Camera of bursts: known from a calibration, or guessed as COLMAP does.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraChoice {
    /// Unknown: as in COLMAP a focal length of 1.2 times the larger side, and a camera for each size of images.
    Guessed(CameraModel),
    /// One known camera for all images.
    Known(Camera),
    /// Known camera of some bursts, with its source: a file, or the words of an option.
    Own(Camera, PathBuf),
}

impl Default for CameraChoice {
    /// COLMAP's default model, unknown.
    fn default() -> Self {
        Self::Guessed(CameraModel::SimpleRadial)
    }
}

impl CameraChoice {
    /// The camera of images of `size` (columns, rows).
    ///
    /// # Errors
    /// The known camera's images have another size.
    pub fn for_images(&self, size: (usize, usize)) -> Result<Camera> {
        match self {
            Self::Guessed(model) => Ok(guessed(*model, size)),
            Self::Known(camera) | Self::Own(camera, _) if (camera.width, camera.height) == size => Ok(camera.clone()),
            Self::Known(camera) | Self::Own(camera, _) => {
                let problem = format!(
                    "the camera is given for images of {}×{}, but this burst has {}×{}",
                    camera.width, camera.height, size.0, size.1
                );
                let error = Error::new(ErrorKind::Failed, problem, "give the camera of these images");
                Err(if let Some(from) = self.source() { error.about(from) } else { error })
            }
        }
    }

    /// The camera whose focal length is known.
    pub fn known(&self) -> Option<&Camera> {
        if let Self::Known(camera) | Self::Own(camera, _) = self { Some(camera) } else { None }
    }

    /// Source of a camera of some bursts: a file, or the words of an option.
    pub fn source(&self) -> Option<&PathBuf> {
        if let Self::Own(_, from) = self { Some(from) } else { None }
    }
}

/// Cameras of a dataset.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BurstCameras {
    /// Cameras of single bursts, by their names.
    pub own: BTreeMap<String, CameraChoice>,
    /// Camera of all other bursts.
    pub rest: CameraChoice,
}

impl BurstCameras {
    /// The cameras of `bursts`, which were found in `inputs`: those `given` for a folder or a burst, the nearest of
    /// several; else the known one of the `rest`; else that of a file `camera.toml` beside the frames or in a folder
    /// above them, up to the input. A folder is named by the last parts of its path, a burst by its name.
    ///
    /// # Errors
    /// A camera for what is no burst and no folder of any, and a file that is no camera.
    pub fn of(
        bursts: &[BurstFiles],
        inputs: &[PathBuf],
        given: &[(String, CameraChoice)],
        rest: CameraChoice,
    ) -> Result<Self> {
        let places: Vec<Vec<&Path>> = bursts.iter().map(|burst| places_of(burst, inputs)).collect();
        let all = places.iter().flatten();
        if let Some((name, _)) = given.iter().find(|(name, _)| !all.clone().any(|place| place.ends_with(name))) {
            let names: BTreeSet<String> =
                all.filter_map(|place| place.file_name()).map(|name| path_text(name.as_ref())).collect();
            let few: Vec<String> = names.into_iter().take(8).collect();
            let problem = format!("there is no burst and no folder of bursts '{name}'");
            return Err(Error::param("camera", problem, format!("there are such as {}", few.join(", "))));
        }
        let mut own = BTreeMap::new();
        for (burst, places) in bursts.iter().zip(&places) {
            // Of the same name given twice, the last counts, as of other options.
            let given = places.iter().find_map(|place| given.iter().rfind(|(name, _)| place.ends_with(name)));
            let mut files = places[1..].iter().map(|folder| folder.join(CAMERA_FILE));
            if let Some((_, choice)) = given {
                own.insert(burst.name.clone(), choice.clone());
            } else if rest.known().is_none()
                && let Some(file) = files.find(|file| file.is_file())
            {
                own.insert(burst.name.clone(), CameraChoice::Own(read_camera(&file)?, file));
            }
        }
        Ok(Self { own, rest })
    }

    /// Camera of the burst of this name.
    pub fn of_burst(&self, name: &str) -> &CameraChoice {
        self.own.get(name).unwrap_or(&self.rest)
    }

    /// Known cameras; that of the rest first.
    pub fn known(&self) -> impl Iterator<Item = &Camera> {
        [&self.rest].into_iter().chain(self.own.values()).filter_map(CameraChoice::known)
    }
}

/// Places of a burst, the nearest first: the name of the burst, the folder of the frames, and each parent folder, up to
/// and including the input folder.
fn places_of<'a>(burst: &'a BurstFiles, inputs: &[PathBuf]) -> Vec<&'a Path> {
    let path = burst.paths.first().map_or(Path::new(""), PathBuf::as_path);
    let files = usize::from(!path.is_dir());
    let input = path.ancestors().position(|above| inputs.iter().any(|input| input == above)).unwrap_or(0);
    // An input that is a file stands in a folder that was not named.
    let folders = path.ancestors().skip(files).take((input + 1 - files).max(1));
    [Path::new(&burst.name)].into_iter().chain(folders).collect()
}

fn guessed(model: CameraModel, (width, height): (usize, usize)) -> Camera {
    // 1.2 as 6/5, which keeps whole pixels whole.
    let focal = width.max(height) as f64 * 6.0 / 5.0;
    let value = |name: &&str| match *name {
        "f" | "fx" | "fy" => focal,
        "cx" => width as f64 / 2.0,
        "cy" => height as f64 / 2.0,
        "omega" => 0.01, // As COLMAP: from 0 a mapper would not move it.
        _ => 0.0,
    };
    Camera { model, width, height, params: model.param_names().iter().map(value).collect() }
}
