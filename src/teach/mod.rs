//! Teaching material, which a teacher can write without knowing the program: a [`Lesson`] is a TOML file whose steps
//! say what is set up, highlighted, explained (in CommonMark) and to be tried; the [`glossary`] explains every term of
//! the window. This module reads and checks them, and writes a lesson as a sheet for a class.

pub mod glossary;
mod goal;
mod lesson;
mod part;
mod sheet;
mod state;
mod values;

pub use goal::{Goal, GoalValue, ParamName};
pub use lesson::{Lesson, Question, Step, Task, built_in, built_in_names, lessons_at};
pub use part::Part;
pub use sheet::sheet;
pub use state::{BottomTab, InView, Layout, Spot, State, Workspace};
pub use values::{Between, Near};
