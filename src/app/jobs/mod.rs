//! The window's part of background work: opening bursts, restoring sessions, working on datasets, going through
//! lessons, writing files. The project's own requests to the engine are in [`crate::app::project`].

#[cfg(feature = "colmap")]
mod colmap;
pub(super) mod dataset;
mod dataset_answers;
mod lesson;
pub(super) mod opening;
pub(super) mod panes;
mod recovery;
pub(super) mod writing;
