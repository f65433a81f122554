//! One process at a time writes into a folder.
//!
//! The system's own lock is taken on a hidden file, which lies in the folder, or beside a folder that is replaced as a
//! whole. The lock ends with the process that has it, however that ends; the file's text names the owner, for whoever
//! is refused.
//!
//! On Unix the file is removed at the end, while it is still locked. Somebody else may have opened it before, so whoever
//! gets a lock makes sure that the file still has its name, and otherwise begins again: no two processes hold a lock of
//! the same name. Elsewhere that cannot be told, and the hidden file stays. A folder that holds nothing else counts as
//! empty, see [`is_left_over`].

use super::{path_text, write_problem};
use std::ffi::OsStr;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// The name of the file in a folder.
pub const LOCK_FILE: &str = ".burstscope-lock";
/// How the names of all hidden files begin that runs of this program make and remove.
const HIDDEN_PREFIX: &str = ".burstscope";
/// How the names of files that are not complete yet end.
pub const TEMPORARY_SUFFIX: &str = ".tmp";
/// How the names of locks end that lie beside their folders.
const LOCK_SUFFIX: &str = ".lock";
/// The longest name of a folder that stands in the name of the lock beside it, bytes.
const LONGEST_NAME: usize = 200;
/// How often a lock is asked for anew whose file was removed meanwhile.
const TRIES: usize = 64;

/// Whether a file of this name is one that a run of this program makes for itself and removes at its end: a killed run
/// leaves it behind.
pub fn is_left_over(name: &OsStr) -> bool {
    name.to_str().is_some_and(|name| {
        let ends = [TEMPORARY_SUFFIX, LOCK_SUFFIX].iter().any(|end| name.ends_with(end));
        name == LOCK_FILE || (name.starts_with(HIDDEN_PREFIX) && ends)
    })
}

/// Whether `folder` holds nothing but what killed runs have left, or is not there.
///
/// # Errors
/// A folder that cannot be read, or something that is no folder.
pub fn is_free(folder: &Path) -> io::Result<bool> {
    match std::fs::read_dir(folder) {
        Ok(entries) => {
            for entry in entries {
                if !is_left_over(&entry?.file_name()) {
                    return Ok(false);
                }
            }
            Ok(true)
        }
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(true),
        Err(error) => Err(error),
    }
}

/// Why a folder must not be written, or not any more.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LockError {
    /// Another process writes into it.
    #[error("{owner} writes into this folder; wait until it has finished, or name another folder: {}", .folder.display())]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// Who.
        owner: String,
    },
    /// It was removed, or another one was put in its place.
    #[error("this folder was removed while it was being written, so nothing more is written; run the command again to make it anew: {}", .0.display())]
    Gone(PathBuf),
    /// The lock cannot be written.
    #[error("cannot write this file: {reason}; check the folder's permissions and the free space: {}", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
}

/// The right to write into a folder, as long as it lives.
#[derive(Debug)]
pub struct FolderLock {
    folder: PathBuf,
    path: PathBuf,
    /// Always there until the lock is dropped.
    file: Option<File>,
    /// Whether the file system has locks; without, two processes are the person's own affair.
    is_locked: bool,
    /// The folders that were made for it, the innermost first. Those that are empty at the end are removed.
    made: Vec<PathBuf>,
}

impl FolderLock {
    /// The lock of `folder`, which is made. If nothing was written into a folder that was made so, it is removed with
    /// the lock.
    ///
    /// # Errors
    /// [`LockError::Locked`] when another process has it, [`LockError::Write`] when the folder cannot be written.
    pub fn take(folder: &Path) -> Result<Self, LockError> {
        Self::at(folder, folder, folder.join(LOCK_FILE))
    }

    /// The lock of a `folder` that is replaced as a whole: it lies in the folder above, which is made.
    ///
    /// # Errors
    /// As [`Self::take`].
    pub fn beside(folder: &Path) -> Result<Self, LockError> {
        let parent = match folder.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        remove_abandoned(parent);
        let name = path_text(Path::new(folder.file_name().unwrap_or_default()));
        let name = if name.len() <= LONGEST_NAME { name } else { format!("{:08x}", crc32fast::hash(name.as_bytes())) };
        Self::at(folder, parent, parent.join(format!("{HIDDEN_PREFIX}-{name}{LOCK_SUFFIX}")))
    }

    fn at(folder: &Path, place: &Path, path: PathBuf) -> Result<Self, LockError> {
        let failed = |error: io::Error| LockError::Write { path: path.clone(), reason: write_problem(&error) };
        // From here on what was made is removed again, also should the lock not be had.
        let mut lock =
            Self { folder: folder.into(), path: path.clone(), file: None, is_locked: true, made: Vec::new() };
        for _ in 0..TRIES {
            match make_folders(place) {
                Ok(made) => drop(lock.made.splice(0..0, made)),
                // Another process has ended and removed the folders that it had made.
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                Err(error) => return Err(failed(error)),
            }
            if std::fs::symlink_metadata(&path).is_ok_and(|file| file.is_symlink()) {
                return Err(failed(io::Error::other("this is a link, which is not followed; remove it")));
            }
            let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = match file {
                Ok(file) => file,
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                Err(error) => return Err(failed(error)),
            };
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(LockError::Locked { folder: folder.into(), owner: owner_in(&mut file) });
                }
                // A file system without locks says so in many ways, and none is a reason not to work there.
                Err(TryLockError::Error(_)) => lock.is_locked = false,
            }
            if is_named(&file, &path) {
                file.set_len(0).and_then(|()| file.rewind()).map_err(failed)?;
                writeln!(file, "{}", owner()).map_err(failed)?;
                lock.file = Some(file);
                return Ok(lock);
            }
        }
        Err(failed(io::Error::other("it is removed again and again")))
    }

    /// Whether the folder is still the one that was locked.
    ///
    /// # Errors
    /// [`LockError::Gone`] when it was removed, or another one has its place.
    pub fn check(&self) -> Result<(), LockError> {
        let there = match &self.file {
            Some(file) if self.is_locked => is_named(file, &self.path),
            // Another process may have put its own file there.
            _ => self.path.exists(),
        };
        if there { Ok(()) } else { Err(LockError::Gone(self.folder.clone())) }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            // What cannot be removed is a hidden file too many.
            if cfg!(unix) && self.is_locked && is_named(&file, &self.path) {
                let _ = std::fs::remove_file(&self.path);
            }
        }
        // The system removes folders only that are empty.
        let _ = self.made.iter().try_for_each(std::fs::remove_dir);
    }
}

/// This process, in words.
fn owner() -> String {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let on_host = if host.trim().is_empty() { String::new() } else { format!(" on {}", host.trim()) };
    format!("process {}{on_host}", std::process::id())
}

/// Who has the lock on `file`.
fn owner_in(file: &mut File) -> String {
    let mut owner = String::new();
    // Where a lock keeps others from reading, nobody can be named.
    let _ = file.take(4096).read_to_string(&mut owner);
    if owner.trim().is_empty() { "another process".to_owned() } else { owner.trim().to_owned() }
}

/// Whether `path` is still the name of the open file.
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

/// Makes `folder` and those above it that are missing; answers those that were made, the innermost first.
fn make_folders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let missing: Vec<&Path> = folder.ancestors().take_while(is_missing).collect();
    let mut made = Vec::new();
    for folder in missing.into_iter().rev() {
        match std::fs::create_dir(folder) {
            Ok(()) => made.insert(0, folder.to_path_buf()),
            Err(error) if error.kind() == ErrorKind::AlreadyExists && folder.is_dir() => {}
            Err(error) => return Err(error),
        }
    }
    if folder.is_dir() || folder.as_os_str().is_empty() { Ok(made) } else { Err(ErrorKind::NotADirectory.into()) }
}

/// Removes the locks beside folders in `parent` that killed runs have left.
fn remove_abandoned(parent: &Path) {
    for entry in std::fs::read_dir(parent).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_lock = name.to_str().is_some_and(|name| name.starts_with(HIDDEN_PREFIX) && name.ends_with(LOCK_SUFFIX));
        if cfg!(unix)
            && is_lock
            && entry.file_type().is_ok_and(|kind| kind.is_file())
            && let Ok(file) = OpenOptions::new().write(true).open(entry.path())
            && file.try_lock().is_ok()
            && is_named(&file, &entry.path())
        {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time_and_the_owner_is_named() {
        let home = tempfile::tempdir().expect("a folder");
        let folder = home.path().join("deep/new");
        for lock in [FolderLock::take, FolderLock::beside] {
            let first = lock(&folder).expect("free");
            match lock(&folder) {
                Err(LockError::Locked { owner, .. }) => {
                    assert!(owner.contains(&format!("process {}", std::process::id())), "{owner}");
                }
                other => panic!("two have the lock: {other:?}"),
            }
            drop(first);
            lock(&folder).expect("free again");
        }
        let of_another = FolderLock::beside(&home.path().join("b")).expect("free");
        FolderLock::beside(&home.path().join("a")).expect("another folder's lock is no hindrance");
        drop(of_another);
    }

    #[cfg(unix)]
    #[test]
    fn nothing_is_left_but_what_was_written() {
        let home = tempfile::tempdir().expect("a folder");
        let names = || std::fs::read_dir(home.path()).expect("a folder").count();
        let folder = home.path().join("a/b/c");
        drop(FolderLock::take(&folder).expect("free"));
        assert_eq!(names(), 0, "folders that were made for nothing");
        let lock = FolderLock::take(&folder).expect("free");
        assert!(is_free(&folder).expect("a folder"), "it holds nothing but the lock");
        std::fs::write(folder.join("x"), "").expect("written");
        assert!(!is_free(&folder).expect("a folder"));
        drop(lock);
        assert_eq!(std::fs::read_dir(&folder).expect("it stays").count(), 1);
        // What a killed run leaves beside its folder goes with the next lock there.
        std::fs::write(home.path().join(".burstscope-old.lock"), "process 4711").expect("written");
        drop(FolderLock::beside(&home.path().join("d")).expect("free"));
        assert_eq!(names(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_that_is_removed_or_replaced_is_noticed() {
        let home = tempfile::tempdir().expect("a folder");
        let folder = home.path().join("a");
        let lock = FolderLock::take(&folder).expect("free");
        lock.check().expect("it is there");
        std::fs::remove_dir_all(&folder).expect("removed");
        assert_eq!(lock.check(), Err(LockError::Gone(folder.clone())));
        let next = FolderLock::take(&folder).expect("a new folder has a new lock");
        assert_eq!(lock.check(), Err(LockError::Gone(folder.clone())));
        drop(lock);
        next.check().expect("the old lock has left it alone");
    }

    #[cfg(unix)]
    #[test]
    fn many_who_want_it_have_it_one_after_the_other() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let home = tempfile::tempdir().expect("a folder");
        let folder = home.path().join("a");
        let (inside, had) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let mut own = 0;
                    while own < 40 {
                        match FolderLock::take(&folder) {
                            Ok(_lock) => {
                                assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0, "two have the lock");
                                had.fetch_add(1, Ordering::SeqCst);
                                own += 1;
                                inside.fetch_sub(1, Ordering::SeqCst);
                            }
                            Err(LockError::Locked { .. }) => {}
                            Err(error) => panic!("{error}"),
                        }
                    }
                });
            }
        });
        assert_eq!(had.load(Ordering::SeqCst), 160);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_in_place_of_the_lock_is_not_followed() {
        let home = tempfile::tempdir().expect("a folder");
        let precious = home.path().join("thesis.txt");
        std::fs::write(&precious, "precious").expect("written");
        std::os::unix::fs::symlink(&precious, home.path().join(LOCK_FILE)).expect("linked");
        assert!(matches!(FolderLock::take(home.path()), Err(LockError::Write { .. })));
        assert_eq!(std::fs::read_to_string(&precious).expect("there"), "precious");
    }
}
