//! Comparison of methods on the same burst, as plain values: the results, the missing steps, and the panes.
//!
//! With a second burst open, each method also runs on that one, and its features of both are matched, so that matches
//! can be compared too.

use crate::app::document::{MethodId, Side, Sides};
use crate::app::{results::Read, results::pair::Matches};
use crate::detector::{Detection, DetectorParams};
use crate::engine::Wanted;
use crate::requests::{BurstId, CompareRequest, DetectRequest, MatchRequest, OpenBurst, OpenRequest, Running};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

#[derive(Debug, Clone)]
pub struct MethodFound {
    pub burst: BurstId,
    pub params: DetectorParams,
    pub detection: Arc<Detection>,
    pub elapsed: Duration,
}

#[derive(Debug, Clone)]
pub struct CompareJob {
    pub method: MethodId,
    /// Burst that is searched; matching uses both.
    pub side: Side,
    pub request: CompareRequest,
}

#[derive(Debug, Default)]
pub struct Compare {
    /// Sharp images of A's and of B's view, each as a burst of one frame.
    pub gold: Sides<Option<OpenBurst>>,
    /// The request for the missing piece of work, one at a time, so that times can be compared.
    pub wanted: Wanted<CompareRequest>,
    pub asked: Option<CompareJob>,
    pub opening_gold: Sides<Wanted<OpenRequest>>,
    pub arranged: Vec<MethodId>,
    pub found: HashMap<(MethodId, Side), MethodFound>,
    matches: HashMap<MethodId, Matches>,
    pub failed: Vec<(CompareJob, String)>,
}

impl Compare {
    pub fn running(&self) -> Option<(MethodId, Running)> {
        Some((self.asked.as_ref()?.method, self.wanted.running?))
    }

    pub fn problem(&self, method: MethodId) -> Option<&str> {
        self.failed.iter().rev().find(|(job, _)| job.method == method).map(|(_, why)| why.as_str())
    }

    pub fn take_found(&mut self, method: MethodId, side: Side, found: MethodFound) {
        self.failed.retain(|(job, _)| job.method != method);
        self.found.insert((method, side), found);
    }

    pub fn take_matches(&mut self, method: MethodId, matches: Matches) {
        self.failed.retain(|(job, _)| job.method != method);
        self.matches.insert(method, matches);
    }
}

impl<'a> Read<'a> {
    /// Burst that `method` searches on `side`: the open one, or the gold standard's image.
    pub fn method_burst(self, method: MethodId, side: Side) -> Option<&'a OpenBurst> {
        if method == MethodId::Gold { self.results.compare.gold[side].as_ref() } else { self.burst_of(side) }
    }

    pub fn method_params(self, method: MethodId, side: Side) -> DetectorParams {
        self.document.methods.at_same_false_rate(method, method.params(&self.params_of(side)))
    }

    pub fn method_found(self, method: MethodId, side: Side) -> Option<&'a MethodFound> {
        let open = self.method_burst(method, side)?;
        let found = self.results.compare.found.get(&(method, side));
        found.filter(|found| found.burst == open.id && found.params == self.method_params(method, side))
    }

    pub fn method_matches(self, method: MethodId) -> Option<&'a Matches> {
        let wanted = self.wanted_method_matches(method)?;
        self.results.compare.matches.get(&method).filter(|matches| matches.request == wanted)
    }

    fn wanted_method_matches(self, method: MethodId) -> Option<MatchRequest> {
        let of = |side: Side| {
            let (found, burst) = (self.method_found(method, side)?, self.method_burst(method, side)?);
            Some((found.detection.clone(), (burst.clone(), found.params.clone())))
        };
        let ((a, burst_a), (b, burst_b)) = (of(Side::A)?, of(Side::B)?);
        Some(MatchRequest { a, b, bursts: [burst_a, burst_b], params: self.document.matching.clone() })
    }

    pub fn methods_shown(self) -> Vec<MethodId> {
        let usable = |method: &MethodId| self.method_burst(*method, Side::A).is_some();
        MethodId::ALL.into_iter().filter(|m| self.document.methods.shows(*m)).filter(usable).collect()
    }

    /// Features of A by each method that is shown, then those of B, then their matches.
    pub fn next_compare_job(self) -> Option<CompareJob> {
        let jobs = self.methods_shown().into_iter().flat_map(|method| {
            let detections = Side::BOTH.into_iter().filter_map(move |side| self.missing_detection(method, side));
            detections.chain(self.missing_matching(method)).collect::<Vec<_>>()
        });
        // All methods on A come first: A is on show.
        let mut jobs: Vec<CompareJob> = jobs.filter(|job| !self.has_failed(job)).collect();
        jobs.sort_by_key(|job| job.side != Side::A);
        jobs.into_iter().next()
    }

    fn missing_detection(self, method: MethodId, side: Side) -> Option<CompareJob> {
        let burst = self.method_burst(method, side)?.clone();
        let params = self.method_params(method, side);
        let usable = params.validate_for(&burst.burst.positions, burst.burst.size()).is_ok();
        let request = CompareRequest::Detect(DetectRequest { burst, params: params.into() });
        (usable && self.method_found(method, side).is_none()).then_some(CompareJob { method, side, request })
    }

    fn missing_matching(self, method: MethodId) -> Option<CompareJob> {
        let wanted = self.wanted_method_matches(method)?;
        let is_missing = self.results.pair.param_error.is_none() && self.method_matches(method).is_none();
        is_missing.then_some(CompareJob { method, side: Side::B, request: CompareRequest::Match(wanted) })
    }

    fn has_failed(self, job: &CompareJob) -> bool {
        let same = |other: &CompareJob| other.method == job.method && other.request == job.request;
        self.results.compare.failed.iter().any(|(failed, _)| same(failed))
    }
}
