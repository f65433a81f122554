//! Lessons over the live window.
//!
//! A lesson (see [`crate::teach`]) takes the window over: the previous content is kept whole and put back when the
//! lesson is left. Each step sets the window up, highlights a part of it, explains it in a panel on the right, and
//! detects when its task is done.

mod caption;
mod highlight;
mod list;
pub(super) mod looking;
mod panel;
pub(super) mod setting_up;
mod snr;
pub(super) mod state;

pub use caption::Captions;
pub use highlight::highlights_ui;
pub use list::{Chosen, list_ui, rows_ui};
pub use panel::lesson_ui;
pub use state::{Lessons, OpenLesson, Progress, Wish};
