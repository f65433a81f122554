//! In the dark: how many of a chart's discs each method finds, over signal-to-noise ratios and seeds.
//!
//! For every ratio and seed one chart is made, and every method runs on it with the same parameters. The number that a
//! table shows is the count of discs found at the threshold where a tenth of the detections are false, the mean over
//! the seeds. It is the best that a threshold can do, and so compares methods whatever their defaults; what they
//! do *at* their defaults stands beside it.

use super::jobs::run_jobs;
use super::methods::{BurstMethod, Searches};
use super::score::{Curve, Ranking, judge, mean_curve};
use super::statistics::Mean;
use super::{EvaluateError, check_lists, motion_name};
use crate::detector::{Detection, DetectorParams, SlopeGrid};
use crate::monitor::Monitor;
use crate::synth::{ChartParams, RadiusLaw, Truth, synth_chart};
use serde::Serialize;

/// What is to be compared, and on which charts.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartStudy {
    /// The charts; their ratio and seed are set by the study.
    pub chart: ChartParams,
    /// Per-pixel signal-to-noise ratios, one row of the table each.
    pub snrs: Vec<f64>,
    /// The first seed.
    pub first_seed: u64,
    /// How many seeds, counting up from the first; 1 or more.
    pub seeds: u64,
    /// The methods, each at most once.
    pub methods: Vec<BurstMethod>,
    /// The detector's parameters, for all methods; method and slopes are set by each of them.
    pub detector: DetectorParams,
    /// The slopes of BuFF 1D.
    pub slopes_1d: SlopeGrid,
    /// The slopes of BuFF 2D.
    pub slopes_2d: SlopeGrid,
    /// The direction in which a method that finds slopes looks for them, degrees from +u towards +v; `None`: anywhere
    /// in the plane.
    pub direction_deg: Option<f32>,
    /// By what features are ranked.
    pub ranking: Ranking,
    /// The share of false detections at which methods are compared, 0 … 1.
    pub false_fraction: f64,
}

impl Default for ChartStudy {
    /// Five charts at each of three ratios in the dark; 13 slopes in 1D and 7×7 in 2D over the chart's ±3 px/frame.
    fn default() -> Self {
        Self {
            chart: ChartParams::default(),
            snrs: vec![0.2, 0.35, 0.6],
            first_seed: 1,
            seeds: 5,
            methods: BurstMethod::WITH_GIVEN_SLOPES.to_vec(),
            detector: DetectorParams::default(),
            slopes_1d: SlopeGrid::line(-3.0..=3.0, 13),
            slopes_2d: SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7),
            direction_deg: None,
            ranking: Ranking::Strength,
            false_fraction: 0.10,
        }
    }
}

/// What a study found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChartReport {
    /// The charts.
    pub chart: ChartSummary,
    /// The first seed.
    pub first_seed: u64,
    /// Number of seeds.
    pub seeds: u64,
    /// By what features were ranked.
    pub ranking: Ranking,
    /// The share of false detections at which methods were compared.
    pub false_fraction: f64,
    /// The detector's parameters; method and slopes were set by each method.
    pub detector: DetectorParams,
    /// The slopes of BuFF 1D.
    pub slopes_1d: SlopeGrid,
    /// The slopes of BuFF 2D.
    pub slopes_2d: SlopeGrid,
    /// One row a ratio.
    pub rows: Vec<ChartRow>,
}

/// The charts of a report.
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
    /// How radii are spread between these.
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
    /// Discs found at the threshold where the asked-for share of the detections is false.
    pub true_positives: Mean,
    /// Discs found among all that the detector returned.
    pub default_true_positives: Mean,
    /// False features among all that the detector returned.
    pub default_false_features: Mean,
    /// The detector's estimate of a frame's noise over the true one at the background; absent for mean and merged
    /// images and for charts without noise.
    pub noise_estimate_ratio: Option<Mean>,
    /// Mean count of discs found with at most 0, 1, 2 … false features.
    pub roc: Vec<f64>,
    /// Each chart on its own, in the order of the seeds.
    pub charts: Vec<ChartScore>,
}

/// One method on one chart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChartScore {
    /// The chart's seed.
    pub seed: u64,
    /// Discs found at the threshold where the asked-for share of the detections is false.
    pub true_positives: usize,
    /// Discs found among all that the detector returned.
    pub default_true_positives: usize,
    /// False features among all that the detector returned.
    pub default_false_features: usize,
    /// The estimate of a frame's noise over the true one, where that can be said.
    pub noise_estimate_ratio: Option<f64>,
    /// True against false features over all thresholds. Not part of the JSON, which has the mean over the seeds.
    #[serde(skip)]
    pub curve: Curve,
}

impl ChartStudy {
    fn check(&self) -> Result<(), EvaluateError> {
        check_lists(&self.snrs, self.seeds)?;
        if self.methods.is_empty() {
            return Err(EvaluateError::param(
                "methods",
                "none is given",
                "give one or more, such as sift-mean,buff-1d",
            ));
        }
        if !(0.0..=1.0).contains(&self.false_fraction) {
            let remedy = "give a share from 0 to 1, such as 0.1";
            return Err(EvaluateError::param("false-fraction", self.false_fraction.to_string(), remedy));
        }
        for &method in &self.methods {
            self.searches().params(method).validate_for(self.chart.frames, (self.chart.width, self.chart.height))?;
        }
        Ok(())
    }

    fn searches(&self) -> Searches<'_> {
        Searches {
            detector: &self.detector,
            slopes_1d: self.slopes_1d,
            slopes_2d: self.slopes_2d,
            direction_deg: self.direction_deg,
        }
    }

    /// Makes the charts, runs the methods and scores what they find.
    ///
    /// # Errors
    /// A parameter of study, chart or detector that makes no sense, or [`EvaluateError::Cancelled`].
    pub fn run(&self, monitor: &Monitor) -> Result<ChartReport, EvaluateError> {
        self.check()?;
        let seeds = self.first_seed..self.first_seed.saturating_add(self.seeds);
        let jobs: Vec<(f64, u64)> =
            self.snrs.iter().flat_map(|&snr| seeds.clone().map(move |seed| (snr, seed))).collect();
        let scores = run_jobs(&jobs, self.methods.len(), monitor, |&(snr, seed), monitor, steps| {
            let (burst, truth) = synth_chart(&ChartParams { snr, seed, ..self.chart.clone() }, monitor)?;
            let score = |&method: &BurstMethod| {
                let detection = self.searches().search(method, &burst, monitor)?.detection;
                steps.done();
                Ok(self.score(method, seed, &detection, &truth))
            };
            self.methods.iter().map(score).collect::<Result<Vec<ChartScore>, EvaluateError>>()
        })?;
        let row = |(&snr, scores): (&f64, &[Vec<ChartScore>])| {
            let method = |(index, &method): (usize, &BurstMethod)| {
                self.method_report(method, scores.iter().map(|chart| chart[index].clone()).collect())
            };
            ChartRow { snr, methods: self.methods.iter().enumerate().map(method).collect() }
        };
        Ok(ChartReport {
            chart: (&self.chart).into(),
            first_seed: self.first_seed,
            seeds: self.seeds,
            ranking: self.ranking,
            false_fraction: self.false_fraction,
            detector: self.detector.clone(),
            slopes_1d: self.slopes_1d,
            slopes_2d: self.slopes_2d,
            rows: self.snrs.iter().zip(scores.chunks(self.seeds as usize)).map(row).collect(),
        })
    }

    fn score(&self, method: BurstMethod, seed: u64, detection: &Detection, truth: &Truth) -> ChartScore {
        let curve = Curve::of(&judge(&detection.features, truth, self.ranking));
        let of_one_frame = !matches!(method, BurstMethod::SiftMean | BurstMethod::SiftMerge);
        ChartScore {
            seed,
            true_positives: curve.at_false_fraction(self.false_fraction).true_positives,
            default_true_positives: curve.end().true_positives,
            default_false_features: curve.end().false_features,
            noise_estimate_ratio: (truth.noise.filter(|_| of_one_frame))
                .map(|noise| f64::from(detection.frame_noise) / noise.sigma_background),
            curve,
        }
    }

    fn method_report(&self, method: BurstMethod, charts: Vec<ChartScore>) -> MethodReport {
        let mean = |count: fn(&ChartScore) -> usize| {
            Mean::of(&charts.iter().map(|chart| count(chart) as f64).collect::<Vec<_>>())
        };
        let ratios: Vec<f64> = charts.iter().filter_map(|chart| chart.noise_estimate_ratio).collect();
        let curves: Vec<&Curve> = charts.iter().map(|chart| &chart.curve).collect();
        MethodReport {
            method,
            true_positives: mean(|chart| chart.true_positives),
            default_true_positives: mean(|chart| chart.default_true_positives),
            default_false_features: mean(|chart| chart.default_false_features),
            noise_estimate_ratio: (!ratios.is_empty()).then(|| Mean::of(&ratios)),
            roc: mean_curve(&curves, self.chart.discs.div_ceil(2)),
            charts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_named_with_its_remedy() {
        let good = ChartStudy::default;
        let cases = [
            (ChartStudy { snrs: Vec::new(), ..good() }, "snr: "),
            (ChartStudy { seeds: 0, ..good() }, "seeds: "),
            (ChartStudy { methods: Vec::new(), ..good() }, "methods: "),
            (ChartStudy { false_fraction: 1.5, ..good() }, "false-fraction: "),
            (ChartStudy { detector: DetectorParams { levels: 0, ..DetectorParams::default() }, ..good() }, "levels: "),
            (ChartStudy { chart: ChartParams { contrast: 1.0, ..ChartParams::default() }, ..good() }, "contrast: "),
        ];
        for (study, start) in cases {
            let error = study.run(&Monitor::default()).expect_err(start).to_string();
            assert!(error.starts_with(start), "{error}");
        }
        let monitor = Monitor::default();
        monitor.cancel();
        assert!(matches!(good().run(&monitor), Err(EvaluateError::Cancelled(_))));
    }
}
