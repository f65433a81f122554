//! The lessons, and the one that is open: opening, going through and leaving it.

use super::snr::SnrTrace;
use super::steps;
use crate::app::document::{Document, Panels, Side, Sides, Staged};
use crate::app::results::Read;
use crate::requests::BurstSource;
use crate::teach::{Lesson, Part, Step, built_in, lessons_at};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
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
    pub(super) snr: SnrTrace,
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

    fn bursts(&self) -> Sides<Option<BurstSource>> {
        let state = &self.step().state;
        Sides { a: Some(state.burst()), b: state.second.clone() }
    }

    /// The step as it begins, once its bursts are open.
    fn set_up(&mut self, model: Read<'_>) -> Option<Staged> {
        let bursts = self.bursts();
        let is_open = |side| {
            let of = |source: &BurstSource| model.burst_of(side).is_some_and(|b| b.source == *source);
            bursts[side].as_ref().is_none_or(of)
        };
        if !Side::BOTH.into_iter().all(is_open) {
            return None;
        }
        (self.is_ready, self.selects) = (true, self.step().state.select == Some(true));
        Some(steps::begin(self.step(), model))
    }

    /// Selects the first of the listed features or matches, as soon as there is one.
    fn select_first(&mut self, model: Read<'_>) -> Option<Staged> {
        let Document { workspace, selected_match, selected, .. } = model.document;
        let listed = !model.listed().is_empty() && (workspace.shows_pair() || model.stale().is_none());
        let selects = self.selects && selected_match.is_none() && selected.is_none();
        self.selects = selects && !listed;
        (selects && listed).then_some(Staged::SelectFirst)
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

    pub fn highlighted(&self) -> &[Part] {
        self.open.as_ref().filter(|open| !open.is_ended).map_or(&[], |open| &open.step().highlight)
    }

    /// Panels with which the open lesson is shown to a hall, or as before.
    pub fn panels_for_hall(&self, now: &Panels) -> Option<Panels> {
        Some(steps::panels_of(self.open.as_ref()?.step(), !now.hall))
    }

    pub fn is_settled(&self, model: Read<'_>) -> bool {
        let failed = !model.shell.messages.errors.is_empty();
        self.open.as_ref().is_none_or(|open| open.is_ready || failed)
    }

    /// Opens a lesson at the step where it was left last. The project on show is put aside until the lesson is left.
    #[must_use]
    pub fn start(&mut self, lesson: Arc<Lesson>) -> Vec<Staged> {
        let mut staged = self.end(false);
        self.list_is_open = false;
        let Progress { step, done } = self.progress_in(&lesson);
        let snr = SnrTrace::default();
        self.open = Some(OpenLesson { lesson, step, done, is_ended: false, is_ready: false, selects: false, snr });
        staged.push(Staged::BeginLesson);
        staged.extend(self.begin_step());
        staged
    }

    /// Leaves the lesson; a burst that is being opened is opened in the project before it, if it `keeps_opening`.
    #[must_use]
    pub fn end(&mut self, keeps_opening: bool) -> Vec<Staged> {
        self.remember();
        self.open.take().map(|_| Staged::EndLesson { keeps_opening }).into_iter().collect()
    }

    /// Adds the lessons of a file or a folder to the list, and opens it.
    ///
    /// # Errors
    /// A line for each file that cannot be used, with its fault.
    pub fn open_at(&mut self, path: &std::path::Path) -> Result<(), String> {
        let texts = |errors: Vec<_>| errors.iter().map(ToString::to_string).collect::<Vec<String>>().join("\n");
        self.add(lessons_at(path).map_err(texts)?);
        self.list_is_open = true;
        Ok(())
    }

    /// Takes what is `asked` of the open lesson, sets its step up once its bursts are open, and checks its tasks. The
    /// lesson is left when another burst is being opened in it, or a session restored (`is_restoring`). Once the answer
    /// was applied there may be more to do; nothing is asked of the lesson then.
    #[must_use]
    pub fn go_on(&mut self, asked: Option<LessonAction>, is_restoring: bool, model: Read<'_>) -> Vec<Staged> {
        match asked {
            Some(LessonAction::Leave) => return self.end(false),
            Some(LessonAction::Step(step)) => {
                if let Some(open) = &mut self.open {
                    let spot = open.step().state.spot;
                    (open.step, open.is_ended) = (step.min(open.lesson.steps.len() - 1), false);
                    open.snr.next = None;
                    // Measurements of the same spot stay from step to step.
                    if spot != open.step().state.spot {
                        open.snr = SnrTrace::default();
                    }
                }
                return self.begin_step();
            }
            Some(LessonAction::Again) => {
                self.open.iter_mut().for_each(|open| open.snr = SnrTrace::default());
                return self.begin_step();
            }
            Some(LessonAction::NextLesson) => return self.next_lesson().map_or_else(Vec::new, |next| self.start(next)),
            Some(LessonAction::End) => self.open.iter_mut().for_each(|open| open.is_ended = true),
            None => {}
        }
        let Some(open) = &mut self.open else { return Vec::new() };
        let Sides { a: first, b: second } = open.bursts();
        let opening = model.results.slots.a.opening.pending().map(|request| Some(request.source.clone()));
        if is_restoring || opening.is_some_and(|source| source != first && source != second) {
            return self.end(true);
        }
        if !open.is_ready {
            return open.set_up(model).into_iter().collect();
        }
        if model.burst_of(Side::A).is_some_and(|burst| Some(&burst.source) != first.as_ref()) {
            // A burst that was requested for another step has been opened.
            return self.begin_step();
        }
        let is_met = open.step().task.as_ref().is_some_and(|task| steps::is_met(&task.goal, model));
        let selects = open.select_first(model);
        if is_met && open.done.insert(open.step) {
            self.remember();
        }
        selects.into_iter().collect()
    }

    fn begin_step(&mut self) -> Vec<Staged> {
        let Some(open) = &mut self.open else { return Vec::new() };
        open.is_ready = false;
        let staged = Staged::Open { bursts: open.bursts(), cameras: open.step().state.cameras == Some(true) };
        self.remember();
        vec![staged]
    }

    fn remember(&mut self) {
        if let Some(OpenLesson { lesson, step, done, is_ended, .. }) = &self.open {
            // A finished lesson begins anew.
            let step = if *is_ended { 0 } else { *step };
            self.progress.insert(lesson.name.clone(), Progress { step, done: done.clone() });
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
}
