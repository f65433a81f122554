//! Explanations of detections: the slopes and the candidates of the one on show, and how evenly the frames contribute
//! to each feature of either burst (its coherence).

use crate::app::document::{FeaturesShown, Side, Sides};
use crate::app::{results::Read, view::ColourBy};
use crate::detector::{Detection, Feature, Method, Moves, Quantity};
use crate::engine::Wanted;
use crate::inspect::place::{CandidateMark, Judged, Survey, SurveyOptions, Verdict};
use crate::inspect::result::{DecoyStudy, Decoys, TooFew, has_too_few};
use crate::inspect::slopes::{SlopeJudgement, Spectrum};
use crate::inspect::words::capitalised;
use crate::requests::{CoherenceRequest, Coherences, ExplainQuestion, ExplainRequest, JobError, Running};
use crate::teach::BottomTab;
use std::sync::Arc;

/// Detection time, seconds, above which slopes are examined only on request: that takes nearly as long again.
pub(in crate::app) const SHORT_SECS: f32 = 5.0;

#[derive(Debug, Default)]
pub struct ExplainedState {
    pub slopes: Option<(ExplainRequest, Arc<Spectrum>)>,
    pub candidates: Option<(ExplainRequest, Arc<Survey>)>,
    pub decoys: Option<(ExplainRequest, Arc<Decoys>)>,
    pub too_few: Option<(ExplainRequest, Option<TooFew>)>,
    /// The decoys that were asked for; of no use once another detection is on show.
    pub wanted_decoys: Option<ExplainRequest>,
    /// The candidate under the pointer, among those of the survey: features below it are not pointed at.
    pub pointed: Option<usize>,
    /// Whether the slopes of the detection on show are wanted although it took long.
    pub slopes_wanted: bool,
    pub asked_slopes: Wanted<ExplainRequest>,
    pub asked_candidates: Wanted<ExplainRequest>,
    pub asked_decoys: Wanted<ExplainRequest>,
    pub asked_too_few: Wanted<ExplainRequest>,
}

#[derive(Debug, Default)]
pub struct CoherenceState {
    pub known: Vec<Coherences>,
    pub wanted: Sides<Wanted<CoherenceRequest>>,
}

impl CoherenceState {
    pub fn try_again(&mut self) {
        self.wanted = Sides::default();
    }

    pub fn running(&self) -> Option<Running> {
        self.wanted.both().into_iter().find_map(|wanted| wanted.running)
    }

    pub fn of(&self, detection: &Arc<Detection>) -> Option<&Arc<Vec<Judged>>> {
        self.known.iter().find(|known| Arc::ptr_eq(&known.detection, detection)).map(|known| &known.values)
    }

    pub fn failure_of(&self, detection: &Arc<Detection>) -> Option<&JobError> {
        let mut failures = self.wanted.both().into_iter().filter_map(Wanted::failure);
        failures.find(|(request, _)| Arc::ptr_eq(&request.detection, detection)).map(|(_, why)| why)
    }
}

impl<'a> Read<'a> {
    /// The slopes of the detection on show, if they are not known: always wanted, unless the detection took long. A
    /// single frame has none. A running detection comes first.
    pub fn missing_slopes(self) -> Option<ExplainRequest> {
        let is_time = self.document.workspace.inspects() && !self.results.slots.a.detecting.is_pending();
        let found =
            self.found_of(Side::A).filter(|_| is_time && self.spectrum().is_none() && self.stale().is_none())?;
        let has_slopes = found.params.method == Method::Buff && found.detection.frames_used.len() > 1;
        let wanted = has_slopes && (self.results.explained.slopes_wanted || !self.slopes_take_long());
        self.explain_request(ExplainQuestion::Slopes).filter(|_| wanted)
    }

    pub fn missing_candidates(self) -> Option<ExplainRequest> {
        let is_time = self.document.workspace.inspects() && !self.results.slots.a.detecting.is_pending();
        self.wanted_candidates().filter(|_| is_time && self.survey().is_none())
    }

    /// Decoys that were asked for; unless the detection took long also those by which features are filtered that only
    /// real things should pass, and where too little is seen to judge the slopes. Unlike the others they go on while
    /// another workspace is open.
    pub fn missing_decoys(self) -> Option<ExplainRequest> {
        let is_current = self.stale().is_none() && !self.results.slots.a.detecting.is_pending();
        let request = self.decoys_request().filter(|_| is_current && self.decoys().is_none())?;
        // The frames may leave open if the slopes fit, while features were found.
        let judgement = self.spectrum().and_then(|spectrum| spectrum.judgement.as_ref());
        let is_open = judgement.is_some_and(|judgement| !judgement.fits && judgement.advice.is_none());
        let by_filter = self.document.filter.verdict.is_some() || !self.features().is_empty() && is_open;
        (by_filter && !self.slopes_take_long() || self.has_asked_for_decoys(&request)).then_some(request)
    }

    /// Why there are few features, where there are few; it takes a search or two, also after one that took long.
    pub fn missing_too_few(self) -> Option<ExplainRequest> {
        let found = self.found_of(Side::A).filter(|_| self.stale().is_none() && self.takes_advice(Side::A))?;
        let request = self.explain_request(ExplainQuestion::TooFew)?;
        let is_known = self.results.explained.too_few.as_ref().is_some_and(|(of, _)| *of == request);
        let is_open = !is_known && self.document.workspace.inspects();
        (is_open && has_too_few(&found.detection, request.of.burst.burst.size())).then_some(request)
    }

    /// Of the detection on show; `None` for stale features.
    pub fn too_few(self) -> Option<&'a TooFew> {
        let (request, few) = self.results.explained.too_few.as_ref().filter(|_| self.stale().is_none())?;
        few.as_ref().filter(|_| self.explain_request(ExplainQuestion::TooFew).as_ref() == Some(request))
    }

    pub fn has_asked_for_decoys(self, request: &ExplainRequest) -> bool {
        self.results.explained.wanted_decoys.as_ref() == Some(request)
    }

    pub fn decoys_request(self) -> Option<ExplainRequest> {
        self.explain_request(ExplainQuestion::Decoys(DecoyStudy::default()))
    }

    /// Of the detection on show; `None` for stale features.
    pub fn decoys(self) -> Option<&'a Arc<Decoys>> {
        let (request, report) = self.results.explained.decoys.as_ref()?;
        (self.stale().is_none() && *request == self.decoys_request()?).then_some(report)
    }

    /// While the features of `side` are searched, the advice on show is of the search before.
    pub fn takes_advice(self, side: Side) -> bool {
        !self.results.slots[side].detecting.is_pending()
    }

    fn explain_request(self, question: ExplainQuestion) -> Option<ExplainRequest> {
        Some(ExplainRequest { of: self.found_source(Side::A)?, question })
    }

    pub fn spectrum(self) -> Option<&'a Arc<Spectrum>> {
        let (request, spectrum) = self.results.explained.slopes.as_ref()?;
        (*request == self.explain_request(ExplainQuestion::Slopes)?).then_some(spectrum)
    }

    /// By what the frames show once that is examined, by the detection until then; `None` for stale features.
    pub fn slope_judgement(self) -> Option<&'a SlopeJudgement> {
        let found = self.found_of(Side::A).filter(|_| self.stale().is_none())?;
        self.spectrum().and_then(|spectrum| spectrum.judgement.as_ref()).or(found.judgement.as_ref())
    }

    pub fn survey(self) -> Option<&'a Arc<Survey>> {
        let (request, survey) = self.results.explained.candidates.as_ref()?;
        (*request == self.wanted_candidates()?).then_some(survey)
    }

    pub fn survey_counts(self) -> Option<&'a Arc<Survey>> {
        let (request, survey) = self.results.explained.candidates.as_ref()?;
        (request.of == self.explain_request(request.question)?.of).then_some(survey)
    }

    pub fn selected_candidate(self) -> Option<&'a CandidateMark> {
        self.survey()?.marks.get(self.document.selected_candidate?)
    }

    pub fn slopes_take_long(self) -> bool {
        self.found_of(Side::A).is_some_and(|found| found.elapsed.as_secs_f32() > SHORT_SECS)
    }

    pub fn wanted_candidates(self) -> Option<ExplainRequest> {
        let test = self.document.shown_test?;
        let options = SurveyOptions { test: Some(test), ..SurveyOptions::default() };
        self.explain_request(ExplainQuestion::Candidates(options))
    }

    /// A running detection comes first.
    pub fn missing_coherence(self, side: Side) -> Option<CoherenceRequest> {
        let is_drawn = self.document.look.overlay != FeaturesShown::None
            && self.document.panes.iter().any(|(_, pane)| pane.side == side);
        let workspace = self.document.workspace;
        let is_shown = workspace.shows_pair() || workspace.inspects() && is_drawn;
        let is_in_table = self.shows_bottom() && self.document.bottom_tab == BottomTab::Table;
        let lists_verdicts = is_in_table || self.document.filter.needs_verdicts() || self.selected_feature().is_some();
        let is_asked = self.document.colour_by == ColourBy::Of(Quantity::Coherence) && is_shown
            || side == Side::A && workspace.inspects() && lists_verdicts;
        if !is_asked || self.results.slots[side].detecting.is_pending() {
            return None;
        }
        let (of, detection) = (self.found_source(side)?, self.found_of(side)?.detection.clone());
        self.results.coherence.of(&detection).is_none().then_some(CoherenceRequest { of, detection })
    }

    pub fn judged(self) -> Option<&'a Arc<Vec<Judged>>> {
        self.results.coherence.of(&self.found_of(Side::A)?.detection)
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
