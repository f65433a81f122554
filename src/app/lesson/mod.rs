//! Lessons over the live window.
//!
//! A lesson (see [`crate::teach`]) takes the window over: what was open is kept aside as it is, whole, and put back
//! when the lesson is left. Each of its steps sets the window up, points at a part of it, explains in a panel on the
//! right, and notices when what is to be tried was done.

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
