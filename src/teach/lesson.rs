//! Lessons: explaining steps, in order.

use super::goal::Goal;
use super::part::Part;
use super::state::State;

/// A lesson.
#[derive(Debug, Clone, PartialEq)]
pub struct Lesson {
    /// Name on the command line: the file's name without its ending.
    pub name: String,
    /// Title of the lesson.
    pub title: String,
    /// Learning goal, in a sentence.
    pub about: String,
    /// Steps; at least one.
    pub steps: Vec<Step>,
}

/// One step.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Title of the step.
    pub title: String,
    /// Explanation, in CommonMark. Links to `word:NAME` lead to the glossary.
    pub caption: String,
    /// Parts of the window to highlight.
    pub highlight: Vec<Part>,
    /// Task, if the step has one.
    pub task: Option<Task>,
    /// State of the window to set up first.
    pub state: State,
}

/// Task of a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Instruction, in CommonMark.
    pub text: String,
    /// Condition under which the task is done.
    pub goal: Goal,
}
