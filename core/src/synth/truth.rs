//! The truth of a synthetic burst: the content of `truth.json`.

use super::noise::Camera;
use crate::burst::{Offset, Positions};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Kind of a synthetic burst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TruthKind {
    /// Discs on an even background.
    #[default]
    Chart,
    /// Textured layers.
    Scene,
    /// Scene that is built into the program.
    Demo,
    /// Things planted in another burst.
    Planted,
}

/// Truth of a synthetic burst. Positions are image pixels at `t0`, the centre of the first pixel is (0, 0).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Kind of the burst.
    pub kind: TruthKind,
    /// Columns of a frame.
    pub width: usize,
    /// Rows of a frame.
    pub height: usize,
    /// Number of frames, N.
    pub frames: usize,
    /// Reference time, the mean of the frames' times, in frames: (N − 1)/2 for even ones.
    pub t0: f64,
    /// Time of each frame, in frame intervals; empty for even ones: 0, 1, 2, …. Of exchanged frames the true ones.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub times: Vec<f64>,
    /// Column and row of each view of a light field from the first one; their mean is the reference. Empty for frames.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub views: Vec<[f64; 2]>,
    /// Columns, from the left, that a thing which stands still hides in all frames; no feature is behind it.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub mask_columns: usize,
    /// Seed from which everything is derived.
    pub seed: u64,
    /// The camera's noise; `None` (null) for a noiseless burst.
    pub noise: Option<NoiseTruth>,
    /// Pedestal under all values, fraction of full scale.
    pub black_level: f64,
    /// Planes of the scene, far to near; empty for a chart.
    #[serde(default)]
    pub layers: Vec<LayerTruth>,
    /// Blobs whose position, size and motion are known.
    pub features: Vec<FeatureTruth>,
}

/// Noise of a synthetic burst.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseTruth {
    /// Electrons at full scale.
    pub full_scale_electrons: f64,
    /// Standard deviation of the read noise, electrons.
    pub read_noise_electrons: f64,
    /// Bits of the converter.
    pub bits: u32,
    /// Difference between neighbouring levels, fraction of full scale.
    pub quantisation_step: f64,
    /// Standard deviation of one pixel of one frame at the background's level, fraction of full scale.
    pub sigma_background: f64,
    /// Requested per-pixel signal-to-noise ratio, as [`super::noise`] defines it; absent where none was requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub snr: Option<f64>,
}

/// Largest number of columns, rows or frames of a truth, and of numbers of pixels and frames in it.
const LARGEST: f64 = 1e6;

impl Truth {
    /// Truth of `frames` frames of `size` that `camera` captured over a `background` signal; no layers, no features.
    pub(super) fn captured(
        kind: TruthKind,
        (width, height): (usize, usize),
        (frames, seed): (usize, u64),
        camera: &Camera,
        (background, snr): (f64, Option<f64>),
    ) -> Self {
        let (t0, noise) = (0.5 * (frames as f64 - 1.0), NoiseTruth::of(camera, background, snr));
        Self { kind, width, height, frames, t0, seed, noise, black_level: camera.black_level, ..Self::default() }
    }

    /// Offset of each frame from the reference.
    pub fn offsets(&self) -> Vec<Offset> {
        // Views that make no sense give none.
        let of_views = || Positions::of_views(&self.views).map(|positions| positions.offsets().to_vec());
        let time = |t: usize| self.times.get(t).copied().unwrap_or(t as f64) - self.t0;
        let of_times = || (0..self.frames).map(|t| time(t).into()).collect();
        if self.views.is_empty() { of_times() } else { of_views().unwrap_or_default() }
    }

    /// Time from the first to the last frame, frame intervals, or diameter of the grid of views.
    pub fn span(&self) -> f64 {
        match self.times[..] {
            // Views have no times: their span is the grid's diameter.
            _ if !self.views.is_empty() => Positions::of_views(&self.views).map_or(0.0, |positions| positions.span()),
            [_, _, ..] => {
                self.times.iter().copied().fold(f64::MIN, f64::max)
                    - self.times.iter().copied().fold(f64::MAX, f64::min)
            }
            _ => self.frames as f64 - 1.0,
        }
    }

    /// Checks the numbers, as a file may hold anything; the error is the first that makes no sense, and its range.
    pub fn check(&self) -> Result<(), String> {
        let within = |name: &str, number: f64, range: RangeInclusive<f64>| {
            let (least, most) = (range.start(), range.end());
            let wrong = || format!("{name} is {number}, which is not in the range of {least} to {most}");
            range.contains(&number).then_some(()).ok_or_else(wrong)
        };
        for (name, count) in [("width", self.width), ("height", self.height), ("frames", self.frames)] {
            within(name, count as f64, 1.0..=LARGEST)?;
        }
        let free = |name: &str, number: f64| within(name, number, -LARGEST..=LARGEST);
        free("t0", self.t0)?;
        free("black_level", self.black_level)?;
        self.times.iter().try_for_each(|time| free("times", *time))?;
        self.views.iter().flatten().try_for_each(|place| free("views", *place))?;
        for layer in &self.layers {
            free("layers.slope_u", layer.slope_u)?;
            free("layers.slope_v", layer.slope_v)?;
        }
        for feature in &self.features {
            free("features.u", feature.u)?;
            free("features.v", feature.v)?;
            free("features.slope_u", feature.slope_u)?;
            free("features.slope_v", feature.slope_v)?;
            within("features.radius", feature.radius, 1e-6..=LARGEST)?;
            within("features.sigma", feature.sigma, 1e-6..=LARGEST)?;
        }
        Ok(())
    }
}

impl NoiseTruth {
    /// Describes `camera`'s noise over a `background` signal; `None` for a noiseless camera.
    pub fn of(camera: &Camera, background: f64, snr: Option<f64>) -> Option<Self> {
        (!camera.is_noiseless()).then(|| Self {
            full_scale_electrons: camera.full_scale_electrons,
            read_noise_electrons: camera.read_noise_electrons,
            bits: camera.bits.unwrap_or(16),
            quantisation_step: camera.quantisation_step(),
            sigma_background: camera.sigma(background),
            snr,
        })
    }
}

/// Truth of one plane of a layered scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerTruth {
    /// Name of its content.
    pub name: String,
    /// Motion to the right, pixels per frame.
    pub slope_u: f64,
    /// Motion downwards, pixels per frame.
    pub slope_v: f64,
}

/// Round blob with known position and motion.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureTruth {
    /// Running number.
    pub id: usize,
    /// Index of the layer it belongs to; absent in charts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<usize>,
    /// Column at `t0`, pixels.
    pub u: f64,
    /// Row at `t0`, pixels.
    pub v: f64,
    /// Radius of the disc, pixels.
    pub radius: f64,
    /// Scale of the blob for a detector, radius/√2, pixels.
    pub sigma: f64,
    /// Motion to the right, pixels per frame.
    pub slope_u: f64,
    /// Motion downwards, pixels per frame.
    pub slope_v: f64,
    /// +1 for a blob brighter than its surroundings, −1 for a darker one.
    pub contrast_sign: i8,
}

impl FeatureTruth {
    /// Position (column, row), pixels, in a frame at an offset from the reference: frames after it, or views.
    pub fn position(&self, at: impl Into<Offset>) -> (f64, f64) {
        let (du, dv) = at.into().displacement((self.slope_u, self.slope_v));
        (self.u + du, self.v + dv)
    }
}

/// The scale of a disc of `radius` pixels for a detector: its Laplacian-of-Gaussian response is strongest at σ = r/√2.
pub fn disc_sigma(radius: f64) -> f64 {
    radius * std::f64::consts::FRAC_1_SQRT_2
}
