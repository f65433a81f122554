//! Detection over the number of frames of a burst: charts of few to many frames, at one signal-to-noise ratio.
//!
//! Every number of frames n has its own charts, with n frames and the truth at their own mid-burst, measured as in
//! [`ChartStudy`] (the paper's Fig. 6). [`super::BurstFramesStudy`] measures the effect on a given burst.

use super::chart::{ChartReport, ChartStudy, ChartSummary, ComparisonSetup, MethodReport};
use super::check_lists;
use crate::synth::ChartParams;
use burstscope_core::error::{Error, Result};
use burstscope_core::monitor::Monitor;
use serde::Serialize;

/// Default numbers of frames.
pub const FRAME_COUNTS: [usize; 9] = [2, 3, 4, 5, 6, 8, 10, 12, 15];

/// Methods to be compared, their charts, and the numbers of frames.
#[derive(Debug, Clone, PartialEq)]
pub struct FramesStudy {
    /// The charts and the methods. Exactly one ratio; the charts' number of frames is set by the study.
    pub charts: ChartStudy,
    /// Numbers of frames, one row of the table for each; in any order, duplicates count once.
    pub frame_counts: Vec<usize>,
}

impl Default for FramesStudy {
    /// Five charts of 2 to 15 frames each at a ratio of 0.6.
    fn default() -> Self {
        Self { charts: ChartStudy { snrs: vec![0.6], ..ChartStudy::default() }, frame_counts: FRAME_COUNTS.to_vec() }
    }
}

/// Report of a study over the number of frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FramesReport {
    /// Parameters of the charts; `frames` is the largest of the numbers.
    pub chart: ChartSummary,
    /// Per-pixel signal-to-noise ratio.
    pub snr: f64,
    /// Setup of the comparison of methods.
    #[serde(flatten)]
    pub setup: ComparisonSetup,
    /// One row for each number of frames, the smallest first.
    pub rows: Vec<FramesRow>,
}

/// All methods on charts of one number of frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FramesRow {
    /// Number of frames.
    pub frames: usize,
    /// The methods, in the study's order.
    pub methods: Vec<MethodReport>,
}

impl FramesStudy {
    /// The numbers of frames in ascending order, each once.
    pub fn counts(&self) -> Vec<usize> {
        let mut counts = self.frame_counts.clone();
        counts.sort_unstable();
        counts.dedup();
        counts
    }

    /// The study of the charts of `frames` frames.
    pub fn charts_of(&self, frames: usize) -> ChartStudy {
        ChartStudy { chart: ChartParams { frames, ..self.charts.chart.clone() }, ..self.charts.clone() }
    }

    fn check(&self) -> Result<()> {
        check_lists(&self.charts.snrs, self.charts.seeds)?;
        if self.charts.snrs.len() > 1 {
            let problem = format!("{} ratios", self.charts.snrs.len());
            return Err(Error::param("snr", problem, "give one; the number of frames is what changes"));
        }
        if self.frame_counts.is_empty() {
            return Err(Error::param("frame-counts", "none is given", "give one or more, such as 2,5,10"));
        }
        // The last number is checked before the first one is run.
        self.counts().into_iter().try_for_each(|frames| self.charts_of(frames).check())
    }

    /// Makes the charts of every number of frames, runs the methods and scores their features.
    ///
    /// # Errors
    /// A parameter of study, chart or detector that makes no sense, or cancellation.
    pub fn run(&self, monitor: &Monitor) -> Result<FramesReport> {
        self.run_telling(monitor, &|_| {})
    }

    /// Runs the study as `run` does; calls `tell` with the report so far after every chart, one call at a time.
    pub fn run_telling(&self, monitor: &Monitor, tell: &(dyn Fn(FramesReport) + Sync)) -> Result<FramesReport> {
        self.check()?;
        let counts = self.counts();
        // A chart of twice as many frames takes about twice as long.
        let total = counts.iter().sum::<usize>() as f32;
        let mut done = 0;
        let mut whole: Vec<(usize, ChartReport)> = Vec::with_capacity(counts.len());
        for frames in counts {
            let part = monitor.part(done as f32 / total, frames as f32 / total);
            let so_far = |report: ChartReport| {
                let rows: Vec<_> = whole.iter().cloned().chain([(frames, report)]).collect();
                tell(self.report(&rows));
            };
            let report = self.charts_of(frames).run_telling(&part, &so_far)?;
            whole.push((frames, report));
            done += frames;
        }
        Ok(self.report(&whole))
    }

    fn report(&self, studied: &[(usize, ChartReport)]) -> FramesReport {
        let row = |(frames, report): &(usize, ChartReport)| {
            report.rows.first().map(|row| FramesRow { frames: *frames, methods: row.methods.clone() })
        };
        FramesReport {
            chart: studied.last().map_or_else(|| (&self.charts.chart).into(), |(_, report)| report.chart),
            snr: self.charts.snrs[0],
            setup: self.charts.setup(),
            rows: studied.iter().filter_map(row).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BurstMethod, Searches};
    use super::*;
    use burstscope_core::detector::SlopeGrid;
    use std::sync::{Arc, Mutex};

    fn small() -> FramesStudy {
        let chart = ChartParams {
            width: 200,
            height: 150,
            discs: 8,
            radius: 4.0..=9.0,
            max_slope: 1.0,
            ..ChartParams::default()
        };
        let charts = ChartStudy {
            chart,
            snrs: vec![0.8],
            seeds: 2,
            methods: vec![BurstMethod::SiftMean, BurstMethod::Buff1d],
            searches: Searches { slopes_1d: SlopeGrid::line(-1.0..=1.0, 5), ..Searches::default() },
            ..ChartStudy::default()
        };
        FramesStudy { charts, frame_counts: vec![6, 2, 6] }
    }

    #[test]
    fn a_row_is_what_the_chart_study_says_of_charts_of_so_many_frames() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let sink = heard.clone();
        let monitor = Monitor::with_listener(move |p| sink.lock().expect("not poisoned").push(p.fraction));
        let report = small().run(&monitor).expect("a report");
        assert_eq!(report.rows.iter().map(|row| row.frames).collect::<Vec<_>>(), [2, 6]);
        assert_eq!(report.chart.frames, 6);
        let alone = small().charts_of(6).run(&Monitor::default()).expect("a report");
        assert_eq!(alone.chart.frames, 6);
        assert_eq!(report.rows[1].methods, alone.rows[0].methods);
        // More frames have less noise.
        let buff = |row: usize| report.rows[row].methods[1].true_positives.mean;
        assert!(buff(1) > buff(0), "{} {}", buff(0), buff(1));
        let heard = heard.lock().expect("not poisoned");
        assert!((heard.iter().copied().fold(0.0, f32::max) - 1.0).abs() < 1e-5);
        assert!(heard.iter().any(|&x| x > 0.1 && x < 0.3), "the first row is a quarter of the work");
    }
}
