//! All studies with curves, as one type: for the Lab, which runs them, shows them growing, and opens single charts.

use super::recover::plots::recover_plots;
use super::recover::{RecoverReport, RecoverStudy};
use crate::evaluate::chart::MethodReport;
use crate::evaluate::curves::{StudyPlot, accuracy_plots, burst_frames_plots, chart_plots};
use crate::evaluate::{
    AccuracyReport, AccuracyStudy, BurstFramesReport, BurstFramesStudy, BurstMethod, ChartReport, ChartStudy,
    LookedChart, RowStudy, motion_label,
};
use crate::synth::{ChartParams, Truth};
use burstscope_core::error::{Error, Result};
use burstscope_core::inspect::result::{Curve, Scored};
use burstscope_core::{baseline::plain_mean, burst::Burst, monitor::Monitor, plane::Plane};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A study of any kind, with the bursts that it needs.
#[derive(Debug, Clone, PartialEq)]
pub enum Study {
    /// Detection in the dark, over ratios or numbers of frames: ROC curves, discs found, false features.
    Chart(Box<ChartStudy>),
    /// Errors of positions, scales and slopes, over ratios.
    Accuracy(Box<AccuracyStudy>),
    /// Detection in the middle frames of a given burst.
    BurstFrames(Box<BurstFramesStudy>, BurstsOfStudy),
    /// Things planted in a given burst.
    Recover(Box<RecoverStudy>, BurstsOfStudy),
}

/// The bursts of [`Study::BurstFrames`] and [`Study::Recover`]; equal if identical, not if of equal content.
#[derive(Debug, Clone)]
#[allow(missing_docs)] // where a name says it
pub struct BurstsOfStudy {
    pub burst: Arc<Burst>,
    pub second: Option<Arc<Burst>>,
    pub truth: Option<Arc<Truth>>,
}

impl PartialEq for BurstsOfStudy {
    fn eq(&self, other: &Self) -> bool {
        let second = |one: &Self| one.second.as_ref().map(Arc::as_ptr);
        Arc::ptr_eq(&self.burst, &other.burst) && second(self) == second(other)
    }
}

/// Report of a study, complete or partial.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // each is of the study of its name
pub enum StudyReport {
    Chart(Box<ChartReport>),
    Accuracy(Box<AccuracyReport>),
    BurstFrames(Box<BurstFramesReport>),
    Recover(Box<RecoverReport>),
}

/// Point of a curve: identifies the charts that it is the mean of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StudyPoint {
    /// Value of its row: a ratio, or a number of frames.
    pub row_value: f64,
    /// Method; `None` for the one search of a study of accuracy.
    pub method: Option<BurstMethod>,
}

/// Peak thresholds of methods at which the same share of the detections on charts is false.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SameFalseRate {
    /// Per-pixel signal-to-noise ratio of the charts.
    pub snr: f64,
    /// Share of false detections, 0 … 1.
    pub false_fraction: f64,
    /// Methods with their thresholds of |response|.
    pub peak_thresholds: Vec<(BurstMethod, f32)>,
}

impl SameFalseRate {
    /// The threshold of `method`, if the study had it.
    pub fn of(&self, method: BurstMethod) -> Option<f32> {
        self.peak_thresholds.iter().find(|(of, _)| *of == method).map(|(_, threshold)| *threshold)
    }
}

/// One chart of a study, identified by a point and a seed.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct ChartOfStudy {
    pub study: Study,
    pub point: StudyPoint,
    pub seed: u64,
}

/// A chart of a study that was made and searched again, for a look at it. Cheap to clone.
#[derive(Debug, Clone)]
#[allow(missing_docs)] // where a name says it
pub struct ShownChart {
    pub of: ChartOfStudy,
    pub looked: Arc<LookedChart>,
    pub mean: Arc<Plane>,
}

impl ShownChart {
    /// Judged features at the threshold of the study's share of false ones; all of them for `all`, or without a share.
    pub fn judged(&self, all: bool) -> Vec<Scored> {
        let fraction = match &self.of.study {
            Study::Chart(study) => Some(study.false_fraction),
            Study::Accuracy(_) | Study::BurstFrames(..) | Study::Recover(..) => None,
        };
        let judged = &self.looked.judged;
        let threshold = fraction.filter(|_| !all).map(|share| Curve::of(judged).at_false_fraction(share).threshold);
        judged.iter().filter(|one| threshold.is_none_or(|threshold| one.worth >= threshold)).copied().collect()
    }
}

impl ChartOfStudy {
    /// Makes and searches the chart again, as the study did; errors as of [`Study::run_telling`].
    pub fn show(self, monitor: &Monitor) -> Result<ShownChart> {
        let StudyPoint { row_value, method } = self.point;
        let looked = match &self.study {
            Study::Accuracy(study) => study.look(row_value, self.seed, monitor)?,
            Study::Chart(study) => {
                let method = method.or_else(|| study.methods.first().copied()).unwrap_or(BurstMethod::Buff1d);
                study.look(study.row_at(row_value), self.seed, method, monitor)?
            }
            Study::BurstFrames(..) | Study::Recover(..) => {
                return Err(Error::param("study", "has no charts", "look at a point of charts"));
            }
        };
        let mean = plain_mean(&looked.burst, monitor)?.frames[0].clone();
        Ok(ShownChart { of: self, looked: Arc::new(looked), mean })
    }

    /// The parameters of the chart; `None` for a study of a given burst.
    pub fn params(&self) -> Option<ChartParams> {
        match &self.study {
            Study::Accuracy(study) => Some(study.chart_of(self.point.row_value, self.seed)),
            Study::Chart(study) => Some(study.chart_of(study.row_at(self.point.row_value), self.seed)),
            Study::BurstFrames(..) | Study::Recover(..) => None,
        }
    }
}

impl Study {
    /// Runs the study; calls `tell` with the report so far whenever a chart is finished.
    ///
    /// # Errors
    /// A parameter of study, chart or detector that makes no sense, or cancellation.
    pub fn run_telling(&self, monitor: &Monitor, tell: &(dyn Fn(StudyReport) + Sync)) -> Result<StudyReport> {
        // Each kind has a report of its own type: partial and final ones are wrapped alike.
        fn as_one<R>(
            one: fn(Box<R>) -> StudyReport,
            tell: &(dyn Fn(StudyReport) + Sync),
            run: impl FnOnce(&(dyn Fn(R) + Sync)) -> Result<R>,
        ) -> Result<StudyReport> {
            run(&|report| tell(one(Box::new(report)))).map(|report| one(Box::new(report)))
        }
        match self {
            Self::Chart(study) => as_one(StudyReport::Chart, tell, |tell| study.run_telling(monitor, tell)),
            Self::Accuracy(study) => as_one(StudyReport::Accuracy, tell, |tell| study.run_telling(monitor, tell)),
            Self::BurstFrames(study, BurstsOfStudy { burst, second, truth }) => {
                let (second, truth) = (second.as_deref(), truth.as_deref());
                as_one(StudyReport::BurstFrames, tell, |tell| study.run_telling(burst, second, truth, monitor, tell))
            }
            Self::Recover(study, BurstsOfStudy { burst, .. }) => {
                as_one(StudyReport::Recover, tell, |tell| study.run_telling(burst, monitor, tell))
            }
        }
    }

    /// The first seed, and the number of seeds; `None` for a study of a given burst.
    pub fn seeds(&self) -> Option<(u64, u64)> {
        match self {
            Self::Chart(study) => Some((study.first_seed, study.seeds)),
            Self::Accuracy(study) => Some((study.first_seed, study.seeds)),
            Self::BurstFrames(..) | Self::Recover(..) => None,
        }
    }
}

impl StudyReport {
    /// Peak thresholds of one share of false detections, at row `row` or the last one; `None` for other studies.
    pub fn same_false_rate(&self, row: usize) -> Option<SameFalseRate> {
        let Self::Chart(report) = self else { return None };
        let row = report.rows.get(row).or(report.rows.last()).filter(|_| report.snr.is_none())?;
        let of = |method: &MethodReport| Some((method.method, method.peak_threshold?));
        let peak_thresholds: Vec<_> = row.methods.iter().filter_map(of).collect();
        let false_fraction = report.setup.false_fraction;
        (!peak_thresholds.is_empty()).then_some(SameFalseRate { snr: row.at.value(), false_fraction, peak_thresholds })
    }

    /// The plots of the report; ROC curves are those of the row `roc_row`.
    pub fn plots(&self, roc_row: usize) -> Vec<StudyPlot> {
        match self {
            Self::Chart(report) => chart_plots(report, roc_row),
            Self::Accuracy(report) => accuracy_plots(report),
            Self::BurstFrames(report) => burst_frames_plots(report),
            Self::Recover(report) => recover_plots(report),
        }
    }

    /// Labels of the rows that have ROC curves.
    pub fn roc_rows(&self) -> Vec<String> {
        match self {
            Self::Chart(report) => report.rows.iter().map(|row| row.at.label()).collect(),
            Self::Accuracy(_) | Self::BurstFrames(_) | Self::Recover(_) => Vec::new(),
        }
    }

    /// Label of a row: its value with a name.
    pub fn row_label(&self, row_value: f64) -> String {
        match self {
            Self::Chart(report) if report.snr.is_some() => format!("{row_value} frames"),
            Self::Chart(_) | Self::Accuracy(_) => format!("SNR {row_value}"),
            Self::BurstFrames(_) => format!("{row_value} frames"),
            Self::Recover(_) => row_value.to_string(),
        }
    }

    /// The subject of the study, in a few words.
    pub fn summary(&self) -> String {
        let chart = match self {
            Self::Chart(report) => &report.chart,
            Self::Accuracy(report) => &report.chart,
            Self::BurstFrames(report) => {
                return format!("{}: {} features in all frames", report.burst, report.features);
            }
            Self::Recover(report) => return report.summary(),
        };
        format!(
            "{} discs of {} to {} px, contrast {}, {} frames of {}×{}, up to ±{} px/frame in {}",
            chart.discs,
            chart.radius.start(),
            chart.radius.end(),
            chart.contrast,
            chart.uneven.count_and_span(chart.frames).0,
            chart.width,
            chart.height,
            chart.max_slope,
            motion_label(chart.motion),
        )
    }
}
