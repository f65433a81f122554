//! Unfinished work: hidden folders in which files and folders are completed before they take their places.
//!
//! A killed run leaves its hidden folder; the next run that writes there removes it. A mark in a file in it identifies
//! it; a system lock on that file, which ends with its process, shows that it is in use. Nothing else is removed.

use super::lock::{HIDDEN_PREFIX, is_lock};
use super::mark::{OutputKind, claiming, claims};
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::{collections::HashSet, ffi::OsStr};
use tempfile::TempDir;

const SUFFIX: &str = ".tmp";
/// Number of folders that are begun, if other runs remove them before they are marked.
const TRIES: usize = 8;
const NEW: &str = "new";
/// Name of the replaced folder, for the moment of the exchange.
const OLD: &str = "old";

/// Hidden folder of unfinished work; removed when it is dropped.
#[derive(Debug)]
pub struct Unfinished {
    /// Locked file with the mark; closed before the folder is removed.
    _in_use: File,
    folder: TempDir,
}

#[derive(Debug, Serialize, Deserialize)]
struct Making {
    /// Name of what is made, beside the hidden folder; `None` for a name that is no text.
    target: Option<String>,
}

impl Unfinished {
    /// Makes a hidden folder beside `target`; at first in a process, those that killed runs have left are removed.
    pub fn beside(target: &Path) -> io::Result<Self> {
        let parent = target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        static SEEN: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
        let known = std::path::absolute(parent).unwrap_or_else(|_| parent.to_path_buf());
        if SEEN.lock().unwrap_or_else(PoisonError::into_inner).insert(known) {
            remove_abandoned(parent);
        }
        let target = target.file_name().and_then(OsStr::to_str).map(str::to_owned);
        let mark = claiming(OutputKind::Unfinished, &Making { target });
        for _ in 0..TRIES {
            let folder =
                tempfile::Builder::new().prefix(&format!("{HIDDEN_PREFIX}-")).suffix(SUFFIX).tempdir_in(parent)?;
            let path = folder.path().join(OutputKind::Unfinished.file());
            let mut in_use = match File::create_new(&path) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                created => created?,
            };
            // The mark is written when the file is locked. On a file system without locks nothing is removed either.
            let _ = in_use.lock();
            in_use.write_all(mark.as_bytes())?;
            // Before the lock another run could remove the folder as the rest of a killed run.
            if path.exists() {
                return Ok(Self { _in_use: in_use, folder });
            }
        }
        Err(io::Error::other("other runs remove what this one begins"))
    }

    /// Path of the file or folder that is to be completed; it does not exist yet.
    pub fn new_path(&self) -> PathBuf {
        self.folder.path().join(NEW)
    }

    /// Puts the complete folder in the place of `target`, and returns true. An existing one is moved away first and
    /// removed if `may_go` then agrees; otherwise, and after an error, it is put back.
    pub fn put_folder(&self, target: &Path, may_go: impl FnOnce(&Path) -> io::Result<bool>) -> io::Result<bool> {
        let old = self.folder.path().join(OLD);
        let is_there = target.exists();
        if is_there {
            std::fs::rename(target, &old)?;
        }
        let may_go = if is_there { may_go(&old) } else { Ok(true) };
        let put =
            may_go.and_then(|may| if may { std::fs::rename(self.new_path(), target).map(|()| true) } else { Ok(may) });
        if is_there && !matches!(put, Ok(true)) {
            std::fs::rename(&old, target)?;
        }
        put
    }
}

/// Whether `folder` holds nothing but locks and unfinished work that runs of this program left, or does not exist.
pub fn is_free(folder: &Path) -> io::Result<bool> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(true),
        entries => entries?,
    };
    for entry in entries {
        let path = entry?.path();
        if !is_lock(&path) && !is_unfinished(&path) {
            return Ok(false);
        }
    }
    Ok(true)
}

fn is_unfinished(folder: &Path) -> bool {
    let name = folder.file_name().and_then(OsStr::to_str).unwrap_or_default();
    name.starts_with(HIDDEN_PREFIX)
        && name.ends_with(SUFFIX)
        && std::fs::symlink_metadata(folder).is_ok_and(|found| found.is_dir())
        && claims::<Making>(folder, OutputKind::Unfinished).is_some()
}

/// Removes the unfinished work of killed runs from `parent`. A folder that one was replacing is put back.
pub fn remove_abandoned(parent: &Path) {
    for entry in std::fs::read_dir(parent).into_iter().flatten().flatten() {
        let hidden = entry.path();
        if !is_unfinished(&hidden) {
            remove_unmarked(&hidden);
            continue;
        }
        let in_use = hidden.join(OutputKind::Unfinished.file());
        let Ok(lock) = super::open_as(&in_use, OpenOptions::new().write(true)) else { continue };
        if lock.try_lock().is_err() {
            continue;
        }
        let (old, claimed) = (hidden.join(OLD), claims::<Making>(&hidden, OutputKind::Unfinished));
        if old.exists() {
            let Some(target) = claimed.and_then(|claimed| claimed.target) else { continue };
            let target = parent.join(target);
            let is_put_back = !target.exists() && std::fs::rename(&old, &target).is_ok();
            // If the new folder has not come into its place, nobody has agreed that the old one may go.
            if !is_put_back && hidden.join(NEW).exists() {
                continue;
            }
        }
        // What cannot be removed does no harm.
        for part in [hidden.join(NEW), old] {
            let _ = if part.is_dir() { std::fs::remove_dir_all(&part) } else { std::fs::remove_file(&part) };
        }
        let _ = std::fs::remove_file(&in_use);
        let _ = std::fs::remove_dir(&hidden);
    }
}

/// Removes a hidden folder of a run that was killed before marking it: empty, or with an empty file for the mark.
fn remove_unmarked(hidden: &Path) {
    let name = hidden.file_name().and_then(OsStr::to_str).unwrap_or_default();
    let is_folder = std::fs::symlink_metadata(hidden).is_ok_and(|found| found.is_dir());
    if !(name.starts_with(HIDDEN_PREFIX) && name.ends_with(SUFFIX) && is_folder) {
        return;
    }
    let path = hidden.join(OutputKind::Unfinished.file());
    let mark = super::open_as(&path, OpenOptions::new().write(true)).ok();
    if mark.as_ref().is_some_and(|mark| mark.try_lock().is_ok() && mark.metadata().is_ok_and(|found| found.len() == 0))
    {
        let _ = std::fs::remove_file(&path);
    }
    // A folder with other content stays.
    let _ = std::fs::remove_dir(hidden);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leaves unfinished work as a killed run does, with these parts.
    fn left(target: &Path, parts: &[&str]) -> PathBuf {
        let Unfinished { folder, _in_use } = Unfinished::beside(target).expect("made");
        for part in parts {
            std::fs::create_dir(folder.path().join(part)).expect("made");
            std::fs::write(folder.path().join(part).join("truth.json"), part).expect("written");
        }
        folder.keep()
    }

    #[test]
    fn what_killed_runs_left_is_removed_and_what_is_in_use_or_somebodys_stays() {
        let home = tempfile::tempdir().expect("a folder");
        let at = |name: &str| home.path().join(name);
        let begun = left(&at("a"), &["new"]);
        let replaced = left(&at("b"), &["new", "old"]);
        let used = Unfinished::beside(&at("c")).expect("made");
        let holding = left(&at("d"), &[]);
        std::fs::write(holding.join("thesis.txt"), "precious").expect("written");
        std::fs::create_dir(at(".burstscope-own.tmp")).expect("made");
        std::fs::write(at(".burstscope-own.tmp/in-use"), "mine").expect("written");
        std::fs::write(at(".burstscope-notes.tmp"), "mine").expect("written");
        let unmarked = [at(".burstscope-empty.tmp"), at(".burstscope-unmarked.tmp")];
        unmarked.iter().for_each(|folder| std::fs::create_dir(folder).expect("made"));
        std::fs::write(unmarked[1].join(OutputKind::Unfinished.file()), "").expect("written");
        remove_abandoned(home.path());
        assert!(unmarked.iter().all(|folder| !folder.exists()), "killed before they were marked");
        assert!(!begun.exists() && !replaced.exists() && used.folder.path().exists());
        assert!(at(".burstscope-own.tmp/in-use").exists() && at(".burstscope-notes.tmp").exists());
        assert_eq!(std::fs::read_to_string(holding.join("thesis.txt")).expect("there"), "precious");
        assert!(!at("a").exists());
        assert_eq!(std::fs::read_to_string(at("b/truth.json")).expect("put back"), "old");
        remove_abandoned(&at("none"));
    }

    #[test]
    fn a_folder_that_may_not_go_is_put_back() {
        let home = tempfile::tempdir().expect("a folder");
        let target = home.path().join("a");
        std::fs::create_dir(&target).expect("made");
        std::fs::write(target.join("thesis.txt"), "precious").expect("written");
        let unfinished = Unfinished::beside(&target).expect("made");
        std::fs::create_dir(unfinished.new_path()).expect("made");
        for refused in [Ok(false), Err(io::Error::other("it cannot be read"))] {
            assert!(
                !unfinished.put_folder(&target, |_| refused).unwrap_or(false) && target.join("thesis.txt").exists()
            );
        }
        assert!(unfinished.put_folder(&target, |_| Ok(true)).expect("replaced"));
        assert!(target.exists() && !target.join("thesis.txt").exists());
        drop(unfinished);
        assert_eq!(std::fs::read_dir(home.path()).expect("a folder").count(), 1);
    }
}
