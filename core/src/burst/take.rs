//! Part of a long recording: of a bag, a film or a stack of any length the frames of one burst are taken, and nothing
//! else of it is kept.

use super::options::{Limits, OpenOptions};
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// Frames `start..end` of a burst (`end` excluded), as `--frames A..B` and `--take A..B` name them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameRange {
    /// First frame, counted from 0.
    pub start: usize,
    /// One past the last frame.
    pub end: usize,
}

impl FrameRange {
    /// Checks that the range holds a frame; otherwise the fault and its remedy.
    pub(crate) fn check(&self) -> Result<(), (String, String)> {
        if self.start < self.end {
            return Ok(());
        }
        Err((format!("{self} holds no frame"), "give A..B with A below B".to_owned()))
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.start, self.end)
    }
}

impl FromStr for FrameRange {
    type Err = String;

    /// Reads `A..B`, the frames A … B−1.
    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || format!("'{text}' is not A..B, such as 0..10 for the first ten frames");
        let (start, end) = text.split_once("..").ok_or_else(bad)?;
        Ok(Self { start: start.trim().parse().map_err(|_| bad())?, end: end.trim().parse().map_err(|_| bad())? })
    }
}

impl OpenOptions {
    /// These options for looking through a whole file, of which a part may be taken.
    pub(super) fn of_whole(&self) -> Self {
        let limits = if self.take.is_some() { self.limits.of_whole() } else { self.limits };
        Self { limits, ..self.clone() }
    }

    /// The part of `all` frames of the file or folder `path` that is to be taken; their size (columns, rows) is needed
    /// for the limits.
    ///
    /// # Errors
    /// It has no such frames, or they are too many.
    pub(super) fn taken<T>(
        &self,
        path: &Path,
        mut all: Vec<T>,
        (width, height): (usize, usize),
    ) -> Result<Vec<T>, Error> {
        let Some(range) = self.take else { return Ok(all) };
        let count = all.len();
        let problem = match range.check() {
            Err((problem, _)) => problem,
            Ok(()) if range.end > count => format!("{range} reaches beyond the {count} frames of {}", path.display()),
            Ok(()) => {
                all.truncate(range.end);
                all.drain(..range.start);
                self.limits.check_burst(path, all.len() as u64, width as u64, height as u64)?;
                return Ok(all);
            }
        };
        Err(Error::param("take", problem, format!("give A..B with 0 ≤ A < B ≤ {count}")))
    }

    /// Number of the first frame that is taken.
    pub(super) fn first_taken(&self) -> usize {
        self.take.map_or(0, |range| range.start)
    }
}

impl Limits {
    /// Limits for a file of any length that is looked through, not kept.
    fn of_whole(self) -> Self {
        Self { max_frames: usize::MAX, ..self }
    }
}
