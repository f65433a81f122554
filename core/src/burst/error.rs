//! Errors of opening a burst: each message names the file, says what is wrong and gives a remedy.

use crate::error::{Error, ErrorKind};
use std::path::Path;

impl Error {
    pub(crate) fn nothing_given() -> Self {
        let problem = "nothing to open: name a folder of frames, image files, a multi-page TIFF or a .npy stack";
        Self::new(ErrorKind::Request, problem, "")
    }

    pub(super) fn not_a_file(path: &Path) -> Self {
        let problem = "this is neither a regular file nor a folder";
        Self::new(ErrorKind::Request, problem, "save the frames to files first").about(path)
    }

    /// Error for a picture that lies beside the bursts of a dataset.
    pub fn stray(path: &Path) -> Self {
        let problem = "this picture lies beside the bursts of a dataset and belongs to none";
        Self::new(ErrorKind::Stray, problem, "move it into one or away").about(path)
    }

    pub(super) fn stack_among_frames(path: &Path, frames: usize) -> Self {
        // A quick look stops at the second frame, so 2 stands for several.
        let held = if frames == 2 { "several".to_owned() } else { frames.to_string() };
        let problem =
            format!("several files are taken as the frames of one burst, but this one holds {held} frames itself");
        Self::new(ErrorKind::Request, problem, "open it alone").about(path)
    }

    pub(super) fn views_of_stack(path: &Path, frames: usize) -> Self {
        let problem = format!("views: this file holds {frames} pictures, and all views are to be in one");
        Self::new(ErrorKind::Mismatch, problem, "give ROWSxCOLUMNS alone where each is a view").about(path)
    }

    pub(super) fn damaged(path: &Path, problem: impl Into<String>) -> Self {
        Self::new(ErrorKind::Damaged, problem, "copy it again or remove it").about(path)
    }

    /// Error for a truncated or damaged file of the format `format`; `reason` is the decoder's message.
    pub(super) fn corrupt(path: &Path, format: &str, reason: impl std::fmt::Display) -> Self {
        Self::damaged(path, format!("this {format} file is truncated or damaged ({reason})"))
    }

    /// Error for a sound file of the format `format` whose content cannot be opened; `reason` has a remedy.
    pub(super) fn unsupported(path: &Path, format: &str, reason: impl std::fmt::Display) -> Self {
        let problem = format!("this {format} file cannot be opened: {reason}");
        Self::new(ErrorKind::Unsupported, problem, "").about(path)
    }

    /// Error for two frames that differ in size; each is given by its file and its size (columns, rows).
    pub(super) fn different_sizes(first: (&str, (usize, usize)), odd: (&str, (usize, usize))) -> Self {
        let said = |(path, (width, height)): (&str, (usize, usize))| format!("this one is {width}×{height}: {path}");
        let problem = format!("all frames of a burst have one size, but {}, and {}", said(first), said(odd));
        Self::new(ErrorKind::Mismatch, problem, "crop them alike or remove the odd one")
    }

    /// Error for value number `index`, row by row, of a frame of `width` columns: infinite, or too large.
    pub(super) fn not_finite(path: &Path, frame: usize, width: usize, index: usize, value: f32) -> Self {
        let (u, v) = (index % width, index / width);
        let problem = format!("frame {frame} has a value beyond 3.4e38 ({value}) at pixel ({u}, {v})");
        let remedy = "write NaN for what has no value, which is masked";
        Self::new(ErrorKind::Unsupported, problem, remedy).about(path)
    }

    /// Error for a file or folder beyond a limit; `found` and `limit` are sizes in words.
    pub(super) fn too_large(path: &Path, found: impl Into<String>, limit: impl Into<String>, remedy: &str) -> Self {
        let problem = format!("this is too large: {}, and the limit is {}", found.into(), limit.into());
        Self::new(ErrorKind::TooLarge, problem, remedy).about(path)
    }

    pub(super) fn calibration(path: &Path, frame: &str, reason: &str) -> Self {
        let problem = format!("the {frame} frame does not fit the frames: {reason}");
        Self::new(ErrorKind::Mismatch, problem, "").about(path)
    }

    pub(super) fn from_io(path: &Path, error: &std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::NotFound {
            let problem = "there is no such file or folder";
            return Self::new(ErrorKind::NotFound, problem, "check the spelling").about(path);
        }
        Self::unread(path, error)
    }

    /// Error for a decoder's failed read: damage where data ends early or is invalid, the system's error otherwise.
    pub(super) fn from_read(path: &Path, format: &str, error: &std::io::Error) -> Self {
        use std::io::ErrorKind::{InvalidData, InvalidInput, Other, UnexpectedEof};
        match error.kind() {
            UnexpectedEof => Self::corrupt(path, format, "it ends too early"),
            InvalidData | InvalidInput | Other => Self::corrupt(path, format, error),
            _ => Self::from_io(path, error),
        }
    }
}
