//! Files that are written completely or not at all.
//!
//! The bytes go to a temporary file beside the target, which then replaces the target. A killed run leaves its
//! temporary file behind; the next run that writes into the folder removes it. Files that another process is writing
//! are recognised by a system lock, which ends with their process.

use super::error::ExportError;
use crate::files::lock::TEMPORARY_SUFFIX;
use std::collections::HashSet;
use std::ffi::OsStr;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};
use tempfile::NamedTempFile;

/// Writer for a format: buffered, and able to seek.
pub type FileWriter<'a> = BufWriter<&'a mut File>;

/// Writes the file `path` by `write`. The bytes go to a temporary file beside it, which replaces `path` only when all
/// of them are on disk: after a failure an existing file is unchanged and no other one is left behind. Missing parent
/// folders are created. A link is replaced, never followed; the new file has the permissions of the file that it
/// replaces. The caller decides whether anything may be replaced, see [`OutputRules`](super::OutputRules).
///
/// # Errors
/// [`ExportError::Write`] when the system or `write` fails, [`ExportError::NotAFile`] when `path` is a folder or a
/// device.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut FileWriter<'_>) -> io::Result<()>) -> Result<(), ExportError> {
    replace(path, locked_temporary_in, |temporary| {
        let mut writer = BufWriter::with_capacity(1 << 16, temporary.as_file_mut());
        write(&mut writer).and_then(|()| writer.flush())
    })
}

/// Writes the file `path` for a format that opens it by its path: `fill` completes the empty temporary file. That file
/// is not locked, because a lock might keep the format from opening it; so only [`remove_temporary_files`] removes one
/// that a killed run left.
#[cfg(feature = "colmap")]
pub(super) fn replace_whole(
    path: &Path,
    fill: impl FnOnce(&mut NamedTempFile) -> io::Result<()>,
) -> Result<(), ExportError> {
    replace(path, |folder| temporary_in(folder, UNLOCKED_PREFIX), fill)
}

/// Whether the path is a device or a pipe, or a link to one, such as `/dev/stdout`: part of the system, not to be
/// replaced.
pub(super) fn is_of_system(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|leads_to| !leads_to.is_file() && !leads_to.is_dir())
        || std::fs::read_link(path).is_ok_and(|to| to.starts_with("/proc") || to.starts_with("/dev"))
}

fn replace(
    path: &Path,
    temporary_in: impl FnOnce(&Path) -> io::Result<NamedTempFile>,
    fill: impl FnOnce(&mut NamedTempFile) -> io::Result<()>,
) -> Result<(), ExportError> {
    let fail = |e: io::Error| ExportError::write(path, &e);
    let existing = std::fs::symlink_metadata(path).ok();
    let is_other = existing.as_ref().is_some_and(|m| !m.is_file() && !m.is_symlink());
    if is_of_system(path) || is_other || path.file_name().is_none() {
        return Err(ExportError::NotAFile { path: path.into() });
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    };
    std::fs::create_dir_all(&folder).map_err(fail)?;
    let mut temporary = temporary_in(&folder).map_err(fail)?;
    fill(&mut temporary).map_err(fail)?;
    if let Some(existing) = existing.filter(std::fs::Metadata::is_file) {
        temporary.as_file().set_permissions(existing.permissions()).map_err(fail)?;
    }
    temporary.as_file().sync_all().map_err(fail)?;
    temporary.persist(path).map_err(|e| fail(e.error))?;
    Ok(())
}

/// A temporary file with the permissions of any other new file (the library's default would make it private).
fn temporary_in(folder: &Path, prefix: &str) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(TEMPORARY_SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// Maximum number of temporary files created when another process removes them before they are locked.
const TRIES: usize = 8;

/// A temporary file with a lock, which shows other processes that it is in use.
fn locked_temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    remove_abandoned_once(folder);
    for _ in 0..TRIES {
        let temporary = temporary_in(folder, TEMPORARY_PREFIX)?;
        match temporary.as_file().try_lock() {
            // Before it was locked, another process may have considered it abandoned and removed it.
            Ok(()) if temporary.path().exists() => return Ok(temporary),
            // Another process is doing so now.
            Ok(()) | Err(TryLockError::WouldBlock) => {}
            // A file system without locks: no process gets the lock that it needs to remove the file.
            Err(TryLockError::Error(_)) => return Ok(temporary),
        }
    }
    Err(io::Error::other("temporary files in this folder vanish"))
}

const TEMPORARY_PREFIX: &str = ".burstscope-";
const UNLOCKED_PREFIX: &str = ".burstscope_";

fn is_named(name: &OsStr, prefixes: &[&str]) -> bool {
    name.to_str()
        .is_some_and(|name| prefixes.iter().any(|prefix| name.starts_with(prefix)) && name.ends_with(TEMPORARY_SUFFIX))
}

/// Removes files that killed runs left in `folder`, the first time that this process writes there. A file locked by
/// another process is in use and stays; without file locks all files stay.
fn remove_abandoned_once(folder: &Path) {
    static SEEN: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
    let known = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    if SEEN.lock().unwrap_or_else(PoisonError::into_inner).insert(known) {
        remove_abandoned(folder);
    }
}

fn remove_abandoned(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if is_named(&entry.file_name(), &[TEMPORARY_PREFIX])
            && entry.file_type().is_ok_and(|kind| kind.is_file())
            && let Ok(file) = OpenOptions::new().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            // A file that cannot be removed does no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Whether a file of this name is an unfinished one of [`write_whole`].
pub fn is_temporary_name(name: &OsStr) -> bool {
    is_named(name, &[TEMPORARY_PREFIX, UNLOCKED_PREFIX])
}

/// Removes unfinished files that killed runs left in `folder`, if it exists. Only for a folder in which no other
/// process writes.
pub fn remove_temporary_files(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if is_temporary_name(&entry.file_name()) {
            // A file that cannot be removed does no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(folder)
            .expect("folder")
            .map(|e| e.expect("entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failing_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("a.txt");
        write_whole(&path, |w| w.write_all(b"old")).expect("written");
        let error = write_whole(&path, |w| {
            w.write_all(&[b'x'; 1 << 18])?;
            Err(io::Error::other("disk full"))
        });
        assert!(matches!(error, Err(ExportError::Write { ref reason, .. }) if reason == "disk full"), "{error:?}");
        assert_eq!(std::fs::read(&path).expect("read"), b"old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn what_a_killed_run_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().expect("folder");
        for prefix in [TEMPORARY_PREFIX, UNLOCKED_PREFIX] {
            temporary_in(folder.path(), prefix).expect("made").keep().expect("kept");
        }
        std::fs::write(folder.path().join("a.tmp"), "somebody's").expect("written");
        assert_eq!(names(folder.path()).len(), 3);
        remove_temporary_files(folder.path());
        assert_eq!(names(folder.path()), ["a.tmp"]);
        remove_temporary_files(&folder.path().join("none"));
    }

    #[test]
    fn what_another_process_is_writing_stays() {
        let folder = tempfile::tempdir().expect("folder");
        let (_, left) = temporary_in(folder.path(), TEMPORARY_PREFIX).expect("made").keep().expect("kept");
        let in_use = locked_temporary_in(folder.path()).expect("made");
        remove_abandoned(folder.path());
        assert!(in_use.path().exists() && !left.exists());
        // The first write of a process into a folder clears it.
        let other = tempfile::tempdir().expect("folder");
        temporary_in(other.path(), TEMPORARY_PREFIX).expect("made").keep().expect("kept");
        write_whole(&other.path().join("a.txt"), |w| w.write_all(b"new")).expect("written");
        assert_eq!(names(other.path()), ["a.txt"]);
    }

    #[test]
    fn a_panicking_write_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("a.txt");
        let panicked = std::panic::catch_unwind(|| write_whole(&path, |_| panic!("on purpose")));
        assert!(panicked.is_err());
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }

    #[test]
    fn folders_are_made_and_other_things_refused() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("a/b/c.txt");
        write_whole(&path, |w| w.write_all(b"new")).expect("written");
        assert_eq!(std::fs::read(&path).expect("read"), b"new");
        assert!(matches!(write_whole(folder.path(), |_| Ok(())), Err(ExportError::NotAFile { .. })));
        assert!(matches!(write_whole(Path::new("/"), |_| Ok(())), Err(ExportError::NotAFile { .. })));
        // A file in place of a folder.
        let error = write_whole(&path.join("d.txt"), |_| Ok(()));
        assert!(matches!(error, Err(ExportError::Write { .. })), "{error:?}");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_replaced_and_permissions_kept() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("folder");
        let (path, link) = (folder.path().join("a.txt"), folder.path().join("link"));
        std::fs::write(&path, "old").expect("written");
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o640)).expect("set");
        std::os::unix::fs::symlink(&path, &link).expect("linked");
        write_whole(&link, |w| w.write_all(b"new")).expect("written");
        assert_eq!(
            (std::fs::read(&path).expect("read"), std::fs::read(&link).expect("read")),
            (b"old".into(), b"new".into())
        );
        assert!(!std::fs::symlink_metadata(&link).expect("a file").is_symlink());
        let mode = |path: &Path| std::fs::metadata(path).expect("file").permissions().mode() & 0o777;
        write_whole(&path, |w| w.write_all(b"new")).expect("written");
        assert_eq!(mode(&path), 0o640);
        // A device is never replaced.
        assert!(matches!(write_whole(Path::new("/dev/null"), |_| Ok(())), Err(ExportError::NotAFile { .. })));
    }
}
