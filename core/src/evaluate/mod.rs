//! Evaluation of the detector on input whose truth is known exactly, and of camera poses that were found with its
//! features.
//!
//! Four studies of the detector, each one command (`burstscope evaluate chart|frames|accuracy|noise`):
//!
//! - [`chart`]: in the dark. The number of a chart's discs that each method finds before a tenth of its features are
//!   false, and true against false features over the threshold (the ROC curve).
//! - [`frames`]: the measures of `chart` over the number of frames of a burst; [`frames_of_burst`] for a given burst.
//! - [`accuracy`]: in enough light. Errors of positions, scales and motions.
//! - [`pure_noise`]: on noise alone. The number of features found where all are false.
//!
//! One study of the use of features, on real or synthetic bursts, [`mod@matches`] (`burstscope evaluate matches`): the
//! number of features that match between bursts, and of correct matches.
//!
//! And one of camera poses, [`poses`] (`burstscope evaluate poses`): the distance of a reconstruction's trajectory from
//! the true one.
//!
//! A study of the detector is a set of parameters; its `run` makes the synthetic bursts, runs the detector in parallel
//! over them and returns a report that can be written as JSON. [`score`] decides which discs count as found, [`figure`]
//! and [`frames_figure`] draw the curves. The same study gives the same report for any number of threads, and memory
//! holds at most one burst for each thread.

pub mod accuracy;
mod accuracy_report;
pub mod chart;
mod chart_report;
pub mod curves;
pub mod curves_figure;
pub mod figure;
pub mod frames;
pub mod frames_figure;
pub mod frames_of_burst;
mod jobs;
pub mod matches;
mod methods;
pub mod poses;
pub mod pure_noise;
pub mod score;
pub mod statistics;
mod study;

pub use accuracy::{AccuracyReport, AccuracyStudy};
pub use chart::{ChartReport, ChartStudy, LookedChart};
pub use frames::{FramesReport, FramesStudy};
pub use frames_of_burst::{BurstFramesReport, BurstFramesStudy};
pub use matches::{MatchMethod, MatchReport, MatchStudy, Shot};
pub use methods::{BurstMethod, Searches, slopes_of};
pub use pure_noise::{NoiseReport, NoiseStudy};
pub use score::{Curve, Ranking};
pub use study::{BurstsOfStudy, ChartOfStudy, ShownChart, Study, StudyPoint, StudyReport};

use crate::detector::{DetectError, ParamError};
use crate::monitor::Cancelled;
use crate::synth::{Motion, SynthError};

/// Reason why a study has no report.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EvaluateError {
    /// A parameter of the study makes no sense.
    #[error("{parameter}: {problem}; {remedy}")]
    Param {
        /// Name of the parameter to change, as on the command line without the dashes.
        parameter: &'static str,
        /// Problem with its value.
        problem: String,
        /// Suggested change.
        remedy: &'static str,
    },
    /// The charts cannot be made.
    #[error(transparent)]
    Synth(SynthError),
    /// The detector's parameters make no sense.
    #[error(transparent)]
    Detector(#[from] ParamError),
    /// The study was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<SynthError> for EvaluateError {
    fn from(error: SynthError) -> Self {
        match error {
            SynthError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Synth(other),
        }
    }
}

impl From<DetectError> for EvaluateError {
    fn from(error: DetectError) -> Self {
        match error {
            DetectError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            DetectError::Param(param) => Self::Detector(param),
        }
    }
}

impl EvaluateError {
    fn param(parameter: &'static str, problem: impl Into<String>, remedy: &'static str) -> Self {
        Self::Param { parameter, problem: problem.into(), remedy }
    }
}

/// Name of a motion, as on the command line.
pub fn motion_name(motion: Motion) -> &'static str {
    match motion {
        Motion::OneD => "1d",
        Motion::TwoD => "2d",
    }
}

/// Checks the lists that several studies share.
fn check_lists(snrs: &[f64], seeds: u64) -> Result<(), EvaluateError> {
    if snrs.is_empty() {
        return Err(EvaluateError::param("snr", "no ratio is given", "give one or more, such as 0.2,0.35,0.6"));
    }
    if seeds == 0 {
        return Err(EvaluateError::param("seeds", "0 charts", "give 1 or more"));
    }
    Ok(())
}
