//! The real program, run as users run it: its output, its files, its exit codes.

#[path = "../../core/tests/common/damage.rs"]
mod damage;
#[path = "../../core/tests/common/shared.rs"]
mod shared;

mod calibrating;
mod detecting;
mod drawing;
#[cfg(unix)]
mod ending_well;
mod figure_files;
#[cfg(unix)]
mod hostile;
mod house;
mod inspecting;
mod interrupting;
#[cfg(feature = "colmap")]
mod killed;
mod lesson_texts;
mod lessons_and_sessions;
mod making;
#[cfg(unix)]
mod marks;
mod matching;
mod measurements;
mod measuring;
mod memory;
#[cfg(unix)]
mod overwriting;
mod own_defaults;
#[cfg(feature = "colmap")]
mod pairs;
mod real;
mod reconstructing;
mod recovering;
mod remaking;
mod reporting;
mod requests;
mod samples;
mod support;
mod teaching;
mod trajectories;
#[cfg(feature = "raw")]
mod worker;
mod written_files;
