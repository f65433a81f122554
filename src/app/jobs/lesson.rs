//! Opening, going through and leaving a lesson.

use crate::app::lesson::state::Kept;
use crate::app::lesson::{OpenLesson, Wish, looking, setting_up};
use crate::app::parts;
use crate::app::project::Model;
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::app::window::BurstscopeApp;
use crate::requests::{BurstSource, OpenBurst};
use crate::teach::{Lesson, lessons_at};
use std::path::Path;
use std::sync::Arc;

impl BurstscopeApp {
    /// Opens a lesson at the step where it was left last. The present model is put aside until the lesson is left.
    pub fn start_lesson(&mut self, lesson: Arc<Lesson>) {
        self.leave_lesson();
        self.lessons.list_is_open = false;
        let opening = self.model.slots.a.opening.pending().map(|request| request.source.clone());
        let mut model = Model::default();
        (model.theme, model.figure, model.in_lesson) = (self.model.theme, self.model.figure, true);
        self.model.slots.a.opening.forget();
        let mut kept = std::mem::replace(&mut self.model, model);
        hand_over(&mut kept, &mut self.model);
        self.model.messages.forget_note();
        self.forget_what_is_drawn();
        let progress = self.lessons.progress_in(&lesson);
        self.lessons.open = Some(OpenLesson {
            lesson,
            step: progress.step,
            done: progress.done,
            is_ready: false,
            selects: false,
            opens: Vec::new(),
            snr: Default::default(),
            kept: Box::new(Kept { model: kept, opening }),
        });
        self.begin_step();
    }

    /// Leaves the lesson, if one is open, and restores the model that was open before it.
    pub fn leave_lesson(&mut self) {
        self.lessons.remember();
        let Some(open) = self.lessons.open.take() else { return };
        let Kept { model, opening } = *open.kept;
        let mut lesson = std::mem::replace(&mut self.model, model);
        hand_over(&mut lesson, &mut self.model);
        self.model.messages.forget_note();
        self.model.theme = lesson.theme;
        self.forget_what_is_drawn();
        if let Some(source) = opening {
            self.open(source);
        }
    }

    /// Opens the lessons of a folder or a file, or shows the error in them.
    pub fn open_lessons(&mut self, path: &Path) {
        const WHAT: &str = "Open lessons";
        match lessons_at(path) {
            Ok(lessons) => {
                self.model.messages.resolved(WHAT);
                self.lessons.add(lessons);
                self.lessons.list_is_open = true;
            }
            Err(errors) => {
                let text: Vec<String> = errors.iter().map(ToString::to_string).collect();
                self.model.messages.error(WHAT, text.join("\n"));
            }
        }
    }

    /// Applies `wish` to the open lesson, sets its step up once its bursts are open, and checks its tasks.
    pub(in crate::app) fn go_on_with_lesson(&mut self, ctx: &egui::Context, wish: Option<Wish>) {
        match wish {
            Some(Wish::Leave) => self.leave_lesson(),
            Some(Wish::Step(step)) => {
                if let Some(open) = &mut self.lessons.open {
                    open.step = step.min(open.lesson.steps.len() - 1);
                }
                self.begin_step();
            }
            Some(Wish::Again) => self.begin_step(),
            None => {}
        }
        self.leave_for_what_was_opened();
        let Some(open) = &mut self.lessons.open else {
            parts::want(ctx, &[]);
            return;
        };
        let is_other = self.model.slots.a.burst.as_ref().is_some_and(|burst| burst.source != open.step().state.burst());
        if open.is_ready && is_other {
            // A burst that was requested for another step has been opened.
            self.begin_step();
        } else if open.is_ready {
            select_first(open, &mut self.model);
            let is_met = open.step().task.as_ref().is_some_and(|task| task.goal.is_met(&looking::seen(&self.model)));
            if is_met && open.done.insert(open.step) {
                self.lessons.remember();
            }
        } else {
            self.set_step_up();
        }
        let highlight = self.lessons.open.as_ref().map_or(&[][..], |open| &open.step().highlight);
        parts::want(ctx, highlight);
    }

    /// Whether the open lesson waits for nothing.
    pub(in crate::app) fn lesson_is_settled(&self) -> bool {
        let failed = !self.model.messages.errors().is_empty();
        self.lessons.open.as_ref().is_none_or(|open| open.is_ready || failed)
    }

    /// Begins the open step: opens its bursts where others are open.
    fn begin_step(&mut self) {
        let Some(open) = &mut self.lessons.open else { return };
        // The burst that another step requested is not needed any more.
        self.model.slots.a.opening.forget();
        let (first, second) = (open.step().state.burst(), open.step().state.second.clone());
        (open.is_ready, open.opens) = (false, Vec::new());
        open.snr.clear();
        let mut wanted = Vec::new();
        for (side, source) in [(Side::A, Some(first)), (Side::B, second)] {
            let is_open = self.model.burst_of(side).is_some_and(|burst| Some(&burst.source) == source.as_ref());
            if let Some(source) = source.filter(|_| !is_open) {
                wanted.push((side, source));
            }
        }
        open.opens = wanted.iter().map(|(_, source)| source.clone()).collect();
        for (side, source) in wanted {
            match (side, self.burst_that_is_kept(&source)) {
                (Side::A, Some(burst)) => self.model.take_burst(burst),
                (Side::B, Some(burst)) => self.model.take_second_burst(burst),
                (side, None) => self.open_for(side, source),
            }
        }
        self.lessons.remember();
        self.set_step_up();
    }

    /// Finds the burst of `source` if it was open before the lesson, so that it need not be opened again.
    fn burst_that_is_kept(&self, source: &BurstSource) -> Option<OpenBurst> {
        let before = self.lessons.open.as_ref()?.before();
        let mut kept = before.slots.both().into_iter().filter_map(|slot| slot.burst.as_ref());
        kept.find(|kept| kept.source == *source).cloned()
    }

    /// Sets the open step up, if its bursts are open.
    fn set_step_up(&mut self) {
        let Some(open) = &mut self.lessons.open else { return };
        let state = open.step().state.clone();
        let is_open = |side, source: &BurstSource| self.model.burst_of(side).is_some_and(|b| b.source == *source);
        let second = state.second.as_ref().is_none_or(|source| is_open(Side::B, source));
        if !(is_open(Side::A, &state.burst()) && second) {
            return;
        }
        (open.is_ready, open.selects) = (true, state.select == Some(true));
        self.model.probe.clear();
        setting_up::set_up(&mut self.model, &state);
        self.forget_closed_panes();
        (self.cursors_set, self.history_set) = (true, true);
    }

    /// Leaves the lesson when another burst or session is being opened in it; the opening goes on in the earlier model.
    fn leave_for_what_was_opened(&mut self) {
        let Some(open) = &self.lessons.open else { return };
        let is_own = |source: &BurstSource| *source == open.step().state.burst() || open.opens.contains(source);
        let opening = self.model.slots.a.opening.pending();
        if self.restoring.session.is_some() || opening.is_some_and(|request| !is_own(&request.source)) {
            let (opening, restoring) =
                (std::mem::take(&mut self.model.slots.a.opening), std::mem::take(&mut self.restoring));
            self.leave_lesson();
            (self.model.slots.a.opening, self.restoring) = (opening, restoring);
        }
    }

    /// Clears the widgets and requests of the model that was shown until now.
    fn forget_what_is_drawn(&mut self) {
        self.widgets = Default::default();
        self.pair_panels = Default::default();
        (self.selection, self.probe, self.regions) = Default::default();
        (self.restoring, self.play) = Default::default();
        (self.cursors_set, self.history_set) = (true, true);
    }
}

/// Selects the first feature or match once there is one, if the step begins with one selected.
fn select_first(open: &mut OpenLesson, model: &mut Model) {
    if !open.selects {
        return;
    }
    if model.workspace == Workspace::Pair {
        model.pair.selected = model.pair.listed.first().copied();
    } else if model.stale().is_none() {
        model.selected = model.listed.first().copied();
    }
    open.selects = model.pair.selected.is_none() && model.selected.is_none();
}

/// Swaps datasets, trajectories, Lab, messages and figures between the models, so that their work goes on.
fn hand_over(from: &mut Model, to: &mut Model) {
    std::mem::swap(&mut from.datasets, &mut to.datasets);
    std::mem::swap(&mut from.trajectories, &mut to.trajectories);
    std::mem::swap(&mut from.lab, &mut to.lab);
    std::mem::swap(&mut from.messages, &mut to.messages);
    std::mem::swap(&mut from.figures, &mut to.figures);
}
