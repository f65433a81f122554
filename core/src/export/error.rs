//! Errors of outputs, and of reading files back. An existing file is unchanged.

use crate::error::{Error, ErrorKind};
use std::path::Path;

impl Error {
    pub(super) fn no_file(path: &Path) -> Self {
        let problem = "this is a folder or a device, not a file";
        Self::new(ErrorKind::Refused, problem, "choose another name").about(path)
    }

    pub(super) fn opened(path: &Path) -> Self {
        let problem = "files that were opened are never written to, and this is one, or holds one";
        Self::new(ErrorKind::Refused, problem, "choose another name").about(path)
    }

    pub(crate) fn link(path: &Path) -> Self {
        let problem = "this is a link, and links are not followed";
        Self::new(ErrorKind::Refused, problem, "choose another name, or remove it").about(path)
    }

    pub(super) fn unfit(path: &Path, (width, height): (usize, usize), format: &str) -> Self {
        let problem = format!("a picture of {width}×{height} pixels cannot be written as {format}");
        Self::new(ErrorKind::Refused, problem, "").about(path)
    }

    /// Error for an existing file that Burstscope did not write, or that was changed since.
    pub(super) fn foreign(path: &Path) -> Self {
        let problem = "Burstscope did not write this file, or not as it is now, and leaves it as it is";
        Self::new(ErrorKind::InTheWay, problem, "choose another name, or replace it with --force").about(path)
    }

    /// Error for a file of others that has the name of an output, in a folder of the program's own.
    pub(super) fn in_the_way(path: &Path) -> Self {
        let problem = "Burstscope did not write this file and leaves it as it is";
        Self::new(ErrorKind::InTheWay, problem, "move it away, or name another folder").about(path)
    }

    pub(crate) fn unread_file(path: &Path, reason: impl std::fmt::Display) -> Self {
        Self::new(ErrorKind::System, format!("cannot read this file: {reason}"), "").about(path)
    }

    /// Error for a line, counted from 1, of a text file; `problem` says what would be right.
    pub(crate) fn in_line(path: &Path, line: usize, problem: &str) -> Self {
        Self::new(ErrorKind::Damaged, format!("line {line}: {problem}"), "").about(path)
    }
}
