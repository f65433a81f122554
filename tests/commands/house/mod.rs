//! Checks the code's structure: which module may use which, read from the code itself, and the library's dependencies.
//! Cargo ensures that the library does not use the program.

mod circles;
mod counts;
mod dependencies;
pub mod documents;
mod floors;
mod notices;
mod opened_files;
mod reading;
mod rooms;
mod screenshots;
mod walls;
