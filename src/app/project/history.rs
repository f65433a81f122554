//! Undo and redo of the user's settings: the parameters of the detector and of matching, the calibration of the open
//! burst, and the slopes of cursors.
//! Automatic changes (slopes that were found, the slope with most features) are no steps. A continued change (a drag,
//! typing, playing through the slopes) is one step.

use crate::app::document::Document;
use crate::app::pane::{Pane, PaneId};
use crate::app::project::Model;
use crate::burst::OpenOptions;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, SearchParams, Slope, SlopeGrid};
use crate::engine::Engine;
use crate::matching::MatchParams;

const MAX_STEPS: usize = 200;

impl Document {
    /// Parameters as the user set them: slopes that were found are not among them.
    fn given(&self) -> (SearchParams, &MatchParams, &OpenOptions) {
        let mut search = self.search();
        if self.slopes.is_auto() {
            search.detector.slopes = SlopeGrid::default();
        }
        (search, &self.matching, &self.calibration)
    }

    fn slopes_on_show(&self) -> Vec<(PaneId, Slope)> {
        self.panes.iter().map(|(id, pane)| (id, pane.cursor.slope)).collect()
    }

    /// Takes the settings that undo covers but the calibration, with which the burst has to be opened again; returns that.
    /// Slopes that were found are no step, but a step back returns to them.
    fn take_settings(&mut self, from: Self) -> OpenOptions {
        let is_found_still = from.slopes.is_auto() && self.slopes.is_auto();
        let slopes = if is_found_still { self.params.slopes } else { from.params.slopes };
        for (id, pane) in from.panes.iter() {
            self.panes.get_mut(id).into_iter().for_each(|own| own.cursor.slope = pane.cursor.slope);
        }
        self.params = DetectorParams { slopes, ..from.params };
        (self.slopes, self.matching) = (from.slopes, from.matching);
        from.calibration
    }

    fn changed_from(&self, before: &Self) -> String {
        let (now, was) = (self.given(), before.given());
        let changed = doc::ALL.iter().filter(|record| record.text(&now.0.detector) != record.text(&was.0.detector));
        let mut names: Vec<&str> = changed.map(|record| record.label).collect();
        let others = [
            (self.slopes != before.slopes, doc::SLOPES.label),
            (now.1 != was.1, "Matching"),
            (now.2.times != was.2.times, "Times"),
            (
                OpenOptions { times: None, ..now.2.clone() } != OpenOptions { times: None, ..was.2.clone() },
                "Calibration",
            ),
            (self.slopes_on_show() != before.slopes_on_show(), "Slope on show"),
        ];
        names.extend(others.into_iter().filter(|(differ, _)| *differ).map(|(_, name)| name));
        names.dedup();
        names.join(", ")
    }

    /// Whether the change from `before` is a step to undo. Opening or closing panes is none.
    fn is_step_from(&self, before: &Self) -> bool {
        let has_moved =
            |(id, pane): (PaneId, &Pane)| self.panes.get(id).is_some_and(|now| now.cursor.slope != pane.cursor.slope);
        before.panes.iter().any(has_moved) || self.given() != before.given()
    }
}

/// Documents before the steps that can be undone, and after those that were.
#[derive(Debug, Default)]
pub struct History {
    past: Vec<Document>,
    future: Vec<Document>,
    begun: Option<Document>,
}

impl History {
    /// Takes a change. It belongs to the step that is open, or opens one.
    pub fn take(&mut self, before: Document, after: &Document) {
        if after.is_step_from(&before) {
            self.begun.get_or_insert(before);
        }
    }

    /// Closes the step that is open, if there is one, and records it unless it ended where it began.
    pub fn close(&mut self, now: &Document) {
        if let Some(begun) = self.begun.take().filter(|begun| now.is_step_from(begun)) {
            self.past.push(begun);
            self.future.clear();
            if self.past.len() > MAX_STEPS {
                self.past.remove(0);
            }
        }
    }

    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// Takes a step back; returns the calibration before it.
    pub fn undo(&mut self, document: &mut Document) -> Option<OpenOptions> {
        let before = self.past.pop()?;
        self.future.push(document.clone());
        Some(document.take_settings(before))
    }

    /// Takes a step again; returns the calibration after it.
    pub fn redo(&mut self, document: &mut Document) -> Option<OpenOptions> {
        let after = self.future.pop()?;
        self.past.push(document.clone());
        Some(document.take_settings(after))
    }

    pub fn swap_sides(&mut self) {
        let steps = self.past.iter_mut().chain(&mut self.future).chain(&mut self.begun);
        steps.for_each(|document| document.panes.swap_sides());
    }

    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

impl Model {
    pub fn undo(&mut self, engine: &Engine) {
        self.step("Undone", History::undo, engine);
    }

    pub fn redo(&mut self, engine: &Engine) {
        self.step("Redone", History::redo, engine);
    }

    /// Takes a step. The note about it replaces one about the settings that are no longer set.
    fn step(
        &mut self,
        what: &str,
        step: impl FnOnce(&mut History, &mut Document) -> Option<OpenOptions>,
        engine: &Engine,
    ) {
        let before = self.document.clone();
        let calibration = step(&mut self.history, &mut self.document);
        self.check_params();
        let calibration = calibration.unwrap_or_else(|| before.calibration.clone());
        let changed = Document { calibration: calibration.clone(), ..self.document.clone() }.changed_from(&before);
        if !changed.is_empty() {
            self.messages.note(format!("{what}: {changed}"));
        }
        if calibration != before.calibration {
            self.results.slots.a.stepped_to = Some(calibration.clone());
            self.calibrate(calibration, engine);
        }
    }

    /// Makes a change by the user, which is a step to undo, or a part of one.
    pub fn as_step<T>(&mut self, change: impl FnOnce(&mut Self) -> T) -> T {
        let before = self.document.clone();
        let changed = change(self);
        self.history.take(before, &self.document);
        changed
    }

    /// Ends a step, unless `goes_on`: its change may continue in the next pass.
    pub(in crate::app) fn close_step(&mut self, goes_on: bool) {
        if !goes_on && !self.document.playing && self.history.begun.is_some() {
            self.history.close(&self.document);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::pair::tests::pair;
    use crate::app::project::side::Side;
    use crate::app::project::workspace::Workspace;
    use crate::detector::SlopeChoice;

    fn pass(history: &mut History, now: &mut Document, goes_on: bool, change: impl FnOnce(&mut Document)) {
        let before = now.clone();
        change(now);
        history.take(before, now);
        if !goes_on {
            history.close(now);
        }
    }

    #[test]
    fn a_new_step_removes_the_steps_that_were_undone() {
        let (mut model, mut history) = (Model::default(), History::default());
        pass(&mut history, &mut model.document, false, |m| m.params.levels = 5);
        pass(&mut history, &mut model.document, false, |m| m.matching.ratio = 0.5);
        pass(&mut history, &mut model.document, false, |_| {});
        history.undo(&mut model.document);
        assert_eq!((&model.document.matching, model.document.params.levels), (&MatchParams::default(), 5));
        pass(&mut history, &mut model.document, false, |m| m.params.octaves = 2);
        assert!(!history.can_redo());
    }

    #[test]
    fn steps_in_b_are_undone_in_b_also_after_the_sides_were_swapped() {
        let mut model = pair();
        model.document.open_workspace(Workspace::Pair);
        let mut history = std::mem::take(&mut model.history);
        let slopes = |model: &Model| Side::BOTH.map(|side| model.document.cursor_of(side).slope.u);
        model.document.focus_on_side(Side::B);
        let (a, before) = (slopes(&model)[0], slopes(&model)[1]);
        pass(&mut history, &mut model.document, false, |m| m.focused_mut().cursor.slope.u = 0.25);
        assert_eq!(slopes(&model), [a, 0.25]);
        history.undo(&mut model.document);
        assert_eq!(slopes(&model), [a, before]);
        history.redo(&mut model.document);
        model.history = history;
        model.swap_sides();
        history = std::mem::take(&mut model.history);
        assert_eq!(slopes(&model), [0.25, a]);
        history.undo(&mut model.document);
        assert_eq!(slopes(&model), [before, a], "the burst that was B");
    }

    #[test]
    fn a_drag_that_comes_back_is_no_step() {
        let (mut model, mut history) = (Model::default(), History::default());
        let before = model.document.params.edge_threshold;
        for (value, goes_on) in [(1.0, true), (30.0, true), (before, false)] {
            pass(&mut history, &mut model.document, goes_on, |m| m.params.edge_threshold = value);
        }
        assert!(!history.can_undo());
    }

    #[test]
    fn what_changes_by_itself_is_no_step() {
        let (mut model, mut history) = (Model::default(), History::default());
        model.document.slopes = SlopeChoice::AUTO;
        pass(&mut history, &mut model.document, false, |m| m.params.slopes = SlopeGrid::line(-2.0..=2.0, 5));
        assert!(!history.can_undo());
        pass(&mut history, &mut model.document, false, |m| {
            let focus = m.focus();
            m.panes.split(focus, crate::app::pane::Direction::Right);
        });
        assert!(!history.can_undo(), "nor is a new pane");
        pass(&mut history, &mut model.document, false, |m| m.params.levels = 5);
        history.undo(&mut model.document);
        assert_eq!(model.document.params.slopes, SlopeGrid::line(-2.0..=2.0, 5), "slopes that were found stay");
    }
}
