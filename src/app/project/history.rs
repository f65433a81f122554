//! Undo and redo of the user's settings: the parameters of the detector and of matching, and the slopes of cursors.
//! Automatic changes (slopes that were found, the slope with most features) are no steps. A continued change (a drag,
//! typing, playing through the slopes) is one step.

use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::side::Side;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, Slope, SlopeChoice, SlopeGrid};
use crate::matching::MatchParams;

const MAX_STEPS: usize = 200;

#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    params: DetectorParams,
    slopes: SlopeChoice,
    /// The slopes that were given, or found: what is found is no step, but a step back returns to it.
    grid: SlopeGrid,
    matching: MatchParams,
    cursors: Vec<(PaneId, Slope)>,
}

impl Settings {
    pub fn of(model: &Model) -> Self {
        let mut params = model.params.clone();
        let grid = params.slopes;
        if model.slopes.is_auto() {
            // Slopes that were found are not set by the user.
            params.slopes = SlopeGrid::default();
        }
        let cursors = model.panes.iter().map(|(id, pane)| (id, pane.cursor.slope)).collect();
        Self { params, slopes: model.slopes, grid, matching: model.matching.clone(), cursors }
    }

    fn apply(self, model: &mut Model) {
        let is_found_still = self.slopes.is_auto() && model.slopes.is_auto();
        let slopes = if is_found_still { model.params.slopes } else { self.grid };
        model.params = DetectorParams { slopes, ..self.params };
        (model.slopes, model.matching) = (self.slopes, self.matching);
        for (id, slope) in self.cursors {
            if let Some(pane) = model.panes.get_mut(id) {
                pane.cursor.slope = slope;
            }
        }
        model.check_params();
        model.check_pair();
    }

    fn changed_from(&self, before: &Self) -> String {
        let changed = doc::ALL.iter().filter(|record| record.text(&self.params) != record.text(&before.params));
        let mut names: Vec<&str> = changed.map(|record| record.label).collect();
        let others = [
            (self.slopes != before.slopes, doc::SLOPES.label),
            (self.matching != before.matching, "Matching"),
            (self.cursors != before.cursors, "Slope on show"),
        ];
        names.extend(others.into_iter().filter(|(differ, _)| *differ).map(|(_, name)| name));
        names.dedup();
        names.join(", ")
    }

    /// Whether the change from `before` is a step to undo. Opening or closing panes is none.
    fn is_step_from(&self, before: &Self) -> bool {
        let moved = before
            .cursors
            .iter()
            .any(|(id, slope)| self.cursors.iter().find(|(other, _)| other == id).is_some_and(|(_, now)| now != slope));
        moved || (&self.params, self.slopes, &self.matching) != (&before.params, before.slopes, &before.matching)
    }
}

#[derive(Debug, Default)]
pub struct History {
    past: Vec<Settings>,
    future: Vec<Settings>,
    begun: Option<Settings>,
}

impl History {
    /// Takes a change of the settings. It belongs to the step that is open, or opens one.
    pub fn take(&mut self, before: Settings, after: &Settings) {
        if after.is_step_from(&before) {
            self.begun.get_or_insert(before);
        }
    }

    /// Closes the step that is open, if there is one, and records it unless it ended where it began.
    pub fn close(&mut self, now: &Settings) {
        if let Some(begun) = self.begun.take().filter(|begun| now.is_step_from(begun)) {
            self.past.push(begun);
            self.future.clear();
            if self.past.len() > MAX_STEPS {
                self.past.remove(0);
            }
        }
    }

    fn is_open(&self) -> bool {
        self.begun.is_some()
    }

    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    pub fn undo(&mut self, model: &mut Model) {
        if let Some(before) = self.past.pop() {
            self.future.push(Settings::of(model));
            before.apply(model);
        }
    }

    pub fn redo(&mut self, model: &mut Model) {
        if let Some(after) = self.future.pop() {
            self.past.push(Settings::of(model));
            after.apply(model);
        }
    }

    pub fn swap_sides(&mut self) {
        for (id, _) in self.past.iter_mut().chain(&mut self.future).chain(&mut self.begun).flat_map(|s| &mut s.cursors)
        {
            if let Some(side) = Side::BOTH.into_iter().find(|side| PaneId::of(*side) == *id) {
                *id = PaneId::of(side.other());
            }
        }
    }

    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

impl Model {
    pub fn undo(&mut self) {
        self.with_history("Undone", History::undo);
    }

    pub fn redo(&mut self) {
        self.with_history("Redone", History::redo);
    }

    /// Takes a step. The note about it replaces one about the settings that are no longer set.
    fn with_history(&mut self, what: &str, step: impl FnOnce(&mut History, &mut Self)) {
        let mut history = std::mem::take(&mut self.history);
        let before = Settings::of(self);
        step(&mut history, self);
        let after = Settings::of(self);
        if after != before {
            self.messages.note(format!("{what}: {}", after.changed_from(&before)));
        }
        self.history = history;
    }

    /// Makes a change by the user, which is a step to undo, or a part of one.
    pub fn as_step<T>(&mut self, change: impl FnOnce(&mut Self) -> T) -> T {
        let before = Settings::of(self);
        let changed = change(self);
        let after = Settings::of(self);
        self.history.take(before, &after);
        changed
    }

    /// Ends a step, unless `goes_on`: its change may continue in the next pass.
    pub(in crate::app) fn close_step(&mut self, goes_on: bool) {
        if !goes_on && !self.playing && self.history.is_open() {
            let now = Settings::of(self);
            self.history.close(&now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::pair::tests::pair;
    use crate::app::project::workspace::Workspace;

    fn pass(history: &mut History, model: &mut Model, goes_on: bool, change: impl FnOnce(&mut Model)) {
        let before = Settings::of(model);
        change(model);
        let after = Settings::of(model);
        history.take(before, &after);
        if !goes_on {
            history.close(&after);
        }
    }

    #[test]
    fn a_new_step_removes_the_steps_that_were_undone() {
        let (mut model, mut history) = (Model::default(), History::default());
        pass(&mut history, &mut model, false, |m| m.params.levels = 5);
        pass(&mut history, &mut model, false, |m| m.matching.ratio = 0.5);
        pass(&mut history, &mut model, false, |_| {});
        history.undo(&mut model);
        assert_eq!((&model.matching, model.params.levels), (&MatchParams::default(), 5));
        pass(&mut history, &mut model, false, |m| m.params.octaves = 2);
        assert!(!history.can_redo());
    }

    #[test]
    fn steps_in_b_are_undone_in_b_also_after_the_sides_were_swapped() {
        let mut model = pair();
        model.open_workspace(Workspace::Pair);
        let mut history = std::mem::take(&mut model.history);
        let slopes = |model: &Model| Side::BOTH.map(|side| model.cursor_of(side).slope.u);
        model.focus_on_side(Side::B);
        let (a, before) = (slopes(&model)[0], slopes(&model)[1]);
        pass(&mut history, &mut model, false, |m| m.focused_mut().cursor.slope.u = 0.25);
        assert_eq!(slopes(&model), [a, 0.25]);
        history.undo(&mut model);
        assert_eq!(slopes(&model), [a, before]);
        history.redo(&mut model);
        model.history = history;
        model.swap_sides();
        history = std::mem::take(&mut model.history);
        assert_eq!(slopes(&model), [0.25, a]);
        history.undo(&mut model);
        assert_eq!(slopes(&model), [before, a], "the burst that was B");
    }

    #[test]
    fn a_drag_that_comes_back_is_no_step() {
        let (mut model, mut history) = (Model::default(), History::default());
        let before = model.params.edge_threshold;
        for (value, goes_on) in [(1.0, true), (30.0, true), (before, false)] {
            pass(&mut history, &mut model, goes_on, |m| m.params.edge_threshold = value);
        }
        assert!(!history.can_undo());
    }

    #[test]
    fn what_changes_by_itself_is_no_step() {
        let (mut model, mut history) = (Model::default(), History::default());
        model.slopes = SlopeChoice::AUTO;
        pass(&mut history, &mut model, false, |m| m.params.slopes = SlopeGrid::line(-2.0..=2.0, 5));
        assert!(!history.can_undo());
        pass(&mut history, &mut model, false, |m| {
            let focus = m.focus();
            m.panes.split(focus, crate::app::pane::Direction::Right);
        });
        assert!(!history.can_undo(), "nor is a new pane");
        pass(&mut history, &mut model, false, |m| m.params.levels = 5);
        history.undo(&mut model);
        assert_eq!(model.params.slopes, SlopeGrid::line(-2.0..=2.0, 5), "slopes that were found stay");
    }
}
