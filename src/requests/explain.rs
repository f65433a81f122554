//! Explaining a detection as a whole: which slopes the burst needs, where the candidates went.

use super::error::JobError;
use super::trail::{DetectionSource, TrailStore, trail_and_rest};
use crate::inspect::candidates::{Survey, SurveyOptions, survey};
use crate::inspect::spectrum::{Spectrum, spectrum};
use crate::monitor::Monitor;
use std::sync::Arc;

/// What is asked about a detection. Of one subject the latest question wins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExplainQuestion {
    /// Which slopes the burst needs.
    Slopes,
    /// Where the candidates went, and which of them are listed.
    Candidates(SurveyOptions),
}

/// What a question is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ExplainSubject {
    /// The slopes.
    Slopes,
    /// The candidates.
    Candidates,
}

impl ExplainQuestion {
    /// What it is about.
    pub fn subject(&self) -> ExplainSubject {
        match self {
            Self::Slopes => ExplainSubject::Slopes,
            Self::Candidates(_) => ExplainSubject::Candidates,
        }
    }
}

/// A question about the detection of a burst.
#[derive(Debug, Clone)]
pub struct ExplainRequest {
    /// The detection.
    pub of: DetectionSource,
    /// What is asked.
    pub question: ExplainQuestion,
}

impl ExplainRequest {
    /// Whether both ask the same of the same detection.
    pub fn same_answer(&self, other: &Self) -> bool {
        self.of.is_same(&other.of) && self.question == other.question
    }

    /// Answers from what the detection left in `trails`, or repeats it.
    ///
    /// # Errors
    /// As the detection; [`JobError::Cancelled`].
    pub fn compute(self, trails: &dyn TrailStore, monitor: &Monitor) -> Result<Explained, JobError> {
        let (cache, monitor) = trail_and_rest(trails, &self.of, monitor)?;
        let explanation = match self.question {
            ExplainQuestion::Slopes => Explanation::Slopes(Arc::new(spectrum(&cache, &monitor)?)),
            ExplainQuestion::Candidates(options) => {
                Explanation::Candidates(Arc::new(survey(&cache.trail, &options, &monitor)?))
            }
        };
        Ok(Explained { request: self, explanation })
    }
}

/// An answer.
#[derive(Debug, Clone)]
pub enum Explanation {
    /// The slopes.
    Slopes(Arc<Spectrum>),
    /// The candidates.
    Candidates(Arc<Survey>),
}

/// An answer with what was asked.
#[derive(Debug, Clone)]
pub struct Explained {
    /// What was asked.
    pub request: ExplainRequest,
    /// The answer.
    pub explanation: Explanation,
}
