//! The only place that asks the engine, and takes its answers into the project.
//!
//! One file for each subject: a [`burst`] that is opened and searched, the [`pair`] of two, [`compare`]d methods, the
//! pictures of [`panes`], the [`probe`], a [`dataset`], [`trajectories`], studies of the [`lab`], the
//! [figures](figures) of the paper, a [`lesson`] that takes the window over, files that are [written](writing), and the
//! session that is kept for the [`recovery`] after a crash.

pub(super) mod against;
pub(super) mod burst;
pub(super) mod coherence;
#[cfg(feature = "colmap")]
mod colmap;
pub(super) mod compare;
pub(super) mod dataset;
mod dataset_answers;
pub(super) mod explain;
mod figures;
pub(super) mod lab;
mod lesson;
pub(super) mod losses;
pub(super) mod pair;
pub(super) mod panes;
pub(super) mod probe;
mod recovery;
mod trajectories;
pub(super) mod writing;
