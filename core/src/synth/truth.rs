//! What is known about a synthetic burst: the content of `truth.json`.

use super::noise::Camera;
use serde::{Deserialize, Serialize};

/// What kind of burst it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TruthKind {
    /// Discs on an even background.
    Chart,
    /// Textured layers.
    Scene,
    /// The scene that is built into the program.
    Demo,
}

/// Everything that is known about a synthetic burst. Positions are image pixels at `t0`, the centre of the first pixel
/// is (0, 0).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// What kind of burst it is.
    pub kind: TruthKind,
    /// Columns of a frame.
    pub width: usize,
    /// Rows of a frame.
    pub height: usize,
    /// Number of frames, N.
    pub frames: usize,
    /// The reference time, (N − 1)/2, in frames.
    pub t0: f64,
    /// The seed from which everything follows.
    pub seed: u64,
    /// The camera's noise; `None` (null) for a noiseless burst.
    pub noise: Option<NoiseTruth>,
    /// The pedestal under all values, fraction of full scale.
    pub black_level: f64,
    /// Planes of the scene, far to near; empty for a chart.
    #[serde(default)]
    pub layers: Vec<LayerTruth>,
    /// Blobs whose place, size and motion are known.
    pub features: Vec<FeatureTruth>,
}

/// The noise of a synthetic burst.
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
    /// The per-pixel signal-to-noise ratio that was asked for, as [`super::noise`] defines it; absent where none was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub snr: Option<f64>,
}

impl NoiseTruth {
    /// What there is to know about `camera`'s noise over a `background` signal; `None` for a noiseless one.
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

/// One plane of a layered scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerTruth {
    /// What it shows.
    pub name: String,
    /// Its motion to the right, pixels per frame.
    pub slope_u: f64,
    /// Its motion downwards, pixels per frame.
    pub slope_v: f64,
}

/// A round blob with known place and motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
    /// The scale at which a detector sees it, radius/√2, pixels.
    pub sigma: f64,
    /// Motion to the right, pixels per frame.
    pub slope_u: f64,
    /// Motion downwards, pixels per frame.
    pub slope_v: f64,
    /// +1 for a blob brighter than what is around it, −1 for a darker one.
    pub contrast_sign: i8,
}

impl FeatureTruth {
    /// Where it is `dt` frames after the reference time: (column, row) in pixels.
    pub fn position(&self, dt: f64) -> (f64, f64) {
        (self.u + dt * self.slope_u, self.v + dt * self.slope_v)
    }
}

/// The scale at which a detector sees a disc of `radius` pixels: its DoG response is strongest at σ = r/√2.
pub fn disc_sigma(radius: f64) -> f64 {
    radius * std::f64::consts::FRAC_1_SQRT_2
}
