//! Files that are written completely or not at all: in a hidden folder beside the target ([`Unfinished`]), then moved.

use crate::error::{Error, Result};
use crate::files::mark::{OutputKind, seal, sealed};
use crate::files::unfinished::Unfinished;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writer for a format: buffered, and able to seek.
pub type FileWriter<'a> = BufWriter<&'a mut File>;

/// Writes the file `path` by `write`, without a mark, and missing parent folders. It replaces `path` only when all
/// bytes are on disk: after a failure an existing file is unchanged and no other one is left behind. A link is
/// replaced, never followed; permissions stay. [`OutputRules`](super::OutputRules) say whether it may be replaced.
///
/// # Errors
/// The system or `write` fails, `write` was cancelled, or `path` is a folder or a device.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut FileWriter<'_>) -> io::Result<()>) -> Result<()> {
    replace(path, |new| written(new, write))
}

/// Writes the file `path` as [`write_whole`] does, with the mark of this kind.
pub fn write_marked(
    path: &Path,
    kind: OutputKind,
    write: impl FnOnce(&mut FileWriter<'_>) -> io::Result<()>,
) -> Result<()> {
    replace(path, |new| {
        let mut file = written(new, write)?;
        seal(&mut file, kind)?;
        Ok(file)
    })
}

/// Writes the text of an XML document or of settings, with the mark of this kind, as [`write_whole`] does.
pub fn write_text(path: &Path, kind: OutputKind, text: String) -> Result<()> {
    write_whole(path, |out| out.write_all(sealed(text, kind).as_bytes()))
}

fn written(new: &Path, write: impl FnOnce(&mut FileWriter<'_>) -> io::Result<()>) -> io::Result<File> {
    let mut file = OpenOptions::new().read(true).write(true).create_new(true).open(new)?;
    let mut writer = BufWriter::with_capacity(1 << 16, &mut file);
    write(&mut writer).and_then(|()| writer.flush())?;
    drop(writer);
    Ok(file)
}

/// Whether the path is a device or a pipe, or a link to one, such as `/dev/stdout`, which is not to be replaced.
pub(super) fn is_of_system(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|leads_to| !leads_to.is_file() && !leads_to.is_dir())
        || std::fs::read_link(path).is_ok_and(|to| to.starts_with("/proc") || to.starts_with("/dev"))
}

/// Writes the file `path` by `fill`, which completes the new file at the path that it is given.
pub(super) fn replace(path: &Path, fill: impl FnOnce(&Path) -> io::Result<File>) -> Result<()> {
    let fail = |e: io::Error| Error::unwritten(path, &e);
    let existing = std::fs::symlink_metadata(path).ok();
    let is_other = existing.as_ref().is_some_and(|m| !m.is_file() && !m.is_symlink());
    if is_of_system(path) || is_other || path.file_name().is_none() {
        return Err(Error::no_file(path));
    }
    if let Some(parent) = path.parent().filter(|parent| !parent.as_os_str().is_empty()) {
        std::fs::create_dir_all(parent).map_err(fail)?;
    }
    // Beside the target, because only within a file system a file is moved at once.
    let unfinished = Unfinished::beside(path).map_err(fail)?;
    let file = fill(&unfinished.new_path()).map_err(fail)?;
    // A private file stays private.
    if let Some(existing) = existing.filter(std::fs::Metadata::is_file) {
        file.set_permissions(existing.permissions()).map_err(fail)?;
    }
    // On disk before the rename: a crash leaves the old file or the whole new one.
    file.sync_all().map_err(fail)?;
    drop(file);
    std::fs::rename(unfinished.new_path(), path).map_err(fail)
}
