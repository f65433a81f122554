//! A lock that lets only one process at a time write into a folder.
//!
//! The system's own lock is taken on a hidden file, which lies in the folder, or beside a folder that is replaced as a
//! whole. The lock ends with the process that holds it; the file's text names the owner. On Unix the file is removed at
//! the end, while it is still locked: a process that opened it before sees that it has lost its name, and starts again.
//! Elsewhere that cannot be seen, and the hidden file stays. A file of its name with any other text is somebody's.

use super::path_text;
use crate::error::{Error, ErrorKind, Result};
use std::ffi::OsStr;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// Name of the lock file in a folder.
pub const LOCK_FILE: &str = ".burstscope-lock";
/// Prefix of the names of all hidden files and folders that runs of this program create and remove.
pub(super) const HIDDEN_PREFIX: &str = ".burstscope";
const LOCK_SUFFIX: &str = ".lock";
/// Maximum length of a folder's name in the name of the lock beside it, bytes.
const LONGEST_NAME: usize = 200;
/// Maximum number of attempts to take a lock whose file keeps being removed in the meantime.
const TRIES: usize = 64;
const OWNER: &str = "process ";

/// Whether the file at `path` is a lock of this program, by its name and text. A killed run leaves it behind.
pub(super) fn is_lock(path: &Path) -> bool {
    let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
    (name == LOCK_FILE || (name.starts_with(HIDDEN_PREFIX) && name.ends_with(LOCK_SUFFIX)))
        && std::fs::symlink_metadata(path).is_ok_and(|found| found.is_file())
        && super::open(path).is_ok_and(|mut file| names_owner(&mut file))
}

fn names_owner(file: &mut File) -> bool {
    let mut text = String::new();
    let is_text = file.rewind().is_ok() && file.take(4096).read_to_string(&mut text).is_ok();
    let is_number = |rest: &str| rest.starts_with(|c: char| c.is_ascii_digit());
    is_text && (text.is_empty() || (text.strip_prefix(OWNER).is_some_and(is_number) && text.lines().count() == 1))
}

/// Right to write into a folder, until it is dropped.
#[derive(Debug)]
pub struct FolderLock {
    folder: PathBuf,
    path: PathBuf,
    /// Always `Some` until the lock is dropped.
    file: Option<File>,
    /// Whether the file system supports locks; without them nothing keeps two processes apart.
    is_locked: bool,
    /// Folders created for the lock, innermost first. Those that are empty at the end are removed.
    made: Vec<PathBuf>,
}

impl FolderLock {
    /// Takes the lock of `folder`, creating it. A folder that was created so and stays empty is removed with the lock.
    ///
    /// # Errors
    /// Another process has it, or the folder cannot be written.
    pub fn take(folder: &Path) -> Result<Self> {
        Self::at(folder, folder, folder.join(LOCK_FILE))
    }

    /// Takes the lock of a `folder` that is replaced as a whole: the lock lies in the parent folder, which is created.
    pub fn beside(folder: &Path) -> Result<Self> {
        let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        remove_abandoned(parent);
        let name = path_text(Path::new(folder.file_name().unwrap_or_default()));
        let name = if name.len() <= LONGEST_NAME { name } else { format!("{:08x}", crc32fast::hash(name.as_bytes())) };
        Self::at(folder, parent, parent.join(format!("{HIDDEN_PREFIX}-{name}{LOCK_SUFFIX}")))
    }

    fn at(folder: &Path, place: &Path, path: PathBuf) -> Result<Self> {
        let failed = |error: io::Error| Error::unwritten(&path, &error);
        let refused = |words: &str| failed(io::Error::other(words));
        // From here on the created folders are removed again, even if the lock cannot be taken.
        let mut lock =
            Self { folder: folder.into(), path: path.clone(), file: None, is_locked: true, made: Vec::new() };
        for _ in 0..TRIES {
            match make_folders(place) {
                Ok(made) => drop(lock.made.splice(0..0, made)),
                // Another process has ended and removed the folders that it had created.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => return Err(failed(error)),
            }
            if std::fs::symlink_metadata(&path).is_ok_and(|file| file.is_symlink()) {
                return Err(refused("this is a link, which is not followed; remove it"));
            }
            let file = super::open_as(&path, OpenOptions::new().read(true).write(true).create(true).truncate(false));
            let mut file = match file {
                Ok(file) => file,
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => return Err(failed(error)),
            };
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let mut owner = String::new();
                    // Where a lock keeps other processes from reading, the owner is unknown.
                    let _ = file.take(4096).read_to_string(&mut owner);
                    let owner = if owner.trim().is_empty() { "another process" } else { owner.trim() };
                    let problem = format!("{owner} writes into this folder");
                    let remedy = "wait until it has finished, or name another folder";
                    return Err(Error::new(ErrorKind::Locked, problem, remedy).about(folder));
                }
                // A file system without locks reports it with various errors; none is a reason not to work there.
                Err(TryLockError::Error(_)) => lock.is_locked = false,
            }
            if is_named(&file, &path) {
                if !names_owner(&mut file) {
                    return Err(refused("this is not the lock that should have this name; move it away"));
                }
                // From here on the file is removed again, even if it cannot be written.
                let file = lock.file.insert(file);
                file.set_len(0).and_then(|()| file.rewind()).map_err(failed)?;
                writeln!(file, "{}", owner()).map_err(failed)?;
                return Ok(lock);
            }
        }
        Err(refused("it cannot be kept there; name a folder in which files can be made"))
    }

    /// Fails when the folder was removed, or another one has its place.
    pub fn check(&self) -> Result<()> {
        let there = match &self.file {
            Some(file) if self.is_locked => is_named(file, &self.path),
            // Another process may have put its own file there.
            _ => self.path.exists(),
        };
        if there { Ok(()) } else { Err(self.gone()) }
    }

    fn gone(&self) -> Error {
        let problem = "this folder was removed while it was being written, so nothing more is written";
        Error::new(ErrorKind::Locked, problem, "run the command again to make it anew").about(&self.folder)
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // A hidden file that cannot be removed does no harm.
        if cfg!(unix) && self.is_locked && self.file.as_ref().is_some_and(|file| is_named(file, &self.path)) {
            let _ = std::fs::remove_file(&self.path);
        }
        drop(self.file.take());
        // The system removes only empty folders.
        let _ = self.made.iter().try_for_each(std::fs::remove_dir);
    }
}

fn owner() -> String {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let on_host = if host.trim().is_empty() { String::new() } else { format!(" on {}", host.trim()) };
    format!("{OWNER}{}{on_host}", std::process::id())
}

#[cfg(unix)]
fn is_named(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |metadata: io::Result<std::fs::Metadata>| metadata.map(|m| (m.dev(), m.ino())).ok();
    identity(file.metadata()).is_some_and(|open| identity(std::fs::symlink_metadata(path)) == Some(open))
}

#[cfg(not(unix))]
fn is_named(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Creates `folder` and its missing parents; returns the created folders, innermost first.
fn make_folders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let missing: Vec<&Path> = folder.ancestors().take_while(is_missing).collect();
    let mut made = Vec::new();
    for folder in missing.into_iter().rev() {
        match std::fs::create_dir(folder) {
            Ok(()) => made.insert(0, folder.to_path_buf()),
            // Another process created it, and may have removed it again by now, which is seen below.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && !folder.is_symlink() => {}
            Err(error) => return Err(error),
        }
    }
    if folder.as_os_str().is_empty() {
        return Ok(made);
    }
    match std::fs::metadata(folder) {
        Ok(found) if found.is_dir() => Ok(made),
        Ok(_) => Err(io::ErrorKind::NotADirectory.into()),
        // [`io::ErrorKind::NotFound`] if another process has removed it meanwhile.
        Err(error) => Err(error),
    }
}

/// Removes the locks of folders in `parent` that killed runs have left.
fn remove_abandoned(parent: &Path) {
    for entry in std::fs::read_dir(parent).into_iter().flatten().flatten() {
        if cfg!(unix)
            && entry.file_name() != LOCK_FILE
            && is_lock(&entry.path())
            && let Ok(file) = super::open_as(&entry.path(), OpenOptions::new().write(true))
            && file.try_lock().is_ok()
            && is_named(&file, &entry.path())
        {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}
