//! The camera of a dataset, and the default for an unknown camera.

use crate::error::{Error, ErrorKind, Result};
use crate::files::{MAX_SETTINGS_BYTES, read_text};
use crate::matching::{Camera, CameraModel};
use std::path::Path;

/// Camera of a dataset: known from a calibration, or guessed as COLMAP does.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraChoice {
    /// Unknown: as in COLMAP a focal length of 1.2 times the larger side, and a camera for each size of images.
    Guessed(CameraModel),
    /// One known camera for all images.
    Known(Camera),
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
            Self::Known(camera) if (camera.width, camera.height) == size => Ok(camera.clone()),
            Self::Known(camera) => {
                let problem = format!(
                    "the camera is given for images of {}×{}, but this burst has {}×{}",
                    camera.width, camera.height, size.0, size.1
                );
                Err(Error::new(ErrorKind::Failed, problem, "give the camera of these images"))
            }
        }
    }

    /// Whether the focal length is known.
    pub fn is_known(&self) -> bool {
        matches!(self, Self::Known(_))
    }
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

/// Reads a camera file: TOML with `model`, `width`, `height` and `params` (in COLMAP's order and convention).
pub fn read_camera(path: &Path) -> Result<Camera> {
    let fail = |problem: String| {
        Error::param(
            "camera",
            format!("{problem}: {}", path.display()),
            "write the file as: model = \"PINHOLE\", width = 640, height = 480, params = [500.0, 500.0, 320.0, 240.0], a line each",
        )
    };
    let text = read_text(path, MAX_SETTINGS_BYTES).map_err(|e| fail(e.to_string()))?;
    let camera: Camera = toml::from_str(&text).map_err(|e| fail(e.message().to_owned()))?;
    camera.validate("camera")?;
    Ok(camera)
}
