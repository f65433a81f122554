//! The camera of a dataset, and the default for an unknown camera.

use crate::error::{Error, ErrorKind, Result};
use crate::files::{MAX_SETTINGS_BYTES, read_text};
use crate::matching::{Camera, CameraModel};
use std::path::Path;

/// The camera of a dataset.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraChoice {
    /// Unknown: as COLMAP does, the focal length is taken as 1.2 times the larger side, and the centre as the principal
    /// point. Images of different sizes have separate cameras.
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
        _ => 0.0,
    };
    Camera { model, width, height, params: model.param_names().iter().map(value).collect() }
}

/// Reads a camera file: TOML with `model`, `width`, `height` and `params` (in COLMAP's order and convention).
///
/// # Errors
/// The problem of the file, and what would be right.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_guess_is_colmaps_and_a_known_camera_is_for_its_own_images() {
        let camera = CameraChoice::default().for_images((640, 480)).expect("a guess");
        assert_eq!(camera.to_string(), "SIMPLE_RADIAL 640 480 768 320 240 0");
        let camera = CameraChoice::Guessed(CameraModel::OpenCv).for_images((480, 640)).expect("a guess");
        assert_eq!(camera.params, [768.0, 768.0, 240.0, 320.0, 0.0, 0.0, 0.0, 0.0]);
        let choice = CameraChoice::Known(Camera::centred(64, 48, 50.0));
        assert_eq!(choice.for_images((64, 48)).map(|c| c.params[0]), Ok(50.0));
        let error = choice.for_images((48, 64)).expect_err("another size").to_string();
        assert!(error.contains("64×48") && error.contains("48×64"), "{error}");
    }

    #[test]
    fn camera_files_are_read_or_explained() {
        let home = tempfile::tempdir().expect("a folder");
        let path = home.path().join("camera.toml");
        let read = |text: &str| {
            std::fs::write(&path, text).expect("written");
            read_camera(&path)
        };
        let text = "model = \"OPENCV\"\nwidth = 8\nheight = 6\nparams = [5, 5, 4, 3, 0.1, 0, 0, 0]\n";
        assert_eq!(read(text).expect("a camera").to_string(), "OPENCV 8 6 5 5 4 3 0.1 0 0 0");
        for (text, words) in [
            ("model = \"FISHEYE\"\nwidth = 8\nheight = 6\nparams = [5, 4, 3]\n", "FISHEYE"),
            ("model = \"PINHOLE\"\nwidth = 8\nheight = 6\n", "params"),
            ("model = \"PINHOLE\"\nwidth = 8\nheight = 6\nparams = [5]\n", "fx, fy, cx, cy"),
            ("model = \"PINHOLE\"\nfocal = 3\n", "focal"),
        ] {
            let error = read(text).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
        assert!(read_camera(&home.path().join("gone.toml")).expect_err("absent").to_string().contains("gone.toml"));
    }
}
