//! The lessons, and the one that is open: opening, going through and leaving it.

use super::snr::SnrTrace;
use super::steps;
use crate::app::document::Document;
use crate::app::project::effect::Effect;
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use crate::app::project::{Model, Project};
use crate::engine::Engine;
use crate::requests::BurstSource;
use crate::teach::{Lesson, Part, Step, built_in, lessons_at};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Progress {
    /// Step that was open last, from 0.
    pub step: usize,
    pub done: BTreeSet<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LessonAction {
    Step(usize),
    Again,
    End,
    NextLesson,
    Leave,
}

#[derive(Debug, Default)]
pub struct Lessons {
    pub open: Option<OpenLesson>,
    pub list_is_open: bool,
    pub opened: Vec<Arc<Lesson>>,
    pub progress: BTreeMap<String, Progress>,
}

#[derive(Debug)]
pub struct OpenLesson {
    pub lesson: Arc<Lesson>,
    pub step: usize,
    pub done: BTreeSet<usize>,
    /// Whether the lesson's end is shown, after its last step.
    pub is_ended: bool,
    /// Whether the step is set up; until then its bursts are being opened.
    pub is_ready: bool,
    /// Whether the first feature or match is to be selected as soon as there is one.
    selects: bool,
    opens: Vec<BurstSource>,
    pub(super) snr: SnrTrace,
    /// Project of the user, and the burst that was being opened in it.
    of_user: (Box<Project>, Option<BurstSource>),
}

impl OpenLesson {
    pub fn step(&self) -> &Step {
        &self.lesson.steps[self.step]
    }

    pub fn is_done(&self) -> bool {
        self.done.contains(&self.step)
    }

    /// Where *Next* leads; `goes_on` where another lesson follows.
    pub(super) fn onward(&self, goes_on: bool) -> LessonAction {
        match self.step + 1 == self.lesson.steps.len() {
            _ if self.is_ended && goes_on => LessonAction::NextLesson,
            _ if self.is_ended => LessonAction::Leave,
            true => LessonAction::End,
            false => LessonAction::Step(self.step + 1),
        }
    }

    /// Where *Back* leads: to the step before, and from the lesson's end to its last step.
    pub(super) fn back(&self) -> Option<LessonAction> {
        let step = if self.is_ended { Some(self.step) } else { self.step.checked_sub(1) };
        step.map(LessonAction::Step)
    }

    /// Selects the first of the listed features or matches, as soon as there is one.
    fn select_first(&mut self, [feature, of_match]: [Option<usize>; 2], document: &mut Document) {
        if !self.selects {
            return;
        }
        if document.workspace == Workspace::Pair {
            document.selected_match = of_match.or(document.selected_match);
        } else {
            document.selected = feature.or(document.selected);
        }
        self.selects = document.selected_match.is_none() && document.selected.is_none();
    }

    fn set_up(&mut self, model: &mut Model) {
        let step = self.step().clone();
        let state = &step.state;
        let is_open = |side, source: &BurstSource| model.burst_of(side).is_some_and(|b| b.source == *source);
        let second = state.second.as_ref().is_none_or(|source| is_open(Side::B, source));
        if !(is_open(Side::A, &state.burst()) && second) {
            return;
        }
        (self.is_ready, self.selects) = (true, state.select == Some(true));
        steps::set_up(model, &step);
    }
}

impl Lessons {
    pub fn all(&self) -> impl Iterator<Item = &Arc<Lesson>> {
        self.opened.iter().chain(built_in())
    }

    pub fn add(&mut self, lessons: Vec<Lesson>) {
        for lesson in lessons {
            self.opened.retain(|other| other.name != lesson.name);
            self.opened.push(Arc::new(lesson));
        }
    }

    pub fn next_lesson(&self) -> Option<Arc<Lesson>> {
        let open = self.open.as_ref()?;
        self.all().skip_while(|lesson| lesson.name != open.lesson.name).nth(1).cloned()
    }

    pub fn progress_in(&self, lesson: &Lesson) -> Progress {
        let mut progress = self.progress.get(&lesson.name).cloned().unwrap_or_default();
        progress.step = progress.step.min(lesson.steps.len() - 1);
        progress.done.retain(|step| *step < lesson.steps.len());
        progress
    }

    /// Project of the user: the one before the open lesson, or without one `shown`.
    pub fn project_of_user<'a>(&'a self, shown: &'a Project) -> &'a Project {
        self.open.as_ref().map_or(shown, |open| &open.of_user.0)
    }

    pub fn highlighted(&self) -> &[Part] {
        self.open.as_ref().filter(|open| !open.is_ended).map_or(&[], |open| &open.step().highlight)
    }

    pub fn is_settled(&self, model: &Model) -> bool {
        let failed = !model.messages.errors().is_empty();
        self.open.as_ref().is_none_or(|open| open.is_ready || failed)
    }

    /// Opens a lesson at the step where it was left last. `model` is put aside until the lesson is left.
    #[must_use]
    pub fn start(&mut self, lesson: Arc<Lesson>, model: &mut Model, engine: &Engine) -> Effect {
        self.leave(model, engine);
        self.list_is_open = false;
        let opening = model.slots.a.opening.pending().map(|request| request.source.clone());
        let mut of_lesson = Project::default();
        (of_lesson.figure, of_lesson.in_lesson) = (model.figure, true);
        model.slots.a.opening.forget();
        let of_user = Box::new(model.show(of_lesson));
        let progress = self.progress_in(&lesson);
        self.open = Some(OpenLesson {
            lesson,
            step: progress.step,
            done: progress.done,
            is_ended: false,
            is_ready: false,
            selects: false,
            opens: Vec::new(),
            snr: SnrTrace::default(),
            of_user: (of_user, opening),
        });
        self.begin_step(model, engine);
        Effect::ForgetWidgets
    }

    pub fn leave(&mut self, model: &mut Model, engine: &Engine) -> Option<Effect> {
        self.remember();
        let (of_user, opening) = self.open.take()?.of_user;
        drop(model.show(*of_user));
        if model.poses.reading.pending().is_some() {
            // What was read meanwhile was not taken.
            model.read_trajectories(engine);
        }
        if let Some(source) = opening {
            model.open(Side::A, source, engine);
        }
        Some(Effect::ForgetWidgets)
    }

    pub fn open_at(&mut self, path: &Path, model: &mut Model) {
        const TITLE: &str = "Open lessons";
        match lessons_at(path) {
            Ok(lessons) => {
                model.messages.resolved(TITLE);
                self.add(lessons);
                self.list_is_open = true;
            }
            Err(errors) => {
                let texts: Vec<String> = errors.iter().map(ToString::to_string).collect();
                model.messages.error(TITLE, texts.join("\n"));
            }
        }
    }

    /// Applies `asked` to the open lesson, sets its step up once its bursts are open, and checks its tasks. The lesson
    /// is left when another burst is being opened in it, or a session restored (`is_restoring`).
    pub fn go_on(
        &mut self,
        asked: Option<LessonAction>,
        is_restoring: bool,
        model: &mut Model,
        engine: &Engine,
    ) -> Vec<Effect> {
        let mut effects = Vec::new();
        match asked {
            Some(LessonAction::Leave) => effects.extend(self.leave(model, engine)),
            Some(LessonAction::Step(step)) => {
                if let Some(open) = &mut self.open {
                    let spot = open.step().state.spot;
                    (open.step, open.is_ended) = (step.min(open.lesson.steps.len() - 1), false);
                    // Measurements of the same spot stay from step to step.
                    let is_same = spot == open.step().state.spot;
                    open.snr.next = None;
                    if !is_same {
                        open.snr = SnrTrace::default();
                    }
                }
                self.begin_step(model, engine);
            }
            Some(LessonAction::Again) => {
                self.open.iter_mut().for_each(|open| open.snr = SnrTrace::default());
                self.begin_step(model, engine);
            }
            Some(LessonAction::End) => self.open.iter_mut().for_each(|open| open.is_ended = true),
            Some(LessonAction::NextLesson) => {
                if let Some(next) = self.next_lesson() {
                    effects.push(self.start(next, model, engine));
                }
            }
            None => {}
        }
        effects.extend(self.leave_for_what_was_opened(is_restoring, model, engine));
        let Some(open) = &mut self.open else { return effects };
        let is_other = model.slots.a.burst.as_ref().is_some_and(|burst| burst.source != open.step().state.burst());
        if open.is_ready && is_other {
            // A burst that was requested for another step has been opened.
            self.begin_step(model, engine);
        } else if open.is_ready {
            let feature = model.listed.first().copied().filter(|_| model.stale().is_none());
            open.select_first([feature, model.pair.listed.first().copied()], &mut model.document);
            let is_met = open.step().task.as_ref().is_some_and(|task| task.goal.is_met(&steps::seen(model)));
            if is_met && open.done.insert(open.step) {
                self.remember();
            }
        } else {
            open.set_up(model);
        }
        effects
    }

    fn begin_step(&mut self, model: &mut Model, engine: &Engine) {
        let Some(open) = &mut self.open else { return };
        // The burst that another step requested is not needed any more.
        model.slots.a.opening.forget();
        // Which of two bursts was opened last says nothing.
        model.messages.forget_note();
        let (first, second) = (open.step().state.burst(), open.step().state.second.clone());
        (open.is_ready, open.opens) = (false, Vec::new());
        for (side, source) in [(Side::A, Some(first)), (Side::B, second)] {
            let is_open = model.burst_of(side).is_some_and(|burst| Some(&burst.source) == source.as_ref());
            let Some(source) = source.filter(|_| !is_open) else { continue };
            open.opens.push(source.clone());
            // A burst that was open before the lesson need not be opened again.
            let mut kept = open.of_user.0.slots.both().into_iter().filter_map(|slot| slot.burst.as_ref());
            match (side, kept.find(|burst| burst.source == source).cloned()) {
                (Side::A, Some(burst)) => model.take_burst(burst),
                (Side::B, Some(burst)) => model.take_second_burst(burst),
                (side, None) => {
                    model.open(side, source, engine);
                }
            }
        }
        match open.step().state.cameras {
            Some(true) if model.poses.is_empty() => model.show_demo_cameras(engine),
            Some(true) => {}
            _ => model.close_trajectories(),
        }
        open.set_up(model);
        self.remember();
    }

    /// Leaves the lesson when another burst or session is being opened in it; the opening goes on in the earlier
    /// project.
    fn leave_for_what_was_opened(&mut self, is_restoring: bool, model: &mut Model, engine: &Engine) -> Option<Effect> {
        let open = self.open.as_ref()?;
        let is_own = |source: &BurstSource| *source == open.step().state.burst() || open.opens.contains(source);
        let opening = model.slots.a.opening.pending();
        if !is_restoring && opening.is_none_or(|request| is_own(&request.source)) {
            return None;
        }
        let opening = std::mem::take(&mut model.slots.a.opening);
        let effect = self.leave(model, engine);
        model.slots.a.opening = opening;
        effect
    }

    fn remember(&mut self) {
        if let Some(open) = &self.open {
            // A finished lesson begins anew.
            let step = if open.is_ended { 0 } else { open.step };
            let progress = Progress { step, done: open.done.clone() };
            self.progress.insert(open.lesson.name.clone(), progress);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_remembered_of_a_longer_lesson_stays_within_this_one() {
        let mut lessons = Lessons::default();
        let lesson = built_in()[0].clone();
        assert_eq!(lessons.progress_in(&lesson), Progress::default());
        lessons.progress.insert(lesson.name.clone(), Progress { step: 99, done: [1, 77].into() });
        let progress = lessons.progress_in(&lesson);
        assert_eq!((progress.step, progress.done), (lesson.steps.len() - 1, [1].into()));
    }

    #[test]
    fn lessons_that_are_opened_again_are_there_once() {
        let mut lessons = Lessons::default();
        let lesson = Lesson { name: "mine".to_owned(), ..(*built_in()[0]).clone() };
        lessons.add(vec![lesson.clone()]);
        lessons.add(vec![Lesson { title: "New".to_owned(), ..lesson }]);
        assert_eq!(lessons.all().count(), built_in().len() + 1);
        assert_eq!(lessons.opened[0].title, "New");
    }
}
