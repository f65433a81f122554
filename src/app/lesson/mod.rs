//! Lessons (see [`crate::teach`]) over the live window, whose content is kept whole and put back when the lesson is
//! left. Each step sets the window up, highlights a part, explains it in a panel, and detects when its task is done.

mod panel;
mod snr;
mod state;
mod steps;

pub use panel::{Chosen, highlights_ui, lesson_ui, list_ui, rings_ui, rows_ui, take_hall_keys};
pub use state::{LessonAction, Lessons, OpenLesson, Progress};
