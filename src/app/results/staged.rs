//! A lesson's project beside the user's, and documents that sessions and lessons put in place of the one on show.

use crate::app::document::Document;
use crate::app::document::action::{Reselect, Staged};
use crate::app::document::datasets::DatasetChoice;
use crate::app::document::history::History;
use crate::app::document::side::{Side, Sides};
use crate::app::pane::Preset;
use crate::app::results::comparison::ComparisonResults;
use crate::app::results::own::Own;
use crate::app::results::probe::ProbeResults;
use crate::app::results::{Effect, Model, Read, Results};
use crate::burst::OpenOptions;
use crate::engine::Engine;
use crate::requests::{BurstSource, OpenRequest};
use crate::teach::Workspace;
use std::mem::{replace, take};

/// Project of the user while a lesson is open, and the burst that was being opened in it.
#[derive(Debug)]
pub struct UserProject {
    document: Document,
    results: Results,
    history: History,
    opening: Option<(OpenRequest, Option<Own>)>,
}

impl Model {
    pub fn is_in_lesson(&self) -> bool {
        self.of_user.is_some()
    }

    /// The one before the open lesson, or without one that on show.
    pub fn project_of_user(&self) -> Read<'_> {
        let of_user = self.of_user.as_deref().map(|UserProject { document, results, .. }| Read { document, results });
        of_user.unwrap_or(self.read())
    }

    pub(in crate::app) fn take_staged(&mut self, staged: Staged, engine: &Engine) -> Option<Effect> {
        match staged {
            Staged::BeginLesson => return Some(self.begin_lesson()),
            Staged::EndLesson { keeps_opening } => return self.end_lesson(keeps_opening, engine),
            Staged::Reopen(side, source) => {
                let options = self.calibration_of(side).clone();
                self.open_with(side, OpenRequest { source, options }, None, engine);
            }
            Staged::Open { bursts, cameras } => self.open_for_step(bursts, cameras, engine),
            Staged::Begin { document, layout, probe } => self.begin_with(*document, layout, probe),
            Staged::SelectFirst if self.document.workspace == Workspace::Pair => {
                self.document.selected_match = self.results.pair.listed.first().copied();
            }
            Staged::SelectFirst => self.document.selected = self.results.listed.first().copied(),
            Staged::Show(document, reselect) => self.show_document(*document, reselect),
            Staged::ReadNamed => return self.read_named(engine),
            Staged::ProbeWhenOpen(source, place) => self.results.studies.probe_when_open = Some((source, place)),
        }
        None
    }

    fn begin_lesson(&mut self) -> Effect {
        let slot = &mut self.results.slots.a;
        let opening = slot.opening.pending().map(|request| (request.clone(), slot.leaves.take()));
        self.results.slots.a.opening.forget();
        let of_lesson = Document { figure: self.document.figure, ..Document::default() };
        let (document, results, history) = self.show(of_lesson, Results::default(), History::default());
        self.of_user = Some(Box::new(UserProject { document, results, history, opening }));
        Effect::ForgetWidgets
    }

    fn end_lesson(&mut self, keeps_opening: bool, engine: &Engine) -> Option<Effect> {
        let UserProject { document, results, history, opening } = *self.of_user.take()?;
        let (_, of_lesson, _) = self.show(document, results, history);
        if self.results.poses.reading.pending().is_some() {
            // What was read meanwhile was not taken.
            self.read_trajectories(engine);
        }
        if keeps_opening {
            self.results.slots.a.opening = of_lesson.slots.a.opening;
        } else if let Some((request, leaves)) = opening {
            self.open_with(Side::A, request, leaves, engine);
        }
        Some(Effect::ForgetWidgets)
    }

    /// Shows another project, and returns the one on show until now. The dataset, the Lab and the colours of the window
    /// stay, so that their work goes on.
    fn show(&mut self, document: Document, results: Results, history: History) -> (Document, Results, History) {
        let Document { theme, dataset, pairs, lab, .. } = self.document.clone();
        let document = Document { theme, dataset, pairs, lab, ..document };
        let Results { figures, datasets, studies, .. } = &mut self.results;
        let (figures, datasets, studies) = (take(figures), take(datasets), take(studies));
        let results = Results { figures, datasets, studies, ..results };
        self.messages.forget_note();
        (
            replace(&mut self.document, document),
            replace(&mut self.results, results),
            replace(&mut self.history, history),
        )
    }

    fn open_for_step(&mut self, bursts: Sides<Option<BurstSource>>, cameras: bool, engine: &Engine) {
        // The burst that another step requested is not needed any more.
        self.results.slots.a.opening.forget();
        // Which of two bursts was opened last says nothing.
        self.messages.forget_note();
        for (side, source) in [(Side::A, bursts.a), (Side::B, bursts.b)] {
            let is_open = self.burst_of(side).is_some_and(|burst| Some(&burst.source) == source.as_ref());
            let Some(source) = source.filter(|_| !is_open) else { continue };
            // A burst that was open before the lesson need not be opened again.
            let of_user = self.project_of_user().results.slots.both().map(|slot| slot.burst.clone());
            match (side, of_user.into_iter().flatten().find(|burst| burst.source == source)) {
                (Side::A, Some(burst)) => self.take_burst(burst),
                (Side::B, Some(burst)) => self.take_second_burst(burst),
                (side, None) => {
                    let options = OpenOptions::default();
                    self.open_with(side, OpenRequest { source, options }, None, engine);
                }
            }
        }
        if !cameras {
            self.close_trajectories();
        } else if self.results.poses.is_empty() {
            self.show_demo_cameras(engine);
        }
    }

    fn begin_with(&mut self, document: Document, layout: Option<Preset>, probe: Option<[f32; 2]>) {
        self.document = document;
        for side in Side::BOTH {
            if !self.document.auto_detect || !self.features_are_current(side) {
                self.results.slots[side].found = None;
            }
        }
        (self.results.hovered, self.results.reselect, self.results.probed) = Default::default();
        self.check_params();
        self.refresh_listed();
        if let Some(layout) = layout {
            self.lay_out(layout);
        }
        if let Some(place) = probe {
            let panels = self.document.panels;
            self.probe_place(Side::A, place);
            // A probe opens its panel.
            self.document.panels = panels;
        }
        self.settle_ranges();
        self.history.clear();
    }

    pub fn show_document(&mut self, document: Document, reselect: Reselect) {
        for side in Side::BOTH {
            if document.comparisons[side] != self.document.comparisons[side] {
                self.results.slots[side].comparison = ComparisonResults::default();
            }
        }
        if document.probe != self.document.probe {
            self.results.probed = ProbeResults::default();
        }
        self.document = document;
        match reselect {
            Reselect::Feature(feature) => self.results.reselect = feature,
            Reselect::Match(of_match) => self.results.pair.reselect = of_match,
        }
        self.keep_methods_arranged();
        self.check_params();
    }

    fn read_named(&mut self, engine: &Engine) -> Option<Effect> {
        self.read_trajectories(engine);
        match self.document.dataset.clone() {
            Some(DatasetChoice { source, folder, .. }) => {
                self.look_at_dataset(source, folder, self.document.calibration.clone(), engine);
                None
            }
            None => Some(self.close_dataset()),
        }
    }

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
        self.history.close_step(&self.document, goes_on);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::document::side::Side;
    use crate::app::results::pair::tests::pair;
    use crate::detector::SlopeChoice;
    use crate::detector::SlopeGrid;
    use crate::matching::MatchParams;
    use crate::teach::Workspace;

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
