//! Explanations of detections: the slopes and the candidates of the one on show, and how evenly the frames contribute
//! to each feature of either burst (its coherence).

use crate::app::document::look::FeaturesShown;
use crate::app::document::side::{Side, Sides};
use crate::app::results::Model;
use crate::app::view::ColourBy;
use crate::detector::params::doc;
use crate::detector::{Detection, DetectorParams, Feature, Method, Moves, ParamChange, SearchParams, SlopeChoice};
use crate::engine::{Ended, Wanted};
use crate::inspect::candidates::{CandidateMark, Survey, SurveyOptions};
use crate::inspect::decoys::{DecoyReport, DecoyStudy};
use crate::inspect::spectrum::{SlopeJudgement, Spectrum};
use crate::inspect::verdict::{Judged, Verdict};
use crate::inspect::words::capitalised;
use crate::requests::{
    CoherenceRequest, Coherences, ExplainQuestion, ExplainRequest, Explained, Explanation, JobError, Running,
};
use crate::teach::{BottomTab, Workspace};
use std::sync::Arc;

/// Detection time, seconds, above which slopes are examined only on request: that takes nearly as long again.
pub(in crate::app) const SHORT_SECS: f32 = 5.0;

#[derive(Debug, Default)]
pub struct ExplainedState {
    slopes: Option<(ExplainRequest, Arc<Spectrum>)>,
    candidates: Option<(ExplainRequest, Arc<Survey>)>,
    decoys: Option<(ExplainRequest, Arc<DecoyReport>)>,
    /// The decoys that were asked for; of no use once another detection is on show.
    wanted_decoys: Option<ExplainRequest>,
    /// The candidate under the pointer, among those of the survey: features below it are not pointed at.
    pub pointed: Option<usize>,
    /// Whether the slopes of the detection on show are wanted although it took long.
    pub slopes_wanted: bool,
    pub asked_slopes: Wanted<ExplainRequest>,
    pub asked_candidates: Wanted<ExplainRequest>,
    pub asked_decoys: Wanted<ExplainRequest>,
}

impl Model {
    /// The slopes of the detection on show, if they are wanted and not known. A running detection comes first.
    pub fn missing_slopes(&self) -> Option<ExplainRequest> {
        let is_time = self.document.workspace == Workspace::Inspect && !self.results.slots.a.detecting.is_pending();
        self.wanted_slopes().filter(|_| is_time && self.spectrum().is_none())
    }

    pub fn missing_candidates(&self) -> Option<ExplainRequest> {
        let is_time = self.document.workspace == Workspace::Inspect && !self.results.slots.a.detecting.is_pending();
        self.wanted_candidates().filter(|_| is_time && self.survey().is_none())
    }

    /// Unlike the others they go on while another workspace is open.
    pub fn missing_decoys(&self) -> Option<ExplainRequest> {
        let is_current = self.stale().is_none() && !self.results.slots.a.detecting.is_pending();
        let wanted = self.results.explained.wanted_decoys.clone().filter(|_| is_current && self.decoys().is_none());
        wanted.filter(|wanted| self.decoys_request().as_ref() == Some(wanted))
    }

    fn decoys_request(&self) -> Option<ExplainRequest> {
        self.explain_request(ExplainQuestion::Decoys(DecoyStudy::default()))
    }

    /// Of the detection on show; `None` for stale features.
    pub fn decoys(&self) -> Option<&Arc<DecoyReport>> {
        let (request, report) = self.results.explained.decoys.as_ref()?;
        (self.stale().is_none() && *request == self.decoys_request()?).then_some(report)
    }

    /// Also after they failed or were cancelled.
    pub fn want_decoys(&mut self) {
        self.results.explained.asked_decoys.forget();
        self.results.explained.wanted_decoys = self.decoys_request();
    }

    pub(super) fn take_explained(&mut self, ended: Ended<ExplainRequest>) {
        let title = if matches!(ended.request.question, ExplainQuestion::Decoys(_)) { "Decoys" } else { "Explanation" };
        let Some(Explained { request, explanation }) = self.answer(ended, title) else { return };
        match explanation {
            Explanation::Slopes(spectrum) => self.results.explained.slopes = Some((request, spectrum)),
            Explanation::Decoys(report) => self.results.explained.decoys = Some((request, report)),
            Explanation::Candidates(survey) => {
                self.results.explained.candidates = Some((request, survey));
                (self.document.selected_candidate, self.results.explained.pointed) = (None, None);
            }
        }
    }

    /// If the changes concern the slopes, these count as given, and are those of the burst of `side`.
    pub fn apply_advice(&mut self, side: Side, changes: &[ParamChange]) {
        let slopes = self.params_of(side).slopes;
        match ParamChange::all_applied(changes, &DetectorParams { slopes, ..self.document.params.clone() }) {
            Ok(changed) => {
                let of_slopes = [doc::SLOPES_U, doc::SLOPES_V, doc::SLOPE_DIRECTION];
                if changes.iter().any(|change| of_slopes.contains(&change.parameter)) {
                    (self.document.params, self.document.slopes) = (changed, SlopeChoice::Given);
                } else {
                    self.document.params = DetectorParams { slopes: self.document.params.slopes, ..changed };
                }
                let labels: Vec<String> = changes.iter().map(ParamChange::label).collect();
                self.messages.note(format!("Set {}", labels.join(", ")));
            }
            Err(error) => self.messages.error("Apply", error.to_string()),
        }
    }

    /// While the features of `side` are searched, the advice on show is of the search before.
    pub fn takes_advice(&self, side: Side) -> bool {
        !self.results.slots[side].detecting.is_pending()
    }

    fn explain_request(&self, question: ExplainQuestion) -> Option<ExplainRequest> {
        Some(ExplainRequest { of: self.found_source(Side::A)?, question })
    }

    pub fn spectrum(&self) -> Option<&Arc<Spectrum>> {
        let (request, spectrum) = self.results.explained.slopes.as_ref()?;
        let wanted = self.explain_request(ExplainQuestion::Slopes)?;
        (*request == wanted).then_some(spectrum)
    }

    /// By what the frames show once that is examined, by the detection until then; `None` for stale features.
    pub fn slope_judgement(&self) -> Option<&SlopeJudgement> {
        let found = self.results.slots.a.found.as_ref().filter(|_| self.stale().is_none())?;
        self.spectrum().and_then(|spectrum| spectrum.judgement.as_ref()).or(found.judgement.as_ref())
    }

    pub fn survey(&self) -> Option<&Arc<Survey>> {
        let (request, survey) = self.results.explained.candidates.as_ref()?;
        (*request == self.wanted_candidates()?).then_some(survey)
    }

    pub fn survey_counts(&self) -> Option<&Arc<Survey>> {
        let (request, survey) = self.results.explained.candidates.as_ref()?;
        let wanted = self.explain_request(request.question)?;
        (request.of == wanted.of).then_some(survey)
    }

    pub fn selected_candidate(&self) -> Option<&CandidateMark> {
        self.survey()?.marks.get(self.document.selected_candidate?)
    }

    pub fn slopes_take_long(&self) -> bool {
        self.results.slots.a.found.as_ref().is_some_and(|found| found.elapsed.as_secs_f32() > SHORT_SECS)
    }

    /// Always wanted, unless the detection took long. A single frame has none.
    pub fn wanted_slopes(&self) -> Option<ExplainRequest> {
        let found = self.results.slots.a.found.as_ref()?;
        let has_slopes = found.params.method == Method::Buff && found.detection.frames_used.len() > 1;
        let wanted = has_slopes && (self.results.explained.slopes_wanted || !self.slopes_take_long());
        self.explain_request(ExplainQuestion::Slopes).filter(|_| wanted && self.stale().is_none())
    }

    pub fn wanted_candidates(&self) -> Option<ExplainRequest> {
        let test = self.document.shown_test?;
        let options = SurveyOptions { test: Some(test), ..SurveyOptions::default() };
        self.explain_request(ExplainQuestion::Candidates(options))
    }
}

#[derive(Debug, Default)]
pub struct CoherenceState {
    known: Vec<Coherences>,
    pub wanted: Sides<Wanted<CoherenceRequest>>,
}

impl CoherenceState {
    pub fn try_again(&mut self) {
        self.wanted = Sides::default();
    }

    pub fn running(&self) -> Option<Running> {
        self.wanted.both().into_iter().find_map(Wanted::running)
    }

    pub fn of(&self, detection: &Arc<Detection>) -> Option<&Arc<Vec<Judged>>> {
        self.known.iter().find(|known| Arc::ptr_eq(&known.detection, detection)).map(|known| &known.values)
    }

    pub fn failure_of(&self, detection: &Arc<Detection>) -> Option<&JobError> {
        let mut failures = self.wanted.both().into_iter().filter_map(Wanted::failure);
        failures.find(|(request, _)| Arc::ptr_eq(&request.detection, detection)).map(|(_, why)| why)
    }
}

impl Model {
    fn lists_verdicts(&self) -> bool {
        let is_in_table = self.shows_bottom() && self.document.bottom_tab == BottomTab::Table;
        self.document.workspace == Workspace::Inspect
            && (is_in_table || self.document.filter.needs_verdicts() || self.read().selected_feature().is_some())
    }

    /// A running detection comes first.
    pub fn missing_coherence(&self, side: Side) -> Option<CoherenceRequest> {
        let is_shown = match self.document.workspace {
            Workspace::Pair => true,
            Workspace::Inspect => {
                self.document.look.overlay != FeaturesShown::None
                    && self.document.panes.iter().any(|(_, pane)| pane.side == side)
            }
            _ => false,
        };
        let is_asked =
            self.document.colour_by == ColourBy::Coherence && is_shown || side == Side::A && self.lists_verdicts();
        if !is_asked || self.results.slots[side].detecting.is_pending() {
            return None;
        }
        let (of, detection) = (self.found_source(side)?, self.found_of(side)?.detection.clone());
        self.results.coherence.of(&detection).is_none().then_some(CoherenceRequest { of, detection })
    }

    /// Those of detections that are not open any more are forgotten.
    pub(super) fn take_coherences(&mut self, ended: Ended<CoherenceRequest>) {
        let open = self.results.slots.both().map(|slot| slot.found.as_ref().map(|found| found.detection.clone()));
        let is_open = |of: &Arc<Detection>| open.iter().flatten().any(|open| Arc::ptr_eq(open, of));
        if let Some(coherences) = self.answer(ended, "Coherence") {
            let known = &mut self.results.coherence.known;
            known.retain(|known| is_open(&known.detection) && !Arc::ptr_eq(&known.detection, &coherences.detection));
            known.push(coherences);
        }
    }

    pub fn judged(&self) -> Option<&Arc<Vec<Judged>>> {
        self.results.coherence.of(&self.results.slots.a.found.as_ref()?.detection)
    }
}

/// Verdict on `feature`, where it is known; of one that is likely real also how it moves, unless as all around it.
pub fn verdict_words(feature: Option<&Feature>, judged: &Judged) -> String {
    let moves = feature.map(|feature| feature.moves).filter(|_| judged.verdict == Verdict::Real);
    let moves = moves.filter(|moves| matches!(moves, Moves::ByItself | Moves::Edge));
    let moves = moves.map_or_else(String::new, |moves| format!(", {}", moves.words()));
    format!("{}{moves}: {}.", capitalised(judged.verdict.clause()), judged.why)
}

pub fn coherence_words(coherence: Option<f32>) -> String {
    coherence.map_or_else(|| "too noisy to tell".to_owned(), |coherence| format!("{coherence:.2}"))
}

impl Model {
    pub fn apply_set_up(&mut self) {
        let slopes = self.document.set_up.values.slopes(&self.used_positions(), &self.document.params);
        if let Ok((slopes, options)) = slopes.map(|slopes| (slopes.grid, slopes.options())) {
            let detector = DetectorParams { slopes, ..self.document.params.clone() };
            self.document.set_search(SearchParams { detector, slopes: SlopeChoice::Given });
            self.messages.note(format!("Set {options}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_real_feature_that_moves_by_itself_is_said_to() {
        let at = |moves| Feature { moves, ..Feature::default() };
        let judged = |verdict| Judged { verdict, coherence: None, why: "because".to_owned() };
        let words = |moves, verdict| verdict_words(Some(&at(moves)), &judged(verdict));
        assert_eq!(words(Moves::WithSurroundings, Verdict::Real), "Likely a real blob: because.");
        assert_eq!(words(Moves::ByItself, Verdict::Real), "Likely a real blob, moves by itself: because.");
        assert_eq!(words(Moves::Edge, Verdict::Real), "Likely a real blob, motion not defined (edge): because.");
        assert_eq!(words(Moves::Ghost, Verdict::Ghost), "Likely a ghost: because.");
    }
}
