//! The window's part of long work: what it does beyond the project when bursts are opened, sessions restored, datasets
//! worked on, lessons gone through and files written. What the project itself asks of the engine is in
//! [`crate::app::project`].

#[cfg(feature = "colmap")]
mod colmap;
pub(super) mod dataset;
mod dataset_answers;
mod lesson;
pub(super) mod opening;
pub(super) mod panes;
mod recovery;
pub(super) mod writing;
