//! Comparison of methods on the same burst, as plain values: the results, the missing steps, and the panes.
//!
//! With a second burst open, each method also runs on that one, and its features of both are matched, so that matches
//! can be compared too.

use crate::app::document::method::MethodId;
use crate::app::document::side::{Side, Sides};
use crate::app::pane::MethodsPreset;
use crate::app::results::pair::Matches;
use crate::app::results::{Effect, Model};
use crate::app::results::{Part, Pass};
use crate::burst::OpenOptions;
use crate::detector::{Detection, DetectorParams};
use crate::engine::{Ended, Engine, Want, Wanted};
use crate::requests::{
    BurstId, BurstSource, CompareRequest, Compared, DetectRequest, Detected, JobError, MatchRequest, OpenBurst,
    OpenRequest, Running,
};
use crate::teach::Workspace;
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
    asked: Option<CompareJob>,
    pub opening_gold: Sides<Wanted<OpenRequest>>,
    arranged: Vec<MethodId>,
    found: HashMap<(MethodId, Side), MethodFound>,
    matches: HashMap<MethodId, Matches>,
    failed: Vec<(CompareJob, String)>,
}

impl Compare {
    pub fn running(&self) -> Option<(MethodId, Running)> {
        Some((self.asked.as_ref()?.method, self.wanted.running()?))
    }

    pub fn problem(&self, method: MethodId) -> Option<&str> {
        self.failed.iter().rev().find(|(job, _)| job.method == method).map(|(_, why)| why.as_str())
    }

    pub fn all_found_mut(&mut self) -> impl Iterator<Item = &mut MethodFound> {
        self.found.values_mut()
    }

    pub fn take_found(&mut self, method: MethodId, side: Side, found: MethodFound) {
        self.failed.retain(|(job, _)| job.method != method);
        self.found.insert((method, side), found);
    }

    pub fn take_matches(&mut self, method: MethodId, matches: Matches) {
        self.failed.retain(|(job, _)| job.method != method);
        self.matches.insert(method, matches);
    }

    pub fn take_failure(&mut self, job: CompareJob, why: String) {
        self.failed.push((job, why));
    }

    pub fn forget_failures(&mut self) {
        self.failed.clear();
    }
}

/// Work of the comparison, one request at a time.
pub(super) struct Methods;

impl Part for Methods {
    fn wants<'m>(&self, model: &'m Model) -> Vec<&'m dyn Want> {
        vec![&model.results.compare.wanted]
    }

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect> {
        let (compare, messages) = (&mut pass.model.results.compare, &mut pass.model.messages);
        for ended in compare.wanted.take() {
            let Some(job) = compare.asked.take() else { continue };
            match ended.result {
                Ok(Compared::Detected(Detected { burst, params, detection, .. })) => {
                    let found = MethodFound { burst, params, detection, elapsed: ended.elapsed };
                    compare.take_found(job.method, job.side, found);
                }
                Ok(Compared::Matched(matched)) => {
                    compare.take_matches(job.method, Matches::new(matched, ended.elapsed));
                }
                Err(error) => {
                    if error != JobError::Cancelled {
                        messages.error(job.method.label(), error.to_string());
                    }
                    compare.take_failure(job, error.to_string());
                }
            }
        }
        Vec::new()
    }

    fn ask(&self, pass: &mut Pass<'_>) {
        let model = &mut *pass.model;
        if model.document.workspace != Workspace::Methods || model.results.slots.a.burst.is_none() {
            return;
        }
        model.share_what_is_found();
        let opening = model.results.compare.opening_gold.both();
        let is_busy = model.results.compare.wanted.is_pending() || opening.iter().any(|gold| gold.is_pending());
        let job = model.next_compare_job().filter(|_| !pass.dragging && model.document.auto_detect && !is_busy);
        if let Some(job) = job {
            model.results.compare.wanted.ask(pass.engine, job.request.clone());
            model.results.compare.asked = Some(job);
        }
    }

    fn is_there(&self, model: &Model) -> bool {
        model.document.workspace != Workspace::Methods
            || !model.document.auto_detect
            || model.next_compare_job().is_none()
    }
}

impl Model {
    pub(in crate::app) fn open_gold(&mut self, side: Side, source: BurstSource, engine: &Engine) {
        let options = self.calibration_of(side).clone().with_burst_of(&OpenOptions::default());
        self.results.compare.opening_gold[side].ask(engine, OpenRequest { source, options });
    }

    pub(super) fn take_gold(&mut self, side: Side, ended: Ended<OpenRequest>) -> Vec<Effect> {
        const TITLE: &str = "Open gold standard";
        if let Some(open) = self.answer(ended, TITLE) {
            self.messages.resolved(TITLE);
            self.messages.note(format!("Opened as gold standard of {}: {}", side.name(), open.describe()));
            self.results.compare.gold[side] = Some(open);
        }
        self.document.gold[side] = self.results.compare.gold[side].as_ref().map(|open| open.source.clone());
        Vec::new()
    }

    /// Burst that `method` searches on `side`: the open one, or the gold standard's image.
    pub fn method_burst(&self, method: MethodId, side: Side) -> Option<&OpenBurst> {
        match method {
            MethodId::Gold => self.results.compare.gold[side].as_ref(),
            _ => self.burst_of(side),
        }
    }

    pub fn method_params(&self, method: MethodId, side: Side) -> DetectorParams {
        let params = method.params(&self.params_of(side));
        self.document.methods.at_same_false_rate(method, params)
    }

    pub fn method_found(&self, method: MethodId, side: Side) -> Option<&MethodFound> {
        let open = self.method_burst(method, side)?;
        let found = self.results.compare.found.get(&(method, side));
        found.filter(|found| found.burst == open.id && found.params == self.method_params(method, side))
    }

    pub fn method_matches(&self, method: MethodId) -> Option<&Matches> {
        let wanted = self.wanted_method_matches(method)?;
        self.results.compare.matches.get(&method).filter(|matches| matches.request == wanted)
    }

    fn wanted_method_matches(&self, method: MethodId) -> Option<MatchRequest> {
        let of = |side: Side| {
            let (found, burst) = (self.method_found(method, side)?, self.method_burst(method, side)?);
            Some((found.detection.clone(), (burst.clone(), found.params.clone())))
        };
        let ((a, burst_a), (b, burst_b)) = (of(Side::A)?, of(Side::B)?);
        Some(MatchRequest { a, b, bursts: [burst_a, burst_b], params: self.document.matching.clone() })
    }

    pub fn methods_shown(&self) -> Vec<MethodId> {
        let usable = |method: &MethodId| self.method_burst(*method, Side::A).is_some();
        MethodId::ALL.into_iter().filter(|m| self.document.methods.shows(*m)).filter(usable).collect()
    }

    /// Features of A by each method that is shown, then those of B, then their matches.
    pub fn next_compare_job(&self) -> Option<CompareJob> {
        let jobs = self.methods_shown().into_iter().flat_map(|method| {
            let detections = Side::BOTH.into_iter().filter_map(move |side| self.missing_detection(method, side));
            detections.chain(self.missing_matching(method)).collect::<Vec<_>>()
        });
        // All methods on A come first: A is on show.
        let mut jobs: Vec<CompareJob> = jobs.filter(|job| !self.has_failed(job)).collect();
        jobs.sort_by_key(|job| job.side != Side::A);
        jobs.into_iter().next()
    }

    fn missing_detection(&self, method: MethodId, side: Side) -> Option<CompareJob> {
        let burst = self.method_burst(method, side)?.clone();
        let params = self.method_params(method, side);
        let usable = params.validate_for(&burst.burst.positions, burst.burst.size()).is_ok();
        (usable && self.method_found(method, side).is_none()).then_some(CompareJob {
            method,
            side,
            request: CompareRequest::Detect(DetectRequest { burst, params: params.into() }),
        })
    }

    fn missing_matching(&self, method: MethodId) -> Option<CompareJob> {
        let wanted = self.wanted_method_matches(method)?;
        (self.results.pair.param_error.is_none() && self.method_matches(method).is_none()).then_some(CompareJob {
            method,
            side: Side::B,
            request: CompareRequest::Match(wanted),
        })
    }

    fn has_failed(&self, job: &CompareJob) -> bool {
        let same = |other: &CompareJob| other.method == job.method && other.request == job.request;
        self.results.compare.failed.iter().any(|(failed, _)| same(failed))
    }

    /// Takes over results of the other workspaces with equal parameters, so that they are not computed again.
    pub fn share_what_is_found(&mut self) {
        for method in MethodId::ALL.into_iter().filter(|m| *m != MethodId::Gold) {
            for side in Side::BOTH {
                if self.method_found(method, side).is_some() {
                    continue;
                }
                let wanted = self.method_params(method, side);
                let shared = self.whole_found_of(side).filter(|f| f.params == wanted).cloned();
                if let (Some(found), Some(open)) = (shared, self.burst_of(side)) {
                    let (elapsed, Detected { params, detection, .. }) = (found.elapsed, found.detected);
                    let found = MethodFound { burst: open.id, params, detection, elapsed };
                    self.results.compare.take_found(method, side, found);
                }
            }
        }
    }

    /// In *Methods*, methods that were switched on get a pane, others lose theirs; the rest of the arrangement stays.
    pub fn refresh_workspace(&mut self) {
        self.document.panes.turn_to(self.document.workspace);
        if self.document.workspace != Workspace::Methods || self.results.slots.a.burst.is_none() {
            return;
        }
        let now = self.methods_shown();
        if now == self.results.compare.arranged {
            return;
        }
        let before = std::mem::replace(&mut self.results.compare.arranged, now.clone());
        let shown = self.document.panes.shown();
        let has_pane =
            |method| shown.iter().filter_map(|id| self.document.panes.get(*id)).any(|pane| pane.method == Some(method));
        if before.is_empty() && !now.iter().any(|method| has_pane(*method)) {
            self.lay_out_methods(MethodsPreset::Panes);
            return;
        }
        let both = self.burst_of(Side::B).is_some();
        now.iter().for_each(|method| self.document.panes.add_method(*method, both));
        before
            .iter()
            .filter(|method| !now.contains(method))
            .for_each(|method| self.document.panes.remove_method(*method));
    }

    pub fn keep_methods_arranged(&mut self) {
        let shown = self.document.panes.shown_in(Workspace::Methods);
        let is_laid_out = shown.iter().filter_map(|id| self.document.panes.get(*id)).any(|pane| pane.method.is_some());
        self.results.compare.arranged = if is_laid_out { self.methods_shown() } else { Vec::new() };
    }

    pub fn lay_out_methods(&mut self, preset: MethodsPreset) {
        let (methods, both) = (self.methods_shown(), self.burst_of(Side::B).is_some());
        self.document.panes.lay_out_methods(preset, &methods, both);
    }
}

#[cfg(test)]
mod tests;
