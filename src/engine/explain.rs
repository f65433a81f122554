//! The worker that explains a detection as a whole: which slopes the burst needs, where the candidates went, which
//! slope wins where.
//!
//! All answers come from one [`ProbeCache`], which repeats the detection with all that it leaves behind. It is made
//! once for a burst and its parameters, and kept until another one is asked about.

use super::OnUpdate;
use super::fault::JobError;
use super::keyed::KeyedLane;
use super::lane::Answer;
use super::picture::job_error;
use super::source::{BurstId, OpenBurst};
use crate::detector::{DetectorParams, SearchParams, SlopeFinding};
use crate::inspect::ProbeCache;
use crate::inspect::candidates::{Survey, SurveyOptions, survey};
use crate::inspect::spectrum::{Spectrum, spectrum};
use crate::monitor::Monitor;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

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
    /// The burst.
    pub burst: OpenBurst,
    /// What the detection was asked for.
    pub asked: SearchParams,
    /// The parameters that it was made with.
    pub params: DetectorParams,
    /// What was found of the slopes, if they were to be found.
    pub finding: Option<SlopeFinding>,
    /// What is asked.
    pub question: ExplainQuestion,
}

impl ExplainRequest {
    /// Whether both ask the same of the same detection.
    pub fn same_answer(&self, other: &Self) -> bool {
        self.of_same_detection(other) && self.question == other.question
    }

    /// Whether both are about the same detection.
    pub fn of_same_detection(&self, other: &Self) -> bool {
        self.burst.id == other.burst.id && self.asked == other.asked && self.params == other.params
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

/// The detection that was asked about last, with all that it left behind. Cheap to clone.
#[derive(Debug, Clone, Default)]
pub(super) struct Trails(Arc<Mutex<Option<Trail>>>);

#[derive(Debug)]
struct Trail {
    burst: BurstId,
    params: DetectorParams,
    cache: Arc<ProbeCache>,
}

impl Trails {
    /// The trail of the detection of `burst` with `params`, kept or made now. `asked` and `finding` are what is known of
    /// its slopes beside.
    pub(super) fn get_or_make(
        &self,
        burst: &OpenBurst,
        params: &DetectorParams,
        (asked, finding): (&SearchParams, Option<&SlopeFinding>),
        monitor: &Monitor,
    ) -> Result<Arc<ProbeCache>, JobError> {
        // Whole values go in and out, so a poisoned lock still guards whole values.
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = |trail: &Trail| trail.burst == burst.id && trail.params == *params;
        if let Some(trail) = lock().as_ref().filter(|trail| kept(trail)) {
            return Ok(trail.cache.clone());
        }
        // The one that is not wanted any more goes before the next one needs its room.
        *lock() = None;
        let made = ProbeCache::new(&burst.burst, &params.clone().into(), monitor).map_err(job_error)?;
        let cache = Arc::new(ProbeCache { asked: asked.clone(), finding: finding.cloned(), ..made });
        *lock() = Some(Trail { burst: burst.id, params: params.clone(), cache: cache.clone() });
        Ok(cache)
    }
}

/// The worker.
pub struct Explainer(KeyedLane<ExplainSubject, ExplainRequest, Explained>);

impl Explainer {
    pub(super) fn new(trails: &Trails, on_update: &OnUpdate) -> Self {
        let its = trails.clone();
        Self(KeyedLane::new("explain", Duration::ZERO, on_update.clone(), move |request: ExplainRequest, monitor| {
            let explanation = explain(&its, &request, monitor)?;
            Ok(Explained { request, explanation })
        }))
    }

    /// Asks; an earlier question of the same subject is overtaken, and cancelled.
    pub fn ask(&self, request: ExplainRequest) {
        self.0.submit(request.question.subject(), request);
    }

    /// What was answered since the last call. Never waits.
    pub fn poll(&self) -> Vec<(ExplainSubject, Answer<Explained>)> {
        self.0.take_answers()
    }

    /// Nobody wants to know this any more.
    pub fn forget(&self, subject: ExplainSubject) {
        self.0.forget(subject);
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        self.0.is_idle()
    }
}

/// Part of the progress that making the trail takes.
const TRAIL_SHARE: f32 = 0.6;

fn explain(trails: &Trails, request: &ExplainRequest, monitor: &Monitor) -> Result<Explanation, JobError> {
    let ExplainRequest { burst, asked, params, finding, question } = request;
    let known = (asked, finding.as_ref());
    let cache = trails.get_or_make(burst, params, known, &monitor.part(0.0, TRAIL_SHARE))?;
    let monitor = monitor.part(TRAIL_SHARE, 1.0 - TRAIL_SHARE);
    Ok(match question {
        ExplainQuestion::Slopes => Explanation::Slopes(Arc::new(spectrum(&cache, &monitor)?)),
        ExplainQuestion::Candidates(options) => {
            Explanation::Candidates(Arc::new(survey(&cache.trail, options, &monitor)?))
        }
    })
}
