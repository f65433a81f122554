//! The record of everything that goes wrong: a message names the file or parameter, the problem and a remedy.

use crate::monitor::Cancelled;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// Reason why there is no result. What was open, written or finished before stays as it is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Error {
    /// Kind, for callers that act on it.
    pub kind: ErrorKind,
    /// File, folder or parameter; empty where there is none, or where the problem or the remedy names several.
    pub subject: String,
    /// The problem, as a sentence without its end.
    pub problem: String,
    /// The remedy; empty where the problem says it.
    pub remedy: String,
}

/// Result of what can go wrong; with an [`Error`], unless another type is given.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Kinds of [`Error`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The work was cancelled.
    Cancelled,
    /// A parameter, or a combination, makes no sense. The subject is the one to change, named as on the command line.
    Parameter,
    /// A request to open that makes no sense: nothing, files with folders, a stack among frames, a level out of range.
    Request,
    /// There is no such file or folder, or nothing in it.
    NotFound,
    /// The system could not read it, or ended the process that decodes it.
    System,
    /// The system could not write it.
    Unwritten,
    /// The file is empty, truncated or damaged.
    Damaged,
    /// The file's kind or its content cannot be opened.
    Unsupported,
    /// A case, a truth, a table or a lesson is not what it should be, or does not belong to the burst.
    Content,
    /// Frames do not fit one another, or the bias or flat frame does not fit them.
    Mismatch,
    /// Larger than the limits.
    TooLarge,
    /// Within the limits, but more memory than the system gives.
    NoMemory,
    /// The file has no header, and its shape was not said or does not fill it.
    NoShape,
    /// One burst was expected and there are several.
    SeveralBursts,
    /// A picture lies beside the bursts of a dataset and belongs to none.
    Stray,
    /// This is no place for an output: a folder, a device, a link, or a file that was opened.
    Refused,
    /// Files that Burstscope did not write are in the place of an output.
    InTheWay,
    /// Another process writes into the folder, or it was removed meanwhile.
    Locked,
    /// Any other reason.
    Failed,
}

impl Error {
    /// An error about nothing that has a name.
    pub fn new(kind: ErrorKind, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind, subject: String::new(), problem: problem.into(), remedy: remedy.into() }
    }

    /// Error that names a parameter, its problem and a remedy.
    pub fn param(parameter: &str, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { subject: parameter.to_owned(), ..Self::new(ErrorKind::Parameter, problem, remedy) }
    }

    /// This error, with the file or folder `path` as its subject.
    #[must_use]
    pub fn about(self, path: &Path) -> Self {
        Self { subject: one_line(&path.display().to_string()), ..self }
    }

    /// Error for a file or folder that the system does not let read.
    pub fn unread(path: &Path, reason: impl fmt::Display) -> Self {
        Self::new(ErrorKind::System, format!("cannot read this: {reason}"), "").about(path)
    }

    /// Whether the work was cancelled, rather than failed.
    pub fn is_cancelled(&self) -> bool {
        self.kind == ErrorKind::Cancelled
    }
}

impl From<Cancelled> for Error {
    fn from(cancelled: Cancelled) -> Self {
        Self::new(ErrorKind::Cancelled, cancelled.to_string(), "")
    }
}

/// The text on one line: what a file names may not begin lines of its own where it is shown.
pub fn one_line(text: &str) -> String {
    text.replace('\n', "\\u{a}")
}

/// A path ends the line, so that it can be copied; anything else begins it.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, subject, problem, remedy } = self;
        let remedy = if remedy.is_empty() { String::new() } else { format!("; {remedy}") };
        match kind {
            _ if subject.is_empty() => write!(f, "{problem}{remedy}"),
            ErrorKind::Parameter | ErrorKind::Content => write!(f, "{subject}: {problem}{remedy}"),
            _ => write!(f, "{problem}{remedy}: {subject}"),
        }
    }
}

impl std::error::Error for Error {}
