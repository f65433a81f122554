//! The only place that asks the engine, and takes its answers into the project.
//!
//! One file for each subject: a [`burst`] that is opened and searched, the [`pair`] of two, [`compare`]d methods, the
//! pictures of [`panes`], the [`probe`], a [`dataset`], and files that are [written](writing).

pub(super) mod against;
pub(super) mod burst;
#[cfg(feature = "colmap")]
mod colmap;
pub(super) mod compare;
pub(super) mod dataset;
pub(super) mod explain;
pub(super) mod losses;
pub(super) mod pair;
pub(super) mod panes;
pub(super) mod probe;
pub(super) mod writing;
