//! Teaching material: lessons over the live window, and the glossary.
//!
//! Both are data that a teacher can write without knowing the program: a [`Lesson`] is a TOML file whose steps say what
//! is set up, what is highlighted, what is explained (in CommonMark) and what is to be tried; the [`glossary`] explains
//! every term of the window in a sentence or two. This module reads and checks them; the window shows them.

pub mod glossary;
mod goal;
mod lesson;
mod part;
mod state;
mod values;

pub use goal::{Goal, Holds, Near, ParamName, Wanted};
pub use lesson::{Lesson, LessonError, Step, Task, built_in, built_in_names, lessons_at};
pub use part::Part;
pub use state::{BottomTab, InView, Layout, Spot, State, Workspace};
pub use values::Between;
