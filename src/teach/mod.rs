//! What the program teaches: lessons over the live window, and the words that it uses.
//!
//! Both are data that a teacher can write without knowing the program: a [`Lesson`] is a TOML file whose steps say what
//! is set up, what is pointed at, what is explained (in CommonMark) and what is to be tried; the [`glossary`] explains
//! every word of the window in a sentence or two. Here they are read and checked; the window shows them.

mod built_in;
pub mod glossary;
mod goal;
mod lesson;
mod part;
mod reading;
mod state;
mod values;

pub use built_in::{built_in, built_in_names};
pub use goal::{Goal, Holds, Near, ParamName, Wanted};
pub use lesson::{Lesson, Step, Task};
pub use part::Part;
pub use reading::{LessonError, lessons_at};
pub use state::{Layout, Place, Shown, Spot, State, Tab};
pub use values::Between;
