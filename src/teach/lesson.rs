//! A lesson: steps that explain, one after the other.

use super::goal::Goal;
use super::part::Part;
use super::state::State;

/// A lesson.
#[derive(Debug, Clone, PartialEq)]
pub struct Lesson {
    /// What names it on the command line: its file's name without the ending.
    pub name: String,
    /// Its title.
    pub title: String,
    /// What one learns in it, in a sentence.
    pub about: String,
    /// Its steps; at least one.
    pub steps: Vec<Step>,
}

/// One step.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Its title.
    pub title: String,
    /// What it explains, in CommonMark. Links to `word:NAME` lead to the glossary.
    pub caption: String,
    /// What is pointed at.
    pub highlight: Vec<Part>,
    /// What is to be tried.
    pub task: Option<Task>,
    /// What is set up before.
    pub state: State,
}

/// Something to try.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// What to do, in CommonMark.
    pub text: String,
    /// When it is done.
    pub goal: Goal,
}
