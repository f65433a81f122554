//! Errors of writing files and reading them back.

use crate::files::lock::LockError;
use crate::files::write_problem;
use crate::monitor::Cancelled;
use std::path::{Path, PathBuf};

/// Reason why no new file was written. An existing file is unchanged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The work was cancelled; nothing was written.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The folder could not be created, or the file could not be written.
    #[error("cannot write this file: {reason}; check the folder's permissions and the free space: {}", path.display())]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// The target already exists and is no regular file.
    #[error("this is a folder or a device, not a file; choose another name: {}", .0.display())]
    NotAFile(PathBuf),
    /// The target was opened: frames, calibration, parameters, a session.
    #[error("files that were opened are never written to, and this is one, or holds one; choose another name: {}", .0.display())]
    Input(PathBuf),
    /// The target is a link.
    #[error("this is a link, and links are not followed; choose another name, or remove it: {}", .0.display())]
    Link(PathBuf),
    /// The target already exists, and Burstscope did not write it, or it was changed since.
    #[error("Burstscope did not write this file, or not as it is now, and leaves it as it is; choose another name, or replace it with --force: {}", .0.display())]
    Foreign(PathBuf),
    /// A file in a folder of the program's own has the name of an output, and Burstscope did not write it.
    #[error("Burstscope did not write this file and leaves it as it is; move it away, or name another folder: {}", .0.display())]
    InTheWay(PathBuf),
    /// Another process holds the folder, or the folder no longer exists.
    #[error(transparent)]
    Lock(#[from] LockError),
    /// The picture has no pixels, or a size that the format cannot hold.
    #[error("a picture of {width}×{height} pixels cannot be written as {format}: {}", path.display())]
    Size {
        /// The target.
        path: PathBuf,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// The format, such as "PNG".
        format: &'static str,
    },
    /// The file could not be read.
    #[error("cannot read this file: {reason}: {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// A line of a text file has a wrong form.
    #[error("line {line}: {problem}: {}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Problem, and what would be right.
        problem: String,
    },
}

impl ExportError {
    /// The error of a failed or cancelled write to `path`.
    pub fn write(path: &Path, error: &std::io::Error) -> Self {
        if error.get_ref().is_some_and(|inner| inner.is::<Cancelled>()) {
            return Self::Cancelled(Cancelled);
        }
        Self::Write { path: path.into(), reason: write_problem(error) }
    }
}
