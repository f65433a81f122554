//! The report of a study of accuracy: the errors at each ratio.

use super::chart_report::ChartSummary;
use super::statistics::Errors;
use crate::detector::DetectorParams;
use serde::Serialize;

/// Report of a study of accuracy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AccuracyReport {
    /// Parameters of the charts.
    pub chart: ChartSummary,
    /// The first seed.
    pub first_seed: u64,
    /// Number of seeds.
    pub seeds: u64,
    /// The detector's parameters.
    pub detector: DetectorParams,
    /// One row for each ratio.
    pub rows: Vec<AccuracyRow>,
}

/// The errors at one ratio, over all seeds together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AccuracyRow {
    /// Per-pixel signal-to-noise ratio; null in JSON for charts without noise.
    pub snr: f64,
    /// Discs that move within the grid's range, between its outermost slopes.
    pub within: RangeCount,
    /// Discs that move faster than that range.
    pub beyond: RangeCount,
    /// Errors of the columns, pixels.
    pub u: Errors,
    /// Errors of the rows, pixels.
    pub v: Errors,
    /// Distances from the true positions, pixels: median and 95 %.
    pub distance: [f64; 2],
    /// Number of compared discs that stand apart, see [`super::accuracy::stands_apart`].
    pub apart: usize,
    /// Distances of those from their true positions, pixels: median and 95 %.
    pub distance_apart: [f64; 2],
    /// Relative errors of scale: σ over the expected one, minus 1.
    pub scale: Errors,
    /// Errors of the slopes to the right, pixels per frame.
    pub slope_u: Errors,
    /// Errors of the slopes down, pixels per frame.
    pub slope_v: Errors,
    /// Lengths of the slopes' errors, pixels per frame: median and 95 %.
    pub slope_distance: [f64; 2],
}

/// Numbers of discs, of discs found, and of those marked as lying at the limit of the slopes searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct RangeCount {
    /// Number of discs.
    pub discs: usize,
    /// Number of discs that were found.
    pub found: usize,
    /// Number of found discs whose feature is marked `at_slope_limit`.
    pub marked: usize,
}
