//! Explanations of a detection: the spectrum of slopes, the survey of candidates and the false rate by decoys, the
//! losses of features whose truth is known, the fate of single places and candidates, and the shares of the frames.

use super::caches::trail_and_rest;
use super::{BurstId, Caches, DetectionSource, JobError, MatchRequest, Request, Work};
use crate::detector::{Detection, Slope, Test};
use crate::inspect::ProbeCache;
use crate::inspect::pair::{ComparedPair, Losses, Lost, NearestOfBoth};
use crate::inspect::place::{
    CandidateMark, Judged, Probe, ProbeOptions, ProbeSubject, Survey, SurveyOptions, judged, probe, survey,
};
use crate::inspect::result::{DecoyStudy, Decoys, TooFew, decoys, too_few};
use crate::inspect::slopes::{Spectrum, spectrum};
use crate::matching::MatchResult;
use crate::monitor::Monitor;
use serde::{Deserialize, Serialize};
use std::convert::Infallible;
use std::sync::Arc;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExplainQuestion {
    Slopes,
    Candidates(SurveyOptions),
    Decoys(DecoyStudy),
    TooFew,
}

#[derive(Debug, Clone, PartialEq)]
pub struct ExplainRequest {
    pub of: DetectionSource,
    pub question: ExplainQuestion,
}

request! {
    ExplainRequest => Explanation: |self, work| {
        let (cache, monitor) = trail_and_rest(&work.caches.trails, &self.of, work.monitor)?;
        let trail = &cache.trail;
        Ok(match self.question {
            ExplainQuestion::Slopes => Explanation::Slopes(Arc::new(spectrum(&cache, &monitor)?)),
            ExplainQuestion::Candidates(options) => {
                Explanation::Candidates(Arc::new(survey(trail, &options, &monitor)?))
            }
            ExplainQuestion::TooFew => Explanation::TooFew(too_few(&self.of.burst.burst, &cache.searched(), &monitor)?),
            ExplainQuestion::Decoys(study) => Explanation::Decoys(Arc::new(decoys(trail, &study, true, &monitor)?)),
        })
    }
}

#[derive(Debug, Clone)]
pub enum Explanation {
    Slopes(Arc<Spectrum>),
    Candidates(Arc<Survey>),
    Decoys(Arc<Decoys>),
    TooFew(Option<TooFew>),
}

#[derive(Debug, Clone)]
pub struct LossesRequest {
    pub request: MatchRequest,
    pub result: Arc<MatchResult>,
    pub size_b: (usize, usize),
}

impl LossesRequest {
    pub fn pair(&self) -> ComparedPair<'_> {
        let MatchRequest { a, b, params, .. } = &self.request;
        ComparedPair { a, b, size_b: self.size_b, result: &self.result, params }
    }
}

request! {
    LossesRequest => FoundLosses: |self, work| {
        let losses = Losses::new(self.pair(), work.monitor)?;
        let counts = losses.counts(work.monitor)?;
        let lost = (0..self.request.a.features.len()).map(|index| losses.lost(index)).collect();
        Ok(FoundLosses { nearest: losses.nearest(), request: self, lost, counts })
    }
}

#[derive(Debug, Clone)]
pub struct FoundLosses {
    pub request: LossesRequest,
    pub lost: Vec<Lost>,
    pub counts: [(Lost, usize); 6],
    pub nearest: Arc<NearestOfBoth>,
}

#[derive(Debug, Clone)]
pub struct Traced {
    pub burst: BurstId,
    pub cache: Arc<ProbeCache>,
}

impl Request for DetectionSource {
    /// The detection with its trail; the search is repeated if the trail is not kept.
    type Answer = Traced;
    type Partial = Infallible;

    fn cached(&self, caches: &Caches) -> Option<Traced> {
        Some(Traced { burst: self.burst.id, cache: caches.trails.get(self)? })
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<Traced, JobError> {
        Ok(Traced { burst: self.burst.id, cache: work.caches.trails.get_or_make(&self, work.monitor)? })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProbeQuestion {
    At {
        /// (u, v) at mid-burst, input pixels.
        place: [f32; 2],
        wanted: ProbeSubject,
    },
    Strongest,
}

#[derive(Debug, Clone, PartialEq)]
pub struct ProbeRequest {
    pub traced: Traced,
    pub question: ProbeQuestion,
    /// Scale σ near which candidates come first, input pixels; `None` for all scales alike.
    pub near_sigma: Option<f32>,
    /// Slope by which candidates at the place come first, px/frame; `None` for a picture of no slope.
    pub in_view: Option<Slope>,
}

request! {
    ProbeRequest => Probed, Picture: |self, work| {
        let (cache, monitor) = (&self.traced.cache, work.monitor);
        let (place, wanted) = match self.question {
            ProbeQuestion::At { place, wanted } => (place, wanted),
            ProbeQuestion::Strongest => {
                let mark = strongest(cache, monitor)?;
                (mark.pos_image, ProbeSubject::Candidate(mark.sample))
            }
        };
        let (near_sigma, in_view) = (self.near_sigma, self.in_view);
        let options = ProbeOptions { wanted, near_sigma, in_view, ..ProbeOptions::default() };
        let probe = Arc::new(probe(cache, place, &options, monitor)?);
        Ok(Probed { request: self, probe })
    }
}

#[derive(Debug, Clone)]
pub struct Probed {
    pub request: ProbeRequest,
    pub probe: Arc<Probe>,
}

/// Strongest candidate by SNR, or by |D| without noise, among those at an extremum of their own.
fn strongest(cache: &ProbeCache, monitor: &Monitor) -> Result<CandidateMark, JobError> {
    let strength = |mark: &CandidateMark| if mark.snr.is_finite() { mark.snr } else { mark.value.abs() };
    // The weakest candidates are many, and are surveyed only if there is nothing else.
    for min_snr in [SurveyOptions::default().min_snr, 0.0] {
        let marks = survey(&cache.trail, &SurveyOptions { min_snr, test: None }, monitor)?.marks;
        let own = marks.into_iter().filter(|mark| mark.first_failed != Some(Test::Refinement));
        if let Some(mark) = own.max_by(|a, b| strength(a).total_cmp(&strength(b))) {
            return Ok(mark);
        }
    }
    Err(JobError::Failed("nothing in this burst is an extremum at any slope and scale".to_owned()))
}

#[derive(Debug, Clone)]
pub struct CoherenceRequest {
    pub of: DetectionSource,
    pub detection: Arc<Detection>,
}

#[derive(Debug, Clone)]
pub struct Coherences {
    pub detection: Arc<Detection>,
    pub values: Arc<Vec<Judged>>,
}

request! {
    CoherenceRequest => Coherences: |self, work| {
        let (cache, rest) = trail_and_rest(&work.caches.trails, &self.of, work.monitor)?;
        Ok(Coherences { values: Arc::new(judged(&cache.trail, &rest)?), detection: self.detection })
    }
}
