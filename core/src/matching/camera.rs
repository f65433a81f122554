//! A camera's intrinsics: mapping between directions in space and pixels.
//!
//! Models, names and the order of the parameters are COLMAP's, and so is the principal point: **the centre of the first
//! pixel is (0.5, 0.5)** there. [`Camera::direction_of`] and [`Camera::pixel_of`] use Burstscope's, where it is (0, 0).

use crate::error::{Error, Result};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Half a pixel: the centre of the first pixel in COLMAP's convention.
const FIRST_PIXEL: f64 = 0.5;

/// Mapping from directions to pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[cfg_attr(feature = "cli", value(rename_all = "SCREAMING_SNAKE_CASE"))]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum CameraModel {
    /// f, cx, cy.
    SimplePinhole,
    /// fx, fy, cx, cy.
    Pinhole,
    /// f, cx, cy, k: radial distortion by 1 + k·r².
    SimpleRadial,
    /// fx, fy, cx, cy, k1, k2, p1, p2: radial distortion by 1 + k1·r² + k2·r⁴, and tangential distortion, as in OpenCV.
    #[serde(rename = "OPENCV")]
    #[cfg_attr(feature = "cli", value(name = "OPENCV"))]
    OpenCv,
}

impl CameraModel {
    /// All models.
    pub const ALL: [Self; 4] = [Self::SimplePinhole, Self::Pinhole, Self::SimpleRadial, Self::OpenCv];

    fn names(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::SimplePinhole => ("SIMPLE_PINHOLE", &["f", "cx", "cy"]),
            Self::Pinhole => ("PINHOLE", &["fx", "fy", "cx", "cy"]),
            Self::SimpleRadial => ("SIMPLE_RADIAL", &["f", "cx", "cy", "k"]),
            Self::OpenCv => ("OPENCV", &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"]),
        }
    }

    /// The name in COLMAP.
    pub fn name(self) -> &'static str {
        self.names().0
    }

    pub(crate) fn param_names(self) -> &'static [&'static str] {
        self.names().1
    }
}

/// Intrinsics of a camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Mapping from directions to pixels, which gives `params` their meaning.
    pub model: CameraModel,
    /// Columns of its images.
    pub width: usize,
    /// Rows of its images.
    pub height: usize,
    /// The model's parameters in COLMAP's order; focal lengths and principal point in pixels.
    pub params: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Distortion {
    k1: f64,
    k2: f64,
    p1: f64,
    p2: f64,
}

impl Distortion {
    /// The distorted position of the direction (x, y, 1).
    fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (self.k1 + r2 * self.k2);
        [
            x * radial + 2.0 * self.p1 * x * y + self.p2 * (r2 + 2.0 * x * x),
            y * radial + self.p1 * (r2 + 2.0 * y * y) + 2.0 * self.p2 * x * y,
        ]
    }

    /// By rows, the derivatives of [`Self::apply`] with respect to x and y.
    fn jacobian(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (self.k1 + r2 * self.k2);
        // Twice the derivative of `radial` with respect to r².
        let slope = 2.0 * (self.k1 + 2.0 * r2 * self.k2);
        let mixed = x * y * slope + 2.0 * self.p1 * x + 2.0 * self.p2 * y;
        [
            [radial + x * x * slope + 2.0 * self.p1 * y + 6.0 * self.p2 * x, mixed],
            [mixed, radial + y * y * slope + 6.0 * self.p1 * y + 2.0 * self.p2 * x],
        ]
    }

    /// The (x, y) that [`Self::apply`] maps to `distorted`, by Newton's method; else the closest one reached.
    fn remove(&self, distorted: [f64; 2]) -> [f64; 2] {
        if *self == Self::default() {
            return distorted;
        }
        let miss = |at: [f64; 2]| {
            let [x, y] = self.apply(at);
            [x - distorted[0], y - distorted[1]]
        };
        let length = |[x, y]: [f64; 2]| x.hypot(y);
        let mut at = distorted;
        let mut off = miss(at);
        for _ in 0..50 {
            let [[a, b], [c, d]] = self.jacobian(at);
            let determinant = a * d - b * c;
            let step = [(d * off[0] - b * off[1]) / determinant, (a * off[1] - c * off[0]) / determinant];
            let next = [at[0] - step[0], at[1] - step[1]];
            let next_off = miss(next);
            // Also false for NaN.
            let is_closer = length(next_off) < length(off);
            if !is_closer {
                break;
            }
            (at, off) = (next, next_off);
        }
        at
    }
}

impl Camera {
    /// A pinhole camera with the principal point at the image's centre. `focal_px` is in pixels.
    pub fn centred(width: usize, height: usize, focal_px: f64) -> Self {
        let params = vec![focal_px, width as f64 / 2.0, height as f64 / 2.0];
        Self { model: CameraModel::SimplePinhole, width, height, params }
    }

    /// Checks size and parameters. `parameter` names the option that they came from, for the error.
    pub fn validate(&self, parameter: &'static str) -> Result<()> {
        let fail = |problem: String, remedy: String| Err(Error::param(parameter, problem, remedy));
        let names = self.model.param_names();
        let wanted = || format!("{} takes {}", self.model.name(), names.join(", "));
        if self.params.len() != names.len() {
            return fail(format!("{} parameters for {}", self.params.len(), self.model.name()), wanted());
        }
        if self.width == 0 || self.height == 0 {
            return fail(format!("{}×{} pixels", self.width, self.height), "give the size of its images".into());
        }
        for (name, &value) in names.iter().zip(&self.params) {
            // Focal lengths divide; all other parameters may have either sign.
            if !value.is_finite() || (name.starts_with('f') && value <= 0.0) {
                let right = if name.starts_with('f') { "a focal length is above 0 pixels" } else { "give a number" };
                return fail(format!("{name} is {value}"), right.into());
            }
        }
        Ok(())
    }

    /// fx, fy, cx, cy in COLMAP's convention, pixels.
    fn pinhole(&self) -> [f64; 4] {
        let p = &self.params;
        match self.model {
            CameraModel::SimplePinhole | CameraModel::SimpleRadial => [p[0], p[0], p[1], p[2]],
            CameraModel::Pinhole | CameraModel::OpenCv => [p[0], p[1], p[2], p[3]],
        }
    }

    fn distortion(&self) -> Distortion {
        let p = &self.params;
        match self.model {
            CameraModel::SimplePinhole | CameraModel::Pinhole => Distortion::default(),
            CameraModel::SimpleRadial => Distortion { k1: p[3], ..Distortion::default() },
            CameraModel::OpenCv => Distortion { k1: p[4], k2: p[5], p1: p[6], p2: p[7] },
        }
    }

    /// Focal lengths (fx, fy), pixels.
    pub fn focal_px(&self) -> [f64; 2] {
        let [fx, fy, ..] = self.pinhole();
        [fx, fy]
    }

    /// The matrix K from directions (x, y, 1) to pixels (u, v, 1) in Burstscope's convention, without distortion.
    pub fn matrix(&self) -> Matrix3<f64> {
        let [fx, fy, cx, cy] = self.pinhole();
        Matrix3::new(fx, 0.0, cx - FIRST_PIXEL, 0.0, fy, cy - FIRST_PIXEL, 0.0, 0.0, 1.0)
    }

    /// Whether straight lines in space are straight in the images: there is no distortion.
    pub fn is_straight(&self) -> bool {
        self.distortion() == Distortion::default()
    }

    /// The direction (x, y, 1) seen at the pixel (u, v), undistorted. Panics if [`Self::validate`] refuses the camera.
    pub fn direction_of(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [fx, fy, cx, cy] = self.pinhole();
        self.distortion().remove([(u + FIRST_PIXEL - cx) / fx, (v + FIRST_PIXEL - cy) / fy])
    }

    /// The pixel (u, v) at which the direction (x, y, 1) is seen. Panics for a camera that [`Self::validate`] refuses.
    pub fn pixel_of(&self, direction: [f64; 2]) -> [f64; 2] {
        let [fx, fy, cx, cy] = self.pinhole();
        let [x, y] = self.distortion().apply(direction);
        [fx * x + cx - FIRST_PIXEL, fy * y + cy - FIRST_PIXEL]
    }
}

impl fmt::Display for Camera {
    /// As in COLMAP's `cameras.txt`, without the number in front: `PINHOLE 640 480 500 500 320 240`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.model.name(), self.width, self.height)?;
        self.params.iter().try_for_each(|p| write!(f, " {p}"))
    }
}

impl FromStr for Camera {
    type Err = String;

    /// Reads what `Display` writes, separated by spaces or commas: a line of COLMAP's `cameras.txt` without its number.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut words = text.split([' ', ',', '\t']).filter(|word| !word.is_empty());
        let names = || CameraModel::ALL.map(CameraModel::name).join(", ");
        let name = words.next().ok_or_else(|| format!("no camera is given; begin with a model: {}", names()))?;
        let model = CameraModel::ALL.into_iter().find(|m| m.name().eq_ignore_ascii_case(name));
        let model = model.ok_or_else(|| format!("'{name}' is no camera model; there are {}", names()))?;
        let form = || format!("write {} WIDTH HEIGHT {}", model.name(), model.param_names().join(" "));
        let mut side = || words.next().and_then(|word| word.parse().ok()).ok_or_else(form);
        // COLMAP's order in `cameras.txt`: the size before the parameters.
        let (width, height) = (side()?, side()?);
        let number = |word: &str| word.parse().map_err(|_| format!("'{word}' is not a number; {}", form()));
        let params = words.map(number).collect::<Result<_, String>>()?;
        let camera = Self { model, width, height, params };
        camera.validate("camera").map_err(|e| format!("{}; {}", e.problem, e.remedy))?;
        Ok(camera)
    }
}
