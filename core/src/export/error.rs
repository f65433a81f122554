//! Why a file could not be written or read back.

use crate::files::lock::LockError;
use crate::files::write_problem;
use std::path::{Path, PathBuf};

/// Why there is no new file. A file that stood there before is untouched.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The folder could not be made, or the file not be written.
    #[error("cannot write this file: {reason}; check the folder's permissions and the free space: {}", path.display())]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The target is there already and is no regular file.
    #[error("this is a folder or a device, not a file; choose another name: {}", path.display())]
    NotAFile {
        /// The target.
        path: PathBuf,
    },
    /// The target was opened: frames, calibration, parameters, a session.
    #[error("files that were opened are never written to, and this is one, or holds one; choose another name: {}", path.display())]
    Input {
        /// The target, or the folder that holds the file.
        path: PathBuf,
    },
    /// The target is a link.
    #[error("this is a link, and links are not followed; choose another name, or remove it: {}", path.display())]
    Link {
        /// The target.
        path: PathBuf,
    },
    /// The target is there already, and somebody else wrote it.
    #[error("Burstscope did not write this file and leaves it as it is; choose another name, or replace it with --force: {}", path.display())]
    Foreign {
        /// The target.
        path: PathBuf,
    },
    /// The folder is another process's, or is not there any more.
    #[error(transparent)]
    Lock(#[from] LockError),
    /// A picture without pixels, or one whose size the format cannot hold.
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
        /// What the system says.
        reason: String,
    },
    /// A line of a text file that is not as it should be.
    #[error("line {line}: {problem}: {}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong and what would be right.
        problem: String,
    },
}

impl ExportError {
    /// A failed write to `path`.
    pub(crate) fn write(path: &Path, error: &std::io::Error) -> Self {
        Self::Write { path: path.into(), reason: write_problem(error) }
    }
}
