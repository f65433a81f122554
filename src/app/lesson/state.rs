//! State of the lessons in the window.

use super::snr::SnrTrace;
use crate::app::project::Model;
use crate::requests::BurstSource;
use crate::teach::{Lesson, Step, built_in};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Progress of the user in a lesson.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Progress {
    /// Step that was open last, from 0.
    pub step: usize,
    /// Steps whose task was done.
    pub done: BTreeSet<usize>,
}

/// Request of the user to the open lesson.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// Go to a step, from 0.
    Step(usize),
    /// Set this step up again.
    Again,
    /// Leave the lesson.
    Leave,
}

/// State of the lessons in the window.
#[derive(Debug, Default)]
pub struct Lessons {
    /// The lesson that is open.
    pub open: Option<OpenLesson>,
    /// Whether the list of lessons is open.
    pub list_is_open: bool,
    /// Lessons that were opened from files.
    pub opened: Vec<Arc<Lesson>>,
    /// Progress in each lesson, by the lesson's name.
    pub progress: BTreeMap<String, Progress>,
}

/// State before the lesson, to be restored.
#[derive(Debug)]
pub(in crate::app) struct Kept {
    /// Project.
    pub model: Model,
    /// Burst that was being opened.
    pub opening: Option<BurstSource>,
}

/// Open lesson, with its state.
#[derive(Debug)]
pub struct OpenLesson {
    /// The lesson.
    pub lesson: Arc<Lesson>,
    /// The step, from 0.
    pub step: usize,
    /// The steps whose task was done.
    pub done: BTreeSet<usize>,
    /// Whether the step is set up; until then its bursts are being opened.
    pub is_ready: bool,
    /// Whether the first feature or match is to be selected as soon as there is one.
    pub(in crate::app) selects: bool,
    /// Bursts that the step opens itself.
    pub(in crate::app) opens: Vec<BurstSource>,
    /// Signal-to-noise ratios measured so far.
    pub(in crate::app) snr: SnrTrace,
    pub(in crate::app) kept: Box<Kept>,
}

impl OpenLesson {
    /// Present step.
    pub fn step(&self) -> &Step {
        &self.lesson.steps[self.step]
    }

    /// Whether the task of the present step was done.
    pub fn is_done(&self) -> bool {
        self.done.contains(&self.step)
    }

    /// Project as it was before the lesson.
    pub fn before(&self) -> &Model {
        &self.kept.model
    }
}

impl Lessons {
    /// All lessons: opened ones, then built-in ones.
    pub fn all(&self) -> impl Iterator<Item = &Arc<Lesson>> {
        self.opened.iter().chain(built_in())
    }

    /// Adds lessons opened from files; each replaces an opened one of its name.
    pub fn add(&mut self, lessons: Vec<Lesson>) {
        for lesson in lessons {
            self.opened.retain(|other| other.name != lesson.name);
            self.opened.push(Arc::new(lesson));
        }
    }

    /// Progress in `lesson`, limited to the steps that it has.
    pub fn progress_in(&self, lesson: &Lesson) -> Progress {
        let mut progress = self.progress.get(&lesson.name).cloned().unwrap_or_default();
        progress.step = progress.step.min(lesson.steps.len() - 1);
        progress.done.retain(|step| *step < lesson.steps.len());
        progress
    }

    /// Stores the progress in the open lesson.
    pub(in crate::app) fn remember(&mut self) {
        if let Some(open) = &self.open {
            let progress = Progress { step: open.step, done: open.done.clone() };
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
