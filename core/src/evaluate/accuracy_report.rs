//! What a study of accuracy reports: the errors at each ratio.

use super::chart_report::ChartSummary;
use super::statistics::Errors;
use crate::detector::DetectorParams;
use serde::Serialize;

/// What a study found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AccuracyReport {
    /// The charts.
    pub chart: ChartSummary,
    /// The first seed.
    pub first_seed: u64,
    /// Number of seeds.
    pub seeds: u64,
    /// The detector's parameters.
    pub detector: DetectorParams,
    /// One row a ratio.
    pub rows: Vec<AccuracyRow>,
}

/// The errors at one ratio, over all seeds together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AccuracyRow {
    /// Per-pixel signal-to-noise ratio; null in JSON for charts without noise.
    pub snr: f64,
    /// Discs that move within the grid's range, between its outermost slopes.
    pub within: RangeCount,
    /// Discs that move faster than that.
    pub beyond: RangeCount,
    /// Columns, pixels.
    pub u: Errors,
    /// Rows, pixels.
    pub v: Errors,
    /// Distances from the true places, pixels: median and 95 %.
    pub distance: [f64; 2],
    /// How many of the discs compared stand apart, see [`super::accuracy::stands_apart`].
    pub apart: usize,
    /// Distances of those from their true places, pixels: median and 95 %.
    pub distance_apart: [f64; 2],
    /// σ over the expected one, minus 1.
    pub scale: Errors,
    /// Slopes to the right, pixels per frame.
    pub slope_u: Errors,
    /// Slopes down, pixels per frame.
    pub slope_v: Errors,
    /// Lengths of the slopes' errors, pixels per frame: median and 95 %.
    pub slope_distance: [f64; 2],
}

/// How many discs there are, how many are found, and how many of those are marked as lying at the limit of the slopes
/// searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct RangeCount {
    /// Discs.
    pub discs: usize,
    /// Discs that were found.
    pub found: usize,
    /// Found discs whose feature is marked `at_slope_limit`.
    pub marked: usize,
}
