//! Changes beyond the project: values that its parts return, and that the window applies.

use super::purpose::Purpose;
use super::side::Side;
use crate::dataset::DatasetSource;
use crate::engine::Ended;
use crate::requests::{BurstSource, OpenRequest};
use crate::teach::Lesson;
use std::path::PathBuf;
use std::sync::Arc;

/// Change beyond the part of the window that returns it.
#[derive(Debug)]
pub enum Effect {
    /// Opening a burst for a side ended, with or without success; a session may have waited for it.
    Opened(Side, Ended<OpenRequest>),
    /// A burst goes to the top of the recent list.
    Recent(BurstSource),
    /// A dataset goes to the top of the recent list.
    RecentDataset(DatasetSource),
    /// The user chooses which of several bursts is opened for a side.
    Choose(Side, Vec<BurstSource>),
    /// The user is asked how a sequence is cut into bursts.
    Cut {
        /// Files of the sequence.
        paths: Vec<PathBuf>,
        /// Number of its frames.
        frames: usize,
    },
    /// The user is asked whether features of other parameters may be replaced.
    ReplaceFeatures,
    /// The thumbnails are of another dataset, or were made with another calibration.
    ForgetThumbnails,
    /// The user is asked for files, or for a place to write to.
    Ask(Purpose),
    /// Files are used for a purpose.
    UseFiles(Purpose, Vec<PathBuf>),
    /// A file is written. The user agreed that it may replace one that is there.
    Write(Purpose, PathBuf),
    /// A lesson begins.
    StartLesson(Arc<Lesson>),
    /// Another project is on show: the state of all widgets belongs to the one before.
    ForgetWidgets,
}
