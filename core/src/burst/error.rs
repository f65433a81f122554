//! Errors of opening a burst: each message names the file, says what is wrong and gives a remedy.

use crate::monitor::Cancelled;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Reason why a burst could not be opened. Bursts that are open stay as they are.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{problem}{}{}", after("; ", .remedy), after(": ", .subject))]
pub struct OpenError {
    /// Kind, for callers that act on it.
    pub kind: OpenErrorKind,
    /// File or folder, as text; empty where there is none, or where the problem or the remedy names several.
    pub subject: String,
    /// The problem, as a sentence without its end.
    pub problem: String,
    /// The remedy; empty where the problem says it.
    pub remedy: String,
}

/// Kinds of [`OpenError`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum OpenErrorKind {
    /// Opening was cancelled.
    Cancelled,
    /// What was asked for makes no sense: nothing, files with folders, a stack among frames, a level out of its range.
    Request,
    /// There is no such file or folder.
    NotFound,
    /// The system could not read it, or ended the process that decodes it.
    System,
    /// The file is empty, truncated or damaged.
    Damaged,
    /// The file's kind or its content cannot be opened.
    Unsupported,
    /// Frames do not fit one another, or the bias or flat frame does not fit them.
    Mismatch,
    /// Larger than the [`Limits`](super::Limits).
    TooLarge,
    /// Within the limits, but more memory than the system gives.
    NoMemory,
    /// One burst was expected and there are several.
    SeveralBursts,
    /// A picture lies beside the bursts of a dataset and belongs to none.
    Stray,
}

fn after(separator: &str, text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("{separator}{text}") }
}

const COPY_AGAIN: &str = "copy it again or remove it";

impl OpenError {
    pub(crate) fn new(kind: OpenErrorKind, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind, subject: String::new(), problem: problem.into(), remedy: remedy.into() }
    }

    /// The error as one about the file or folder `path`.
    pub(crate) fn about(self, path: &Path) -> Self {
        Self { subject: path.display().to_string(), ..self }
    }

    pub(crate) fn nothing_given() -> Self {
        let problem = "nothing to open: name a folder of frames, image files, a multi-page TIFF or a .npy stack";
        Self::new(OpenErrorKind::Request, problem, "")
    }

    /// Error for a pipe or a device, whose opening would wait for ever.
    pub(super) fn not_a_file(path: &Path) -> Self {
        let problem = "this is neither a regular file nor a folder";
        Self::new(OpenErrorKind::Request, problem, "save the frames to files first").about(path)
    }

    /// Error for a picture that lies beside the bursts of a dataset.
    pub fn stray(path: &Path) -> Self {
        let problem = "this picture lies beside the bursts of a dataset and belongs to none";
        Self::new(OpenErrorKind::Stray, problem, "move it into one or away").about(path)
    }

    pub(super) fn stack_among_frames(path: &Path, frames: usize) -> Self {
        let problem =
            format!("several files are taken as the frames of one burst, but this one holds {frames} frames itself");
        Self::new(OpenErrorKind::Request, problem, "open it alone").about(path)
    }

    /// Error for a file that is empty, truncated or damaged.
    pub(super) fn damaged(path: &Path, problem: impl Into<String>) -> Self {
        Self::new(OpenErrorKind::Damaged, problem, COPY_AGAIN).about(path)
    }

    /// Error for a truncated or damaged file of the format `format`; `reason` is the decoder's message.
    pub(super) fn corrupt(path: &Path, format: &str, reason: impl std::fmt::Display) -> Self {
        Self::damaged(path, format!("this {format} file is truncated or damaged ({reason})"))
    }

    /// Error for a sound file of the format `format` whose content cannot be opened; `reason` has a remedy.
    pub(super) fn unsupported(path: &Path, format: &str, reason: impl std::fmt::Display) -> Self {
        let problem = format!("this {format} file cannot be opened: {reason}");
        Self::new(OpenErrorKind::Unsupported, problem, "").about(path)
    }

    /// Error for two frames that differ in size; each is given by its file and its size (columns, rows).
    pub(super) fn different_sizes(first: (&str, (usize, usize)), odd: (&str, (usize, usize))) -> Self {
        let said = |(path, (width, height)): (&str, (usize, usize))| format!("this one is {width}×{height}: {path}");
        let problem = format!("all frames of a burst have one size, but {}, and {}", said(first), said(odd));
        Self::new(OpenErrorKind::Mismatch, problem, "crop them alike or remove the odd one")
    }

    /// Error for value number `index`, row by row, of frame `frame` of the file, whose frames have `width` columns: not
    /// a number, infinite, or too large for 32-bit float.
    pub(super) fn not_finite(path: &Path, frame: usize, width: usize, index: usize, value: f32) -> Self {
        let problem = format!("frame {frame} has {value} at pixel ({}, {})", index % width, index / width);
        let remedy = "replace what is not a finite number, by 0 or a neighbour's value";
        Self::new(OpenErrorKind::Unsupported, problem, remedy).about(path)
    }

    /// Error for a file or folder beyond a limit; `found` and `limit` are sizes in words.
    pub(super) fn too_large(path: &Path, found: impl Into<String>, limit: impl Into<String>, remedy: &str) -> Self {
        let problem = format!("this is too large: {}, and the limit is {}", found.into(), limit.into());
        Self::new(OpenErrorKind::TooLarge, problem, remedy).about(path)
    }

    /// Error for the bias or flat frame, `frame`, at `path`, which does not fit the frames.
    pub(super) fn calibration(path: &Path, frame: &str, reason: &str) -> Self {
        let problem = format!("the {frame} frame does not fit the frames: {reason}");
        Self::new(OpenErrorKind::Mismatch, problem, "").about(path)
    }

    /// Error for a file or folder that the system could not read.
    pub(crate) fn unread(path: &Path, reason: impl std::fmt::Display) -> Self {
        Self::new(OpenErrorKind::System, format!("cannot read this: {reason}"), "").about(path)
    }

    pub(super) fn from_io(path: &Path, error: &std::io::Error) -> Self {
        match error.kind() {
            std::io::ErrorKind::NotFound => {
                let problem = "there is no such file or folder";
                Self::new(OpenErrorKind::NotFound, problem, "check the spelling").about(path)
            }
            _ => Self::unread(path, error),
        }
    }

    /// Error for a decoder's failed read of a file of the format `format`: damage where the file ends early or the data
    /// is invalid, the system's error otherwise.
    pub(super) fn from_read(path: &Path, format: &str, error: &std::io::Error) -> Self {
        use std::io::ErrorKind::{InvalidData, InvalidInput, Other, UnexpectedEof};
        match error.kind() {
            UnexpectedEof => Self::corrupt(path, format, "it ends too early"),
            InvalidData | InvalidInput | Other => Self::corrupt(path, format, error),
            _ => Self::from_io(path, error),
        }
    }

    /// Whether opening was cancelled, rather than failed.
    pub fn is_cancelled(&self) -> bool {
        self.kind == OpenErrorKind::Cancelled
    }
}

impl From<Cancelled> for OpenError {
    fn from(cancelled: Cancelled) -> Self {
        Self::new(OpenErrorKind::Cancelled, cancelled.to_string(), "")
    }
}
