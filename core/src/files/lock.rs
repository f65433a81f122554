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
        && File::open(path).is_ok_and(|mut file| names_owner(&mut file))
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
            let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = match file {
                Ok(file) => file,
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => return Err(failed(error)),
            };
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let problem = format!("{} writes into this folder", owner_in(&mut file));
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
        Err(refused("it is removed again and again"))
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

fn owner_in(file: &mut File) -> String {
    let mut owner = String::new();
    // Where a lock keeps other processes from reading, the owner is unknown.
    let _ = file.take(4096).read_to_string(&mut owner);
    if owner.trim().is_empty() { "another process".to_owned() } else { owner.trim().to_owned() }
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
            let refused = lock(&folder).expect_err("another has it").to_string();
            assert!(refused.starts_with(&format!("process {}", std::process::id())), "{refused}");
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
        std::fs::write(folder.join("x"), "").expect("written");
        drop(lock);
        assert_eq!(std::fs::read_dir(&folder).expect("it stays").count(), 1);
        // A lock file left by a killed run is removed by the next lock there.
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
        assert_eq!(lock.check(), Err(lock.gone()));
        let next = FolderLock::take(&folder).expect("a new folder has a new lock");
        assert_eq!(lock.check(), Err(lock.gone()));
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
                            Err(error) if error.kind == ErrorKind::Locked => {}
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
        assert!(FolderLock::take(home.path()).is_err_and(|error| error.kind == ErrorKind::Unwritten));
        assert_eq!(std::fs::read_to_string(&precious).expect("there"), "precious");
    }
}
