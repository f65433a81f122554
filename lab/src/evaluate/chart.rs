//! Detection in the dark: the discs of a chart that each method finds, over signal-to-noise ratios and seeds.
//!
//! For every ratio and seed one chart is made, and every method runs on it with the same parameters. A table shows the
//! discs found at the threshold where a tenth of the detections are false, the mean over the seeds: the best that any
//! threshold achieves, which compares methods independently of their defaults. Counts *at* the defaults stand beside.
//!
//! Instead of ratios the rows may be numbers of frames, at one ratio (the paper's Fig. 6): every number n has charts of
//! its own, with n frames and the truth at their own mid-burst. [`super::BurstFramesStudy`] measures a given burst.

use super::methods::{BurstMethod, Searches};
use super::{RowStudy, ascending, check_lists, motion_name, statistics::Mean};
use crate::synth::{ChartParams, Truth, synth_chart};
use burstscope_core::error::{Error, Result};
use burstscope_core::inspect::result::{Curve, Ranking, Scored, judge, mean_curve};
use burstscope_core::{burst::Burst, detect::Searched, detector::Detection, monitor::Monitor};
use serde::{Serialize, Serializer, ser::SerializeMap};
use std::fmt;

/// Default numbers of frames.
pub const FRAME_COUNTS: [usize; 9] = [2, 3, 4, 5, 6, 8, 10, 12, 15];

/// Methods to be compared, and their charts.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartStudy {
    /// Parameters of the charts; the study sets ratio, seed and, from `frame_counts`, the number of frames.
    pub chart: ChartParams,
    /// Per-pixel signal-to-noise ratios, one row of the table each.
    pub snrs: Vec<f64>,
    /// Numbers of frames, one row of the table each, at the one ratio; in any order, duplicates count once. Empty where
    /// the rows are ratios.
    pub frame_counts: Vec<usize>,
    /// The first seed.
    pub first_seed: u64,
    /// Number of seeds, counting up from the first; 1 or more.
    pub seeds: u64,
    /// The methods, each at most once.
    pub methods: Vec<BurstMethod>,
    /// Parameters of their searches.
    pub searches: Searches,
    /// Quantity by which features are ranked.
    pub ranking: Ranking,
    /// Share of false detections at which methods are compared, 0 … 1.
    pub false_fraction: f64,
}

impl Default for ChartStudy {
    /// Five charts at each of three ratios in the dark.
    fn default() -> Self {
        Self {
            chart: ChartParams::default(),
            snrs: vec![0.2, 0.35, 0.6],
            frame_counts: Vec::new(),
            first_seed: 1,
            seeds: 5,
            methods: BurstMethod::WITH_GIVEN_SLOPES.to_vec(),
            searches: Searches::default(),
            ranking: Ranking::Strength,
            false_fraction: 0.10,
        }
    }
}

/// Property in which the charts of a row differ from others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RowAt {
    /// Per-pixel signal-to-noise ratio.
    Snr(f64),
    /// Number of frames.
    Frames(usize),
}

impl RowAt {
    /// The ratio, or the number of frames.
    pub fn value(self) -> f64 {
        match self {
            Self::Snr(snr) => snr,
            Self::Frames(frames) => frames as f64,
        }
    }

    /// The value with its name.
    pub fn label(self) -> String {
        match self {
            Self::Snr(snr) => format!("SNR {snr}"),
            Self::Frames(frames) => format!("{frames} frames"),
        }
    }
}

impl fmt::Display for RowAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.value().fmt(f)
    }
}

/// One chart with its search, for a look at it.
#[derive(Debug, Clone)]
#[allow(missing_docs)] // where a name says it
pub struct LookedChart {
    pub burst: Burst,
    pub truth: Truth,
    pub detection: Detection,
    /// Judgements of the features, strongest first.
    pub judged: Vec<Scored>,
}

impl RowStudy for ChartStudy {
    type Row = RowAt;
    type Cell = Vec<ChartScore>;
    type Report = ChartReport;

    fn check(&self) -> Result<()> {
        check_lists(&self.snrs, self.seeds)?;
        if !self.frame_counts.is_empty() && self.snrs.len() > 1 {
            let problem = format!("{} ratios", self.snrs.len());
            return Err(Error::param("snr", problem, "give one; the number of frames is what changes"));
        }
        if self.methods.is_empty() {
            return Err(Error::param("methods", "none is given", "give one or more, such as sift-mean,buff-1d"));
        }
        if !(0.0..=1.0).contains(&self.false_fraction) {
            let remedy = "give a share from 0 to 1, such as 0.1";
            return Err(Error::param("false-fraction", self.false_fraction.to_string(), remedy));
        }
        for row in self.rows() {
            let chart = self.chart_of(row, self.first_seed);
            for &method in &self.methods {
                let params = self.searches.params(method).at_given();
                params.validate_for(&chart.uneven.whole(chart.frames), (chart.width, chart.height))?;
            }
        }
        Ok(())
    }

    fn rows(&self) -> Vec<RowAt> {
        if self.frame_counts.is_empty() {
            return self.snrs.iter().copied().map(RowAt::Snr).collect();
        }
        ascending(&self.frame_counts).into_iter().map(RowAt::Frames).collect()
    }

    fn seeds(&self) -> (u64, u64) {
        (self.first_seed, self.seeds)
    }

    fn steps(&self, row: RowAt) -> usize {
        self.methods.len() * steps_of_method(row)
    }

    fn cell(&self, row: RowAt, seed: u64, monitor: &Monitor, done: &(dyn Fn(usize) + Sync)) -> Result<Vec<ChartScore>> {
        let (burst, truth) = synth_chart(&self.chart_of(row, seed), monitor)?;
        let score = |&method: &BurstMethod| {
            let detection = self.searches.search(method, &burst, monitor)?.detection;
            done(steps_of_method(row));
            Ok(self.score(method, seed, &detection, &truth))
        };
        self.methods.iter().map(score).collect()
    }

    fn report(&self, rows: &[(RowAt, Vec<Vec<ChartScore>>)]) -> ChartReport {
        let row = |(at, charts): &(RowAt, Vec<Vec<ChartScore>>)| {
            let method = |(index, &method): (usize, &BurstMethod)| {
                self.method_report(method, charts.iter().map(|scores| scores[index].clone()).collect())
            };
            ChartRow { at: *at, methods: self.methods.iter().enumerate().map(method).collect() }
        };
        let last = self.rows().into_iter().next_back().unwrap_or(RowAt::Snr(self.chart.snr));
        let &Self { first_seed, seeds, ranking, false_fraction, .. } = self;
        ChartReport {
            chart: self.chart_of(last, self.first_seed),
            snr: (!self.frame_counts.is_empty()).then(|| self.snrs[0]),
            setup: ComparisonSetup { first_seed, seeds, ranking, false_fraction, searches: self.searches.clone() },
            rows: rows.iter().map(row).collect(),
        }
    }
}

/// A chart of twice as many frames takes about twice as long.
fn steps_of_method(row: RowAt) -> usize {
    if let RowAt::Frames(frames) = row { frames } else { 1 }
}

impl ChartStudy {
    /// The row whose value is `value`: a ratio, or a number of frames.
    pub fn row_at(&self, value: f64) -> RowAt {
        if self.frame_counts.is_empty() { RowAt::Snr(value) } else { RowAt::Frames(value as usize) }
    }

    /// Makes one chart and runs `method` on it, for a look at a point of a curve; errors as of a run.
    pub fn look(&self, row: RowAt, seed: u64, method: BurstMethod, monitor: &Monitor) -> Result<LookedChart> {
        let (burst, truth) = synth_chart(&self.chart_of(row, seed), monitor)?;
        let Searched { detection, .. } = self.searches.search(method, &burst, monitor)?;
        let judged = judge(&detection.features, &truth, self.ranking);
        Ok(LookedChart { burst, truth, detection, judged })
    }

    /// The parameters of the chart of a row and a seed.
    pub fn chart_of(&self, row: RowAt, seed: u64) -> ChartParams {
        match row {
            RowAt::Snr(snr) => ChartParams { snr, seed, ..self.chart.clone() },
            RowAt::Frames(frames) => ChartParams { snr: self.snrs[0], frames, seed, ..self.chart.clone() },
        }
    }

    fn score(&self, method: BurstMethod, seed: u64, detection: &Detection, truth: &Truth) -> ChartScore {
        let curve_by = |ranking| Curve::of(&judge(&detection.features, truth, ranking));
        let curve = curve_by(self.ranking);
        // Mean and merged images have less noise than a frame, so that no truth compares with their estimate.
        let of_one_frame = !matches!(method, BurstMethod::SiftMean | BurstMethod::SiftMerge);
        ChartScore {
            seed,
            true_positives: curve.at_false_fraction(self.false_fraction).true_positives,
            default_true_positives: curve.end().true_positives,
            default_false_features: curve.end().false_features,
            noise_estimate_ratio: (truth.noise.filter(|_| of_one_frame))
                .map(|noise| f64::from(detection.frame_noise) / noise.sigma_background),
            by_response: curve_by(Ranking::Response),
            curve,
        }
    }

    fn method_report(&self, method: BurstMethod, charts: Vec<ChartScore>) -> MethodReport {
        let mean = |of_chart: &dyn Fn(&ChartScore) -> f64| Mean::of(&charts.iter().map(of_chart).collect::<Vec<_>>());
        let discs = self.chart.discs as f64;
        let ratios: Vec<f64> = charts.iter().filter_map(|chart| chart.noise_estimate_ratio).collect();
        // The paper chooses one peak threshold for all charts together (IV-A), so the curves are pooled, not averaged.
        let by_response = Curve::pooled(&charts.iter().map(|chart| &chart.by_response).collect::<Vec<_>>());
        let peak_threshold = by_response.at_false_fraction(self.false_fraction).threshold;
        let curves: Vec<&Curve> = charts.iter().map(|chart| &chart.curve).collect();
        MethodReport {
            method,
            true_positives: mean(&|chart| chart.true_positives as f64),
            default_true_positives: mean(&|chart| chart.default_true_positives as f64),
            default_false_features: mean(&|chart| chart.default_false_features as f64),
            default_false_per_disc: (discs > 0.0).then(|| mean(&|chart| chart.default_false_features as f64 / discs)),
            noise_estimate_ratio: (!ratios.is_empty()).then(|| Mean::of(&ratios)),
            peak_threshold: peak_threshold.is_finite().then_some(peak_threshold),
            roc: mean_curve(&curves, self.chart.discs.div_ceil(2)),
            charts,
        }
    }
}

/// Report of a study of charts.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // the names say it
pub struct ChartReport {
    /// Parameters of the charts; of several numbers of frames the largest.
    #[serde(serialize_with = "summary")]
    pub chart: ChartParams,
    /// Per-pixel signal-to-noise ratio, where the rows are numbers of frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub snr: Option<f64>,
    #[serde(flatten)]
    pub setup: ComparisonSetup,
    /// One row for each ratio, or for each number of frames, the smallest first.
    pub rows: Vec<ChartRow>,
}

/// Setup of a comparison of methods: the part before the rows of every report of charts.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct ComparisonSetup {
    pub first_seed: u64,
    pub seeds: u64,
    pub ranking: Ranking,
    pub false_fraction: f64,
    #[serde(flatten)]
    pub searches: Searches,
}

/// Writes what a report says of its charts: `radius` as [smallest, largest], `frames` with all views counted.
pub(super) fn summary<S: Serializer>(chart: &ChartParams, serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(None)?;
    map.serialize_entry("width", &chart.width)?;
    map.serialize_entry("height", &chart.height)?;
    map.serialize_entry("discs", &chart.discs)?;
    map.serialize_entry("radius", &[*chart.radius.start(), *chart.radius.end()])?;
    map.serialize_entry("radius_law", &chart.radius_law)?;
    map.serialize_entry("contrast", &chart.contrast)?;
    map.serialize_entry("frames", &chart.uneven.count_and_span(chart.frames).0)?;
    map.serialize_entry("motion", motion_name(chart.motion))?;
    map.serialize_entry("max_slope", &chart.max_slope)?;
    map.serialize_entry("read_noise", &chart.read_noise)?;
    map.serialize_entry("bits", &chart.bits)?;
    map.end()
}

/// All methods on the charts of one row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChartRow {
    /// Ratio or number of frames.
    #[serde(flatten)]
    pub at: RowAt,
    /// The methods, in the study's order.
    pub methods: Vec<MethodReport>,
}

/// One method in one row; means are over the seeds.
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
    /// Mean number of false features for each disc of the chart; absent for charts without discs.
    pub default_false_per_disc: Option<Mean>,
    /// Estimated over true noise of a frame at the background; absent for mean and merged images, and without noise.
    pub noise_estimate_ratio: Option<Mean>,
    /// Peak threshold of |response| for the requested share of false detections over all charts (BuFF, IV-A), if any.
    pub peak_threshold: Option<f32>,
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
    /// True against false features over all peak thresholds. Not part of the JSON.
    #[serde(skip)]
    pub by_response: Curve,
    /// True against false features over all thresholds. Not part of the JSON, which holds the mean over the seeds.
    #[serde(skip)]
    pub curve: Curve,
}
