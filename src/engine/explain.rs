//! The worker that explains a detection as a whole: which slopes the burst needs, where the candidates went, which
//! slope wins where.
//!
//! All answers come from one [`ProbeCache`], which repeats the detection with all that it leaves behind. It is made
//! once for a burst and its parameters, and kept until another one is asked about.

use super::fault::{JobError, job_error};
use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobId, JobQueue, Priority};
use super::source::{BurstId, OpenBurst};
use crate::detector::{DetectorParams, SearchParams, SlopeFinding};
use crate::inspect::ProbeCache;
use crate::inspect::candidates::{Survey, SurveyOptions, survey};
use crate::inspect::spectrum::{Spectrum, spectrum};
use crate::monitor::Monitor;
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
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

/// How long somebody else's trail is waited for at once.
const WAIT: Duration = Duration::from_millis(5);

/// The detection that was asked about last, with all that it left behind. Cheap to clone.
#[derive(Debug, Clone, Default)]
pub(super) struct Trails(Arc<Kept>);

#[derive(Debug, Default)]
struct Kept {
    trail: Mutex<Option<Trail>>,
    /// Held while one is made, so that none is made twice.
    making: Mutex<()>,
}

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
        let lock = || self.0.trail.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = |trail: &Trail| trail.burst == burst.id && trail.params == *params;
        let _making = loop {
            if let Some(trail) = lock().as_ref().filter(|trail| kept(trail)) {
                return Ok(trail.cache.clone());
            }
            monitor.check()?;
            match self.0.making.try_lock() {
                Ok(guard) => break guard,
                Err(TryLockError::Poisoned(poisoned)) => break poisoned.into_inner(),
                Err(TryLockError::WouldBlock) => std::thread::sleep(WAIT),
            }
        };
        // It may have been made since it was looked for.
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
pub struct Explainer(Jobs<ExplainRequest, Explained>);

impl Explainer {
    pub(super) fn new(queue: &Arc<JobQueue>, trails: &Trails) -> Self {
        let its = trails.clone();
        let work = move |request: ExplainRequest, monitor: &Monitor| {
            let explanation = explain(&its, &request, monitor)?;
            Ok(Explained { request, explanation })
        };
        Self(Jobs::new(queue, Priority::Search, Duration::ZERO, work))
    }

    /// Asks; an earlier question of the same subject is superseded, and cancelled.
    pub fn ask(&self, request: ExplainRequest) -> JobId {
        self.0.submit_for(request.question.subject() as u32, request)
    }

    /// What was answered since the last call. Never waits.
    pub fn poll(&self) -> Vec<(ExplainSubject, JobAnswer<Explained>)> {
        let subject = |slot: u32| {
            if slot == ExplainSubject::Slopes as u32 { ExplainSubject::Slopes } else { ExplainSubject::Candidates }
        };
        let answers = self.0.take_answers_for().into_iter().filter(|(_, answer)| !answer.is_superseded());
        answers.map(|(slot, answer)| (subject(slot), answer)).collect()
    }

    /// Nobody wants to know this any more.
    pub fn forget(&self, subject: ExplainSubject) {
        self.0.cancel_for(subject as u32);
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
