//! Detection in the dark: the discs of a chart that each method finds, over signal-to-noise ratios and seeds.
//!
//! For every ratio and seed one chart is made, and every method runs on it with the same parameters. A table shows the
//! discs found at the threshold where a tenth of the detections are false, the mean over the seeds: the best that any
//! threshold achieves, which compares methods independently of their defaults. Counts *at* the defaults stand beside.

use super::methods::{BurstMethod, Searches};
use super::statistics::Mean;
use super::{RatioCharts, Steps, check_lists, motion_name, run_charts};
use crate::synth::{ChartParams, RadiusLaw, Truth, synth_chart};
use burstscope_core::burst::Burst;
use burstscope_core::detect::Searched;
use burstscope_core::detector::Detection;
use burstscope_core::error::{Error, Result};
use burstscope_core::inspect::result::{Curve, Ranking, Scored, judge, mean_curve};
use burstscope_core::monitor::Monitor;
use serde::Serialize;

/// Methods to be compared, and their charts.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartStudy {
    /// Parameters of the charts; their ratio and seed are set by the study.
    pub chart: ChartParams,
    /// Per-pixel signal-to-noise ratios, one row of the table each.
    pub snrs: Vec<f64>,
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
            first_seed: 1,
            seeds: 5,
            methods: BurstMethod::WITH_GIVEN_SLOPES.to_vec(),
            searches: Searches::default(),
            ranking: Ranking::Strength,
            false_fraction: 0.10,
        }
    }
}

/// One chart with its search, for a look at it.
#[derive(Debug, Clone)]
pub struct LookedChart {
    /// Frames of the chart.
    pub burst: Burst,
    /// Discs of the chart.
    pub truth: Truth,
    /// Detection of the method.
    pub detection: Detection,
    /// Judgements of the features, strongest first.
    pub judged: Vec<Scored>,
}

impl ChartStudy {
    pub(super) fn check(&self) -> Result<()> {
        check_lists(&self.snrs, self.seeds)?;
        if self.methods.is_empty() {
            return Err(Error::param("methods", "none is given", "give one or more, such as sift-mean,buff-1d"));
        }
        if !(0.0..=1.0).contains(&self.false_fraction) {
            let remedy = "give a share from 0 to 1, such as 0.1";
            return Err(Error::param("false-fraction", self.false_fraction.to_string(), remedy));
        }
        // All methods are checked before the first chart is made: a late error would lose the finished charts.
        for &method in &self.methods {
            let params = self.searches.params(method).at_given();
            let positions = self.chart.uneven.whole(self.chart.frames);
            params.validate_for(&positions, (self.chart.width, self.chart.height))?;
        }
        Ok(())
    }

    pub(super) fn setup(&self) -> ComparisonSetup {
        ComparisonSetup {
            first_seed: self.first_seed,
            seeds: self.seeds,
            ranking: self.ranking,
            false_fraction: self.false_fraction,
            searches: self.searches.clone(),
        }
    }

    /// Makes the charts, runs the methods and scores their features.
    ///
    /// # Errors
    /// A parameter of study, chart or detector that makes no sense, or cancellation.
    pub fn run(&self, monitor: &Monitor) -> Result<ChartReport> {
        self.run_telling(monitor, &|_| {})
    }

    /// Runs the study as `run` does; calls `tell` with the report so far after every chart, one call at a time.
    pub fn run_telling(&self, monitor: &Monitor, tell: &(dyn Fn(ChartReport) + Sync)) -> Result<ChartReport> {
        self.check()?;
        let scores = |snr: f64, seed: u64, monitor: &Monitor, steps: &Steps<'_>| {
            let (burst, truth) = synth_chart(&self.chart_of(snr, seed), monitor)?;
            let score = |&method: &BurstMethod| {
                let detection = self.searches.search(method, &burst, monitor)?.detection;
                steps.done();
                Ok(self.score(method, seed, &detection, &truth))
            };
            self.methods.iter().map(score).collect::<Result<Vec<ChartScore>>>()
        };
        let seeds = self.first_seed..self.first_seed.saturating_add(self.seeds);
        run_charts(&self.snrs, seeds, self.methods.len(), monitor, scores, |charts| self.report(charts), tell)
    }

    /// Makes one chart and runs `method` on it, for a look at a point of a curve; errors as of [`Self::run`].
    pub fn look(&self, snr: f64, seed: u64, method: BurstMethod, monitor: &Monitor) -> Result<LookedChart> {
        let (burst, truth) = synth_chart(&self.chart_of(snr, seed), monitor)?;
        let Searched { detection, .. } = self.searches.search(method, &burst, monitor)?;
        let judged = judge(&detection.features, &truth, self.ranking);
        Ok(LookedChart { burst, truth, detection, judged })
    }

    /// The parameters of the chart of a ratio and a seed.
    pub fn chart_of(&self, snr: f64, seed: u64) -> ChartParams {
        ChartParams { snr, seed, ..self.chart.clone() }
    }

    fn report(&self, charts: &[RatioCharts<Vec<ChartScore>>]) -> ChartReport {
        let row = |(snr, charts): &RatioCharts<Vec<ChartScore>>| {
            let method = |(index, &method): (usize, &BurstMethod)| {
                self.method_report(method, charts.iter().map(|scores| scores[index].clone()).collect())
            };
            ChartRow { snr: *snr, methods: self.methods.iter().enumerate().map(method).collect() }
        };
        ChartReport { chart: (&self.chart).into(), setup: self.setup(), rows: charts.iter().map(row).collect() }
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
        let mean = |count: fn(&ChartScore) -> usize| {
            Mean::of(&charts.iter().map(|chart| count(chart) as f64).collect::<Vec<_>>())
        };
        let ratios: Vec<f64> = charts.iter().filter_map(|chart| chart.noise_estimate_ratio).collect();
        // The paper chooses one peak threshold for all charts together (IV-A), so the curves are pooled, not averaged.
        let by_response = Curve::pooled(&charts.iter().map(|chart| &chart.by_response).collect::<Vec<_>>());
        let peak_threshold = by_response.at_false_fraction(self.false_fraction).threshold;
        let curves: Vec<&Curve> = charts.iter().map(|chart| &chart.curve).collect();
        MethodReport {
            method,
            true_positives: mean(|chart| chart.true_positives),
            default_true_positives: mean(|chart| chart.default_true_positives),
            default_false_features: mean(|chart| chart.default_false_features),
            default_false_per_disc: (self.chart.discs > 0).then(|| {
                let discs = self.chart.discs as f64;
                Mean::of(&charts.iter().map(|chart| chart.default_false_features as f64 / discs).collect::<Vec<_>>())
            }),
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
    pub chart: ChartSummary,
    #[serde(flatten)]
    pub setup: ComparisonSetup,
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
    /// Parameters of the methods' searches.
    #[serde(flatten)]
    pub searches: Searches,
}

/// Parameters of the charts of a report.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct ChartSummary {
    pub width: usize,
    pub height: usize,
    pub discs: usize,
    /// Smallest and largest radius, pixels.
    pub radius: [f64; 2],
    /// Distribution of the radii between these.
    pub radius_law: RadiusLaw,
    /// Intensity of a disc over that of the background.
    pub contrast: f64,
    pub frames: usize,
    /// Directions of motion, `1d` or `2d`.
    pub motion: &'static str,
    /// Largest slope on each axis that moves, pixels per frame.
    pub max_slope: f64,
    /// Standard deviation of the read noise, electrons.
    pub read_noise: f64,
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
            frames: chart.uneven.count_and_span(chart.frames).0,
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
