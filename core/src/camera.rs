//! A camera's intrinsics: mapping between directions in space and pixels.
//!
//! Models, names and the order of the parameters are COLMAP's, and so is the principal point: **the centre of the first
//! pixel is (0.5, 0.5)** there. [`Camera::direction_of`] and [`Camera::pixel_of`] use Burstscope's, where it is (0, 0).

use crate::error::{Error, Result};
use crate::files::{MAX_SETTINGS_BYTES, read_text};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::{fmt, str::FromStr};
use strum::{EnumCount, VariantArray};

/// Half a pixel: the centre of the first pixel in COLMAP's convention.
const FIRST_PIXEL: f64 = 0.5;
/// Camera file that is taken without being asked for, beside the frames of a burst or in a folder above them.
pub(crate) const CAMERA_FILE: &str = "camera.toml";

/// Mapping from directions to pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumCount, VariantArray)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum), value(rename_all = "SCREAMING_SNAKE_CASE"))]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum CameraModel {
    /// f, cx, cy.
    SimplePinhole,
    /// fx, fy, cx, cy.
    Pinhole,
    /// f, cx, cy, k: radial distortion by 1 + k·r².
    SimpleRadial,
    /// f, cx, cy, k1, k2: radial distortion by 1 + k1·r² + k2·r⁴.
    Radial,
    /// fx, fy, cx, cy, k1, k2, p1, p2: radial distortion by 1 + k1·r² + k2·r⁴, and tangential distortion, as in OpenCV.
    #[serde(rename = "OPENCV")]
    #[cfg_attr(feature = "cli", value(name = "OPENCV"))]
    OpenCv,
    /// fx, fy, cx, cy, k1, k2, k3, k4: an equidistant fisheye, whose angle θ is distorted by 1 + k1·θ² + … + k4·θ⁸.
    #[serde(rename = "OPENCV_FISHEYE")]
    #[cfg_attr(feature = "cli", value(name = "OPENCV_FISHEYE"))]
    OpenCvFisheye,
    /// fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6: as `OPENCV`, with a radial distortion that is a ratio of two
    /// polynomials: 1 + k1·r² + k2·r⁴ + k3·r⁶ over 1 + k4·r² + k5·r⁴ + k6·r⁶.
    #[serde(rename = "FULL_OPENCV")]
    #[cfg_attr(feature = "cli", value(name = "FULL_OPENCV"))]
    FullOpenCv,
    /// fx, fy, cx, cy, omega: field of view ω in radians (Devernay and Faugeras 2001).
    Fov,
    /// f, cx, cy, k: an equidistant fisheye, whose angle θ is distorted by 1 + k·θ².
    SimpleRadialFisheye,
    /// f, cx, cy, k1, k2: an equidistant fisheye, whose angle θ is distorted by 1 + k1·θ² + k2·θ⁴.
    RadialFisheye,
    /// fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, sx1, sy1: a fisheye with tangential and thin-prism distortion.
    ThinPrismFisheye,
    /// fx, fy, cx, cy, k0 … k5, p0, p1, s0 … s3: a fisheye with tangential and thin-prism distortion after the radial.
    RadTanThinPrismFisheye,
}

impl CameraModel {
    /// All models that are known here, in the order of COLMAP's numbers.
    pub const ALL: [Self; Self::COUNT] = *Self::VARIANTS.first_chunk().expect("as many");

    /// Number of the model in COLMAP's databases and binary models.
    pub fn id(self) -> u32 {
        self as u32
    }

    fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::SimplePinhole => ("SIMPLE_PINHOLE", "f cx cy"),
            Self::Pinhole => ("PINHOLE", "fx fy cx cy"),
            Self::SimpleRadial => ("SIMPLE_RADIAL", "f cx cy k"),
            Self::Radial => ("RADIAL", "f cx cy k1 k2"),
            Self::OpenCv => ("OPENCV", "fx fy cx cy k1 k2 p1 p2"),
            Self::OpenCvFisheye => ("OPENCV_FISHEYE", "fx fy cx cy k1 k2 k3 k4"),
            Self::FullOpenCv => ("FULL_OPENCV", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
            Self::Fov => ("FOV", "fx fy cx cy omega"),
            Self::SimpleRadialFisheye => ("SIMPLE_RADIAL_FISHEYE", "f cx cy k"),
            Self::RadialFisheye => ("RADIAL_FISHEYE", "f cx cy k1 k2"),
            Self::ThinPrismFisheye => ("THIN_PRISM_FISHEYE", "fx fy cx cy k1 k2 p1 p2 k3 k4 sx1 sy1"),
            Self::RadTanThinPrismFisheye => {
                ("RAD_TAN_THIN_PRISM_FISHEYE", "fx fy cx cy k0 k1 k2 k3 k4 k5 p0 p1 s0 s1 s2 s3")
            }
        }
    }

    /// The name in COLMAP.
    pub fn name(self) -> &'static str {
        self.names().0
    }

    pub(crate) fn param_names(self) -> Vec<&'static str> {
        self.names().1.split(' ').collect()
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

/// Distortion by a lens and polynomials of r² after it. Those that a model lacks are 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Distortion {
    /// Field of view ω in radians, by which a lens bends rays; 0 for an equidistant fisheye, `None` for no bending.
    lens: Option<f64>,
    /// Radial: 1 + first·r² + second·r⁴ + …, over the same of `divisor`.
    radial: [f64; 6],
    divisor: [f64; 3],
    /// p1 and p2 as in OpenCV.
    tangential: [f64; 2],
    /// Thin prism: of r² and r⁴ along x, then along y.
    prism: [f64; 4],
    /// Whether tangential and thin-prism distortion are of the place that the radial one leads to.
    is_after_radial: bool,
}

/// atan(r) / r, 1 at 0.
fn atan_over(r: f64) -> f64 {
    if r.abs() < 1e-8 { 1.0 } else { r.atan() / r }
}

impl Distortion {
    /// The distorted position of the direction (x, y, 1).
    fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let bent = match self.lens {
            None => 1.0,
            Some(0.0) => atan_over(x.hypot(y)),
            Some(omega) => {
                let twice = 2.0 * (0.5 * omega).tan();
                twice / omega * atan_over(twice * x.hypot(y))
            }
        };
        let [x, y] = [x * bent, y * bent];
        let square = |[x, y]: [f64; 2]| x * x + y * y;
        let r2 = square([x, y]);
        let polynomial = |of: &[f64]| 1.0 + of.iter().rev().fold(0.0, |sum, k| r2 * (k + sum));
        let radial = polynomial(&self.radial) / polynomial(&self.divisor);
        let scaled = [x * radial, y * radial];
        let at = if self.is_after_radial { scaled } else { [x, y] };
        let ([x, y], r2) = (at, square(at));
        let ([p1, p2], [x2, x4, y2, y4]) = (self.tangential, self.prism);
        [
            scaled[0] + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (x2 + r2 * x4),
            scaled[1] + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (y2 + r2 * y4),
        ]
    }

    /// By rows, the derivatives of [`Self::apply`] with respect to x and y: by differences, alike for all models.
    /// Newton's method needs no more digits of them, as its result is judged by `apply`.
    fn jacobian(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        let step = 1e-6 * (1.0 + x.abs().max(y.abs()));
        let along = |[dx, dy]: [f64; 2]| {
            let [[ax, ay], [bx, by]] = [1.0, -1.0].map(|sign| self.apply([x + sign * dx, y + sign * dy]));
            [(ax - bx) / (2.0 * step), (ay - by) / (2.0 * step)]
        };
        let ([a, c], [b, d]) = (along([step, 0.0]), along([0.0, step]));
        [[a, b], [c, d]]
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

    /// fx, fy, cx, cy in COLMAP's convention, pixels; and the parameters after them.
    fn pinhole(&self) -> ([f64; 4], &[f64]) {
        match (self.model.names().1.starts_with("f "), &self.params[..]) {
            (true, &[f, cx, cy, ref rest @ ..]) => ([f, f, cx, cy], rest),
            (false, &[fx, fy, cx, cy, ref rest @ ..]) => ([fx, fy, cx, cy], rest),
            _ => unreachable!("a camera that is used was validated"),
        }
    }

    fn distortion(&self) -> Distortion {
        use CameraModel as M;
        let (_, rest) = self.pinhole();
        let lens = match self.model {
            M::Fov => Some(rest[0]).filter(|omega| *omega != 0.0),
            model => model.name().ends_with("FISHEYE").then_some(0.0),
        };
        let (mut radial, plain) = ([0.0; 6], Distortion { lens, ..Distortion::default() });
        match (self.model, rest) {
            (M::Fov, _) => plain,
            (M::OpenCv | M::FullOpenCv | M::ThinPrismFisheye, &[k1, k2, p1, p2, ref more @ ..]) => {
                (radial[0], radial[1]) = (k1, k2);
                let bent = Distortion { radial, tangential: [p1, p2], ..plain };
                match (self.model, more) {
                    (M::FullOpenCv, &[k3, k4, k5, k6]) => {
                        radial[2] = k3;
                        Distortion { radial, divisor: [k4, k5, k6], ..bent }
                    }
                    (M::ThinPrismFisheye, &[k3, k4, sx1, sy1]) => {
                        (radial[2], radial[3]) = (k3, k4);
                        Distortion { radial, prism: [sx1, 0.0, sy1, 0.0], ..bent }
                    }
                    _ => bent,
                }
            }
            // Here the first is along x: the other way round.
            (M::RadTanThinPrismFisheye, &[.., p0, p1, s0, s1, s2, s3]) => {
                radial.copy_from_slice(&rest[..6]);
                let (tangential, prism) = ([p1, p0], [s0, s1, s2, s3]);
                Distortion { radial, tangential, prism, is_after_radial: true, ..plain }
            }
            (_, coefficients) => {
                radial[..coefficients.len()].copy_from_slice(coefficients);
                Distortion { radial, ..plain }
            }
        }
    }

    /// Focal lengths (fx, fy), pixels.
    pub fn focal_px(&self) -> [f64; 2] {
        let ([fx, fy, ..], _) = self.pinhole();
        [fx, fy]
    }

    /// The matrix K from directions (x, y, 1) to pixels (u, v, 1) in Burstscope's convention, without distortion.
    pub fn matrix(&self) -> Matrix3<f64> {
        let ([fx, fy, cx, cy], _) = self.pinhole();
        Matrix3::new(fx, 0.0, cx - FIRST_PIXEL, 0.0, fy, cy - FIRST_PIXEL, 0.0, 0.0, 1.0)
    }

    /// Whether straight lines in space are straight in the images: there is no distortion.
    pub fn is_straight(&self) -> bool {
        self.distortion() == Distortion::default()
    }

    /// The direction (x, y, 1) seen at the pixel (u, v), undistorted; far out for rays of a fisheye from 90° off its
    /// axis on, which have no such direction. Panics if [`Self::validate`] refuses the camera.
    pub fn direction_of(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let ([fx, fy, cx, cy], _) = self.pinhole();
        self.distortion().remove([(u + FIRST_PIXEL - cx) / fx, (v + FIRST_PIXEL - cy) / fy])
    }

    /// The pixel (u, v) at which the direction (x, y, 1) is seen. Panics for a camera that [`Self::validate`] refuses.
    pub fn pixel_of(&self, direction: [f64; 2]) -> [f64; 2] {
        let ([fx, fy, cx, cy], _) = self.pinhole();
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
        let camera = Self { model, width, height, params: words.map(number).collect::<Result<_, String>>()? };
        camera.validate("camera").map_err(|e| format!("{}; {}", e.problem, e.remedy))?;
        Ok(camera)
    }
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
