//! Rules for overwriting files: never a file that was opened, and files of others only with `--force`.
//!
//! An existing file is checked before the work begins, so that a refusal comes early, and again before it is written.
//! Names of a file may be relative, lead through links, or be one of several: the system's data tell which is an input.

use super::{atomic::is_of_system, colmap::is_colmap_text, csv::is_table};
use crate::error::{Error, ErrorKind, Result};
use crate::files::mark::{Checksum, has_mark};
use std::path::{Path, PathBuf};
use std::{collections::HashSet, fs::Metadata};

/// Whether this program wrote the file at `path` as it is now: by its [`mark`](crate::files::mark); a table by its
/// header and the form of its lines, COLMAP's text by its numbers. False for a file that cannot be read.
pub fn is_ours(path: &Path) -> bool {
    has_mark(path, true) || is_table(path) || is_colmap_text(path, true)
}

/// Whether files that Burstscope did not write may be replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Overwrite {
    /// Only files that Burstscope wrote, and nobody changed, are replaced. Links stay.
    #[default]
    Refuse,
    /// Any file is replaced, and a link by the file; the link's target stays.
    Force,
}

/// Files that were opened, or will be.
#[derive(Debug, Clone, Default)]
pub struct OpenedFiles {
    /// Names in their folders, without links in the folders.
    places: HashSet<PathBuf>,
    /// Files that the names lead to.
    targets: HashSet<Identity>,
}

/// Equal for two names of the same file: its device and inode number, or its name without links.
#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

#[cfg(unix)]
fn identity(_: &Path, metadata: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path, _: &Metadata) -> Option<Identity> {
    std::fs::canonicalize(path).ok()
}

impl OpenedFiles {
    /// The inputs `files`. A name of a missing file is left out.
    pub fn of(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut inputs = Self::default();
        // Frames usually lie in one folder: consecutive files of a folder share its look-up.
        let mut last: Option<(PathBuf, PathBuf)> = None;
        for file in files {
            let Some((folder, name)) = parted(&file) else { continue };
            let known = last.take().filter(|(asked, _)| asked == folder).map(|(_, real)| real);
            let Some(real) = known.or_else(|| std::fs::canonicalize(folder).ok()) else { continue };
            inputs.places.insert(real.join(name));
            inputs.targets.extend(std::fs::metadata(&file).ok().and_then(|metadata| identity(&file, &metadata)));
            last = Some((folder.to_path_buf(), real));
        }
        inputs
    }

    /// Whether `path`, whose `metadata` the system gave without following a link, is one of the inputs.
    fn hold(&self, path: &Path, metadata: &Metadata) -> bool {
        let by_name = parted(path)
            .and_then(|(folder, name)| Some(std::fs::canonicalize(folder).ok()?.join(name)))
            .is_some_and(|place| self.places.contains(&place));
        // A link to an input is no input: replacing it loses nothing.
        let by_target = || identity(path, metadata).is_some_and(|identity| self.targets.contains(&identity));
        by_name || (!metadata.is_symlink() && by_target())
    }
}

fn parted(path: &Path) -> Option<(&Path, &std::ffi::OsStr)> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some((folder, path.file_name()?))
}

/// Rules for overwriting files.
#[derive(Debug, Clone, Default)]
pub struct OutputRules {
    inputs: OpenedFiles,
    overwrite: Overwrite,
}

impl OutputRules {
    /// Rules for a run that opens `inputs`.
    pub fn new(inputs: OpenedFiles, overwrite: Overwrite) -> Self {
        Self { inputs, overwrite }
    }

    /// These rules for a run that has also opened `files`.
    pub fn and_opened(mut self, files: impl IntoIterator<Item = PathBuf>) -> Self {
        let OpenedFiles { places, targets } = OpenedFiles::of(files);
        self.inputs.places.extend(places);
        self.inputs.targets.extend(targets);
        self
    }

    /// Checks whether the file `path` may be written. An empty file counts as missing.
    ///
    /// # Errors
    /// A file that was opened, in any case; a folder or a device; without [`Overwrite::Force`] a link, and a file that
    /// Burstscope did not write, or not as it is now.
    pub fn check(&self, path: &Path) -> Result<()> {
        self.check_if(path, || is_ours(path)).map_err(|refused| refused.unwrap_or(Error::foreign(path)))
    }

    /// Checks whether `path` may be written in a folder known to be this program's own. What was altered there is made
    /// again: every file with a mark may be replaced, whole or not, and one with a checksum among the `known` ones.
    ///
    /// # Errors
    /// As [`Self::check`]; the remedy is another folder.
    pub fn check_own(&self, path: &Path, known: &[Checksum]) -> Result<()> {
        let is_ours =
            || has_mark(path, false) || is_colmap_text(path, false) || known.iter().any(|content| content.is_of(path));
        self.check_if(path, is_ours).map_err(|refused| refused.unwrap_or(Error::in_the_way(path)))
    }

    /// The error is `None` for a file that is not ours.
    fn check_if(&self, path: &Path, is_ours: impl FnOnce() -> bool) -> Result<(), Option<Error>> {
        let Ok(metadata) = std::fs::symlink_metadata(path) else { return Ok(()) };
        // Devices and opened files come first: they are refused even with [`Overwrite::Force`].
        let refused = match self.overwrite {
            _ if is_of_system(path) => Error::no_file(path),
            _ if self.inputs.hold(path, &metadata) => Error::opened(path),
            Overwrite::Refuse if metadata.is_symlink() => Error::link(path),
            _ if !(metadata.is_file() || metadata.is_symlink()) => Error::no_file(path),
            Overwrite::Refuse if metadata.len() > 0 && !is_ours() => return Err(None),
            _ => return Ok(()),
        };
        Err(Some(refused))
    }

    /// Fails when an opened file lies in `folder`, which is to be replaced as a whole.
    pub fn check_folder(&self, folder: &Path) -> Result<()> {
        let holds = |real: PathBuf| self.inputs.places.iter().any(|place| place.starts_with(&real));
        if std::fs::canonicalize(folder).is_ok_and(holds) { Err(Error::opened(folder)) } else { Ok(()) }
    }
}

/// Errors of outputs, and of reading files back. An existing file is unchanged.
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
