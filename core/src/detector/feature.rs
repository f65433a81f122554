//! Keypoints that the search finds, and the results of the detector: features, their descriptors, and the errors.
//!
//! Features stored beside a dataset are reused. Features of an older detector match new ones less well, so code that
//! stores features writes the [`REVISION`] beside them, and reuses only those with an equal number.

pub use super::test::{Tally, Test};

use super::field::MotionField;
use super::noise_model::NoiseModel;
use super::params::{DetectorParams, Slope, SlopeExtrema, SlopeGrid};
use crate::burst::{Burst, Positions};
use crate::detector::scale_space::{Scale, octave_pixel};
use std::sync::Arc;

/// A burst feature: a place at mid-burst, a scale, an orientation and an apparent motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Feature {
    /// Column at `t0`, input pixels; the centre of the first pixel is 0.
    pub u: f32,
    /// Row at `t0`, input pixels.
    pub v: f32,
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Orientation in radians, from +u towards +v, in (−π, π].
    pub orientation: f32,
    /// Apparent motion, pixels per frame, refined between the grid's slopes.
    pub slope: Slope,
    /// Interpolated DoG value with its sign, fraction of full scale; bright blobs are negative.
    pub response: f32,
    /// |response| over the noise in D at its octave and level; infinite for a noiseless burst.
    pub snr: f32,
    /// Octave in which the feature was found; −1 is the doubled image.
    pub octave: i32,
    /// Level within the octave, 0 … levels−1.
    pub level: i32,
    /// Running index of the grid's slope at which it was found.
    pub slope_index: usize,
    /// Whether `slope` is at an end of the searched range and the response still rises beyond: the motion is outside.
    pub at_slope_limit: bool,
    /// Standard deviation of `slope` along its least certain direction, pixels per frame: large along an edge.
    pub slope_sigma: f32,
    /// Motion of its place, from the [field of motion](super::field), pixels per frame; 0 where it is unknown.
    pub field: Slope,
    /// Standard deviation of `field` along its least certain direction, pixels per frame; infinite where it is unknown.
    pub field_sigma: f32,
    /// [Layer](super::field::MotionLayer) that it moves with, from 1, the nearest; 0 for none.
    pub layer: i32,
    /// Motion of the feature relative to its surroundings.
    pub moves: Moves,
}

/// Motion of a feature beside that of its surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Moves {
    /// Nothing is known of the surroundings.
    #[default]
    Unknown,
    /// As the surroundings do, as far as the feature's own motion is known.
    #[serde(rename = "surroundings")]
    WithSurroundings,
    /// Otherwise than the surroundings: a thing that moves by itself, or an alias.
    #[serde(rename = "own")]
    ByItself,
    /// Undefined by the feature's shape: an edge shows no motion along itself.
    Edge,
    /// A ghost of another motion: only some frames respond, in turn, along a slope by which nothing at the place moves.
    Ghost,
}

impl Moves {
    /// All of them, in the order of their numbers in files without text, from 0.
    pub const ALL: [Self; 5] = [Self::Unknown, Self::WithSurroundings, Self::ByItself, Self::Edge, Self::Ghost];

    /// Word in files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::WithSurroundings => "surroundings",
            Self::ByItself => "own",
            Self::Edge => "edge",
            Self::Ghost => "ghost",
        }
    }

    /// Words for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Unknown => "surroundings unknown",
            Self::WithSurroundings => "moves with its surroundings",
            Self::ByItself => "moves by itself",
            Self::Edge => "motion not defined (edge)",
            Self::Ghost => "ghost",
        }
    }

    /// Motion of `feature` by its numbers, which show neither ghosts nor edges.
    pub fn by_numbers(feature: &Feature) -> Self {
        let Feature { slope, slope_sigma, field, field_sigma, .. } = feature;
        let apart = (slope.u - field.u).hypot(slope.v - field.v);
        match () {
            () if field_sigma.is_infinite() => Self::Unknown,
            () if apart > BY_ITSELF_SIGMAS * slope_sigma.hypot(*field_sigma) => Self::ByItself,
            () => Self::WithSurroundings,
        }
    }
}

/// Uncertainty of a feature's own motion above which it is not defined, pixels per frame.
pub(super) const DEFINED_SIGMA: f32 = 0.75;
/// Standard deviations by which a feature that moves by itself differs from its surroundings.
const BY_ITSELF_SIGMAS: f32 = 3.0;

impl Feature {
    /// Scale at which it was found.
    pub fn scale(&self) -> Scale {
        Scale { octave: self.octave, level: self.level }
    }

    /// Motion to report, and its standard deviation, pixels per frame: the feature's own where it moves by itself,
    /// where the motion of the place is unknown, and where it is more certain and within one standard deviation of the
    /// place's; else that of the place, which more of the picture supports.
    pub fn motion(&self) -> (Slope, f32) {
        let (own, of_place) = ((self.slope, self.slope_sigma), (self.field, self.field_sigma));
        let apart = || (self.slope.u - self.field.u).hypot(self.slope.v - self.field.v);
        match self.moves {
            Moves::ByItself | Moves::Unknown => own,
            _ if self.field_sigma.is_infinite() => own,
            Moves::WithSurroundings if self.slope_sigma < self.field_sigma && apart() <= self.field_sigma => own,
            Moves::WithSurroundings | Moves::Edge | Moves::Ghost => of_place,
        }
    }

    /// Motion of the place, from the field; `None` where it is unknown.
    pub fn known_field(&self) -> Option<Slope> {
        self.field_sigma.is_finite().then_some(self.field)
    }

    /// Strength for ranking: see [`strength`].
    pub fn strength(&self) -> f32 {
        strength(self.response, self.snr)
    }

    /// Whether it was found on the rim of the slopes of `params` or, if each slope is searched for itself, nearest to
    /// it: nothing beyond allows interpolation, so its slope is less exact. (A joint extremum exceeds the rim.)
    pub fn is_on_rim(&self, params: &DetectorParams) -> bool {
        let grid = params.used_slopes();
        let (i, j) = grid.coordinates(self.slope_index);
        grid.on_rim(i, j) || (params.used_extrema() == SlopeExtrema::Each && grid.nearest_on_rim(self.slope))
    }
}

/// A 128-element descriptor: 4×4 cells (rows of cells from the top in the feature's own frame, u fastest) × 8
/// orientations, L1-root normalised, ×512, clamped to 255, in UBC/COLMAP's order.
pub type Descriptor = [u8; 128];

/// Wall-clock time spent in each stage of a detection, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct StageTimes {
    /// Time for estimating the noise and the field of motion.
    pub noise_secs: f32,
    /// Time for stacking, filtering and searching.
    pub search_secs: f32,
    /// Time for localising, orientations and descriptors.
    pub describe_secs: f32,
}

impl StageTimes {
    /// Sum over all stages.
    pub fn total_secs(&self) -> f32 {
        self.noise_secs + self.search_secs + self.describe_secs
    }
}

/// Result of the detector: features with descriptors, and the data that a search used and found on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// Features, strongest first (by [`Feature::strength`], ties by place).
    pub features: Vec<Feature>,
    /// One descriptor for each feature, in the features' order.
    pub descriptors: Vec<Descriptor>,
    /// Numbers of samples by the test that rejected them, and of those kept.
    pub tally: Tally,
    /// Standard deviation of one frame's noise, fraction of full scale.
    pub frame_noise: f32,
    /// Noise model with which the gate was computed.
    pub noise: Arc<NoiseModel>,
    /// Motion of every place; `None` where the burst shows none (see [`motion_field`](super::field::motion_field)).
    pub field: Option<Arc<MotionField>>,
    /// Noise gate's factor that was used (derived, if it was automatic).
    pub noise_gate_factor: f32,
    /// Slopes that were searched.
    pub slopes: SlopeGrid,
    /// Indices into the burst of the frames that took part.
    pub frames_used: std::ops::Range<usize>,
    /// Positions of these frames.
    pub positions: Positions,
    /// Octaves that were searched.
    pub octaves: std::ops::Range<i32>,
    /// Wall-clock time by stage.
    pub times: StageTimes,
}

impl Detection {
    /// The detection as one of the frames that `params` use of `burst`, which a method may have merged before.
    pub fn over(self, burst: &Burst, params: &DetectorParams) -> Self {
        let frames_used = params.used_frames(burst.len());
        Self { positions: burst.positions.part(frames_used.clone()), frames_used, ..self }
    }
}

/// An extremum of D that passed every test of the search, at the place and scale of the quadratic fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keypoint {
    /// Octave in which it was found; −1 is the doubled image.
    pub octave: i32,
    /// Column, octave pixels.
    pub x: f32,
    /// Row, octave pixels.
    pub y: f32,
    /// Scale, octave pixels.
    pub sigma_octave: f32,
    /// DoG level within the octave, 0 … levels−1.
    pub level: i32,
    /// The sample (column, row), octave pixels; no other keypoint of the octave, level and slope has it.
    pub sample: [u32; 2],
    /// Index in the slope grid.
    pub slope_index: usize,
    /// Slope, refined between those of the grid; pixels per frame.
    pub slope: Slope,
    /// D at the keypoint with its sign, fraction of full scale.
    pub value: f32,
    /// |D| over its noise; infinite for a noiseless burst.
    pub snr: f32,
}

impl Keypoint {
    /// Place (u, v) and scale σ in input pixels.
    pub fn in_image(&self) -> (f32, f32, f32) {
        let pixel = octave_pixel(self.octave);
        (self.x * pixel, self.y * pixel, self.sigma_octave * pixel)
    }

    pub(crate) fn with_noise(self, sigma_d: f32) -> Self {
        Self { snr: if sigma_d > 0.0 { self.value.abs() / sigma_d } else { f32::INFINITY }, ..self }
    }

    /// Strength for ranking: see [`strength`].
    pub fn strength(&self) -> f32 {
        strength(self.value, self.snr)
    }
}

/// Strength of a response for ranking: |response|·√snr, or |response| where the burst has no noise.
///
/// Response alone puts fine-scale noise above large faint blobs; signal-to-noise alone the weak hollows between large
/// blobs. Their product found most discs of the charts, over powers 0, ½, 1 and 2 of the snr.
pub fn strength(response: f32, snr: f32) -> f32 {
    response.abs() * if snr.is_finite() { snr.sqrt() } else { 1.0 }
}

/// Revision of the detector. It goes up by one with every change after which an unchanged burst and unchanged
/// parameters give other bits of any feature or descriptor, but not with new parameters whose defaults change nothing.
pub const REVISION: u32 = 19;

#[cfg(test)]
mod tests {
    use super::super::pipeline::search;
    use super::*;
    use crate::monitor::Monitor;
    use crate::synth::{ChartParams, Motion, synth_chart};

    /// Results of this revision on a small chart: features; sums over all of |u|, |v|, σ, |slope u|, |response|·10³;
    /// mean of the descriptors' values. Sums, with a tolerance, because processors round the last bit differently.
    const FOUND: (u32, usize, [f64; 6]) =
        (19, 140, [11858.151178, 12447.308279, 543.862808, 113.796307, 88.636163, 34.802567]);

    #[test]
    fn other_features_come_with_another_revision() {
        let chart =
            ChartParams { width: 200, height: 150, discs: 10, radius: 3.6..=9.0, snr: 2.0, ..ChartParams::default() };
        let chart = ChartParams { motion: Motion::TwoD, max_slope: 1.0, ..chart };
        let (burst, _) = synth_chart(&chart, &Monitor::default()).expect("a chart");
        let slopes = SlopeGrid::plane(-1.0..=1.0, 3, -1.0..=1.0, 3);
        let params = DetectorParams { slopes, ..DetectorParams::default() };
        let detection = search(&burst, &params, &Monitor::default()).expect("a detection");
        let sum =
            |value: fn(&Feature) -> f32| detection.features.iter().map(|f| f64::from(value(f).abs())).sum::<f64>();
        let elements = detection.descriptors.iter().flatten();
        let mean = elements.map(|&x| f64::from(x)).sum::<f64>() / (128.0 * detection.descriptors.len().max(1) as f64);
        let sums = [sum(|f| f.u), sum(|f| f.v), sum(|f| f.sigma), sum(|f| f.slope.u), 1e3 * sum(|f| f.response), mean];
        let (revision, features, expected) = FOUND;
        let same = features == detection.features.len()
            && expected.iter().zip(&sums).all(|(a, b)| (a - b).abs() <= 1e-4 * b.abs());
        assert!(
            same && revision == REVISION,
            "features have changed: raise REVISION, and let FOUND be (revision, {}, {sums:.6?})",
            detection.features.len()
        );
    }
}
