//! Probes of a place in the trail of a detection.

use super::error::JobError;
use super::open::BurstId;
use super::request::{Kept, Request, Urgency, Work};
use super::trail::DetectionSource;
use crate::inspect::candidates::{CandidateMark, SurveyOptions, survey};
use crate::inspect::probe::Wanted;
use crate::inspect::{Probe, ProbeCache, ProbeOptions, probe};
use crate::monitor::Monitor;
use std::convert::Infallible;
use std::sync::Arc;

/// Detection of a burst with its trail.
#[derive(Debug, Clone)]
pub struct Traced {
    /// The burst.
    pub burst: BurstId,
    /// Its detection, with its trail.
    pub cache: Arc<ProbeCache>,
}

impl Request for DetectionSource {
    /// The detection with its trail; the search is repeated if the trail is not kept.
    type Answer = Traced;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn is_same(&self, other: &Self) -> bool {
        self.burst.id == other.burst.id && self.asked == other.asked && self.params == other.params
    }

    fn kept(&self, kept: &Kept<'_>) -> Option<Traced> {
        Some(Traced { burst: self.burst.id, cache: kept.trails.get(self)? })
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<Traced, JobError> {
        let cache = work.kept.trails.get_or_make(&self, work.monitor)?;
        Ok(Traced { burst: self.burst.id, cache })
    }
}

/// Question that a probe answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProbeQuestion {
    /// The candidates at a place.
    At {
        /// (u, v) at mid-burst, input pixels.
        place: [f32; 2],
        /// Choice of what is examined more closely.
        wanted: Wanted,
    },
    /// The strongest candidate of the whole picture, kept or not.
    Strongest,
}

/// A question about a detection.
#[derive(Debug, Clone)]
pub struct ProbeRequest {
    /// Detection that the question is about.
    pub traced: Traced,
    /// The question.
    pub question: ProbeQuestion,
}

impl Request for ProbeRequest {
    type Answer = Probed;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Picture
    }

    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.traced.cache, &other.traced.cache) && self.question == other.question
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<Probed, JobError> {
        let (cache, monitor) = (&self.traced.cache, work.monitor);
        let (place, wanted) = match self.question {
            ProbeQuestion::At { place, wanted } => (place, wanted),
            ProbeQuestion::Strongest => {
                let mark = strongest(cache, monitor)?;
                (mark.pos_image, Wanted::Candidate(mark.of_sample()))
            }
        };
        let probe = probe(cache, place, &ProbeOptions { wanted, ..ProbeOptions::default() }, monitor)?;
        Ok(Probed { request: self, probe: Arc::new(probe) })
    }
}

/// Answer with its request.
#[derive(Debug, Clone)]
pub struct Probed {
    /// The request.
    pub request: ProbeRequest,
    /// Result for the place.
    pub probe: Arc<Probe>,
}

/// The candidate with the largest |D| over its noise; in a burst without noise with the largest |D|.
fn strongest(cache: &ProbeCache, monitor: &Monitor) -> Result<CandidateMark, JobError> {
    let strength = |mark: &CandidateMark| if mark.snr.is_finite() { mark.snr } else { mark.value.abs() };
    for min_snr in [SurveyOptions::default().min_snr, 0.0] {
        let marks = survey(&cache.trail, &SurveyOptions { min_snr, test: None }, monitor)?.marks;
        if let Some(mark) = marks.into_iter().max_by(|a, b| strength(a).total_cmp(&strength(b))) {
            return Ok(mark);
        }
    }
    Err(JobError::Failed("nothing in this burst is an extremum at any slope and scale".to_owned()))
}
