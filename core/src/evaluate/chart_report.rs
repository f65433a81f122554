//! The report of a study of charts: rows of ratios, which hold methods, which hold charts.

use super::methods::BurstMethod;
use super::motion_name;
use super::score::{Curve, Ranking};
use super::statistics::Mean;
use crate::detector::{DetectorParams, SlopeGrid};
use crate::synth::{ChartParams, RadiusLaw};
use serde::Serialize;

/// Report of a study of charts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChartReport {
    /// Parameters of the charts.
    pub chart: ChartSummary,
    /// Setup of the comparison of methods.
    #[serde(flatten)]
    pub setup: ComparisonSetup,
    /// One row for each ratio.
    pub rows: Vec<ChartRow>,
}

/// Setup of a comparison of methods: the part before the rows of every report of charts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparisonSetup {
    /// The first seed.
    pub first_seed: u64,
    /// Number of seeds.
    pub seeds: u64,
    /// Quantity by which features were ranked.
    pub ranking: Ranking,
    /// Share of false detections at which methods were compared.
    pub false_fraction: f64,
    /// The detector's parameters; method and slopes were set by each method.
    pub detector: DetectorParams,
    /// Slopes of BuFF 1D.
    pub slopes_1d: SlopeGrid,
    /// Slopes of BuFF 2D.
    pub slopes_2d: SlopeGrid,
}

/// Parameters of the charts of a report.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChartSummary {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Number of discs.
    pub discs: usize,
    /// Smallest and largest radius, pixels.
    pub radius: [f64; 2],
    /// Distribution of the radii between these.
    pub radius_law: RadiusLaw,
    /// Intensity of a disc over that of the background.
    pub contrast: f64,
    /// Number of frames.
    pub frames: usize,
    /// Directions of motion, `1d` or `2d`.
    pub motion: &'static str,
    /// Largest slope on each axis that moves, pixels per frame.
    pub max_slope: f64,
    /// Standard deviation of the read noise, electrons.
    pub read_noise: f64,
    /// Bits of the converter.
    pub bits: u32,
}

impl From<&ChartParams> for ChartSummary {
    fn from(chart: &ChartParams) -> Self {
        Self {
            width: chart.width,
            height: chart.height,
            discs: chart.discs,
            radius: [*chart.radius.start(), *chart.radius.end()],
            radius_law: chart.radius_law,
            contrast: chart.contrast,
            frames: chart.frames,
            motion: motion_name(chart.motion),
            max_slope: chart.max_slope,
            read_noise: chart.read_noise,
            bits: chart.bits,
        }
    }
}

/// All methods at one ratio.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChartRow {
    /// Per-pixel signal-to-noise ratio.
    pub snr: f64,
    /// The methods, in the study's order.
    pub methods: Vec<MethodReport>,
}

/// One method at one ratio; means are over the seeds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodReport {
    /// The method.
    pub method: BurstMethod,
    /// Discs found at the threshold where the requested share of the detections is false.
    pub true_positives: Mean,
    /// Discs found among all features that the detector returned.
    pub default_true_positives: Mean,
    /// False features among all features that the detector returned.
    pub default_false_features: Mean,
    /// Ratio of the detector's estimate of a frame's noise to the true one at the background; absent for mean and
    /// merged images and for charts without noise.
    pub noise_estimate_ratio: Option<Mean>,
    /// Mean count of discs found with at most 0, 1, 2 … false features.
    pub roc: Vec<f64>,
    /// Scores on each chart, in the order of the seeds.
    pub charts: Vec<ChartScore>,
}

/// Scores of one method on one chart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChartScore {
    /// The chart's seed.
    pub seed: u64,
    /// Discs found at the threshold where the requested share of the detections is false.
    pub true_positives: usize,
    /// Discs found among all features that the detector returned.
    pub default_true_positives: usize,
    /// False features among all features that the detector returned.
    pub default_false_features: usize,
    /// Ratio of the estimate of a frame's noise to the true one, where both are known.
    pub noise_estimate_ratio: Option<f64>,
    /// True against false features over all thresholds. Not part of the JSON, which holds the mean over the seeds.
    #[serde(skip)]
    pub curve: Curve,
}
