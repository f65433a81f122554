//! Explanations of a whole detection: the spectrum of slopes, and the survey of candidates.

use super::error::JobError;
use super::request::{Request, Urgency, Work};
use super::trail::{DetectionSource, trail_and_rest};
use crate::inspect::candidates::{Survey, SurveyOptions, survey};
use crate::inspect::spectrum::{Spectrum, spectrum};
use std::convert::Infallible;
use std::sync::Arc;

/// Question about a detection. Of one subject the latest question wins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExplainQuestion {
    /// Which slopes the burst needs.
    Slopes,
    /// Where the candidates were rejected, and which of them are listed.
    Candidates(SurveyOptions),
}

/// A question about the detection of a burst.
#[derive(Debug, Clone)]
pub struct ExplainRequest {
    /// The detection.
    pub of: DetectionSource,
    /// The question.
    pub question: ExplainQuestion,
}

impl Request for ExplainRequest {
    type Answer = Explained;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn is_same(&self, other: &Self) -> bool {
        self.of.is_same(&other.of) && self.question == other.question
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<Explained, JobError> {
        let (cache, monitor) = trail_and_rest(work.kept.trails, &self.of, work.monitor)?;
        let explanation = match self.question {
            ExplainQuestion::Slopes => Explanation::Slopes(Arc::new(spectrum(&cache, &monitor)?)),
            ExplainQuestion::Candidates(options) => {
                Explanation::Candidates(Arc::new(survey(&cache.trail, &options, &monitor)?))
            }
        };
        Ok(Explained { request: self, explanation })
    }
}

/// Answer to a question.
#[derive(Debug, Clone)]
pub enum Explanation {
    /// The slopes.
    Slopes(Arc<Spectrum>),
    /// The candidates.
    Candidates(Arc<Survey>),
}

/// Answer with its request.
#[derive(Debug, Clone)]
pub struct Explained {
    /// The request.
    pub request: ExplainRequest,
    /// The answer.
    pub explanation: Explanation,
}
