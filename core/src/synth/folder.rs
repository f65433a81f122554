//! A folder that is written completely or not at all: everything goes into a hidden folder beside the target, which
//! then replaces the target.
//!
//! A killed run leaves its hidden folder; the next one that writes there removes it. A system lock on a file in it,
//! which ends with its process, shows that it is still in use. Another lock, beside the target, keeps two processes
//! from making the same folder.

use crate::files::lock::{FolderLock, LockError, is_free};
use crate::files::write_problem;
use crate::monitor::Cancelled;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Reason why a burst was not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteBurstError {
    /// The folder holds files that are no earlier synthetic burst.
    #[error("the folder holds files that are not a synthetic burst; name a new or an empty folder: {}", .0.display())]
    Occupied(PathBuf),
    /// Writing failed.
    #[error("cannot write: {}: {}", write_problem(.source), .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The folder's name is that of a link, which the new folder would replace.
    #[error("this is a link, and links are not followed; name the folder itself: {}", .0.display())]
    Link(PathBuf),
    /// Another process makes the folder.
    #[error(transparent)]
    Lock(#[from] LockError),
    /// The work was cancelled; nothing was written.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Converter of a failure at `path` into an error.
pub(super) fn io(path: &Path) -> impl Fn(std::io::Error) -> WriteBurstError + use<> {
    let path = path.to_owned();
    move |source| WriteBurstError::Io { path: path.clone(), source }
}

/// Makes the folder `dir` by `fill`, which writes into the empty folder that it is given. An existing `dir` is replaced
/// as a whole if `replaceable` returns true (an empty folder always is), and otherwise left unchanged. Meanwhile no
/// other process can make it.
///
/// # Errors
/// See [`WriteBurstError`]; the folder is then unchanged.
pub(super) fn write_folder(
    dir: &Path,
    replaceable: impl FnOnce(&Path) -> std::io::Result<bool>,
    fill: impl FnOnce(&Path) -> Result<(), WriteBurstError>,
) -> Result<(), WriteBurstError> {
    if std::fs::symlink_metadata(dir).is_ok_and(|metadata| metadata.is_symlink()) {
        return Err(WriteBurstError::Link(dir.to_owned()));
    }
    let _lock = FolderLock::beside(dir)?;
    if !is_free(dir).map_err(io(dir))? && !replaceable(dir).map_err(io(dir))? {
        return Err(WriteBurstError::Occupied(dir.to_owned()));
    }
    let parent = match dir.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    remove_abandoned(&parent);
    let stage = tempfile::Builder::new().prefix(STAGE_PREFIX).tempdir_in(&parent).map_err(io(&parent))?;
    let _in_use = locked(&stage.path().join(LOCK_FILE), dir).map_err(io(stage.path()))?;
    let fresh = stage.path().join("new");
    std::fs::create_dir(&fresh).map_err(io(&fresh))?;
    fill(&fresh)?;
    let old = stage.path().join("old");
    if dir.exists() {
        std::fs::rename(dir, &old).map_err(io(dir))?;
    }
    if let Err(source) = std::fs::rename(&fresh, dir) {
        if old.exists() {
            std::fs::rename(&old, dir).map_err(io(dir))?;
        }
        return Err(WriteBurstError::Io { path: dir.to_owned(), source });
    }
    Ok(())
}

const STAGE_PREFIX: &str = ".synth-";
/// File in a hidden folder whose lock shows that it is in use; its text is the name of the folder that is made.
const LOCK_FILE: &str = "in-use";

fn locked(path: &Path, target: &Path) -> std::io::Result<File> {
    let file = File::create_new(path)?;
    // A file system without locks: then nothing is removed either.
    let _ = file.try_lock();
    let name = target.file_name().unwrap_or_default();
    (&file).write_all(name.as_encoded_bytes())?;
    Ok(file)
}

/// Removes the hidden folders in `parent` that killed runs have left. If a run was killed between moving the old folder
/// away and putting the new one there, the new one, which was complete by then, is moved to its place.
fn remove_abandoned(parent: &Path) {
    for entry in std::fs::read_dir(parent).into_iter().flatten().flatten() {
        let stage = entry.path();
        let is_stage = entry.file_name().to_str().is_some_and(|name| name.starts_with(STAGE_PREFIX));
        if !is_stage {
            continue;
        }
        let Ok(lock) = OpenOptions::new().write(true).open(stage.join(LOCK_FILE)) else { continue };
        if lock.try_lock().is_err() {
            continue;
        }
        if stage.join("old").exists()
            && let Ok(name) = std::fs::read_to_string(stage.join(LOCK_FILE))
            && !name.is_empty()
            && !parent.join(&name).exists()
            && std::fs::rename(stage.join("new"), parent.join(&name)).is_err()
        {
            continue;
        }
        // A folder that cannot be removed does no harm.
        let _ = std::fs::remove_dir_all(&stage);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a hidden folder as a killed run leaves it.
    fn left(parent: &Path, name: &str, target: &str, parts: &[&str]) -> PathBuf {
        let stage = parent.join(name);
        std::fs::create_dir(&stage).expect("made");
        drop(locked(&stage.join(LOCK_FILE), Path::new(target)).expect("locked"));
        for part in parts {
            std::fs::create_dir(stage.join(part)).expect("made");
            std::fs::write(stage.join(part).join("truth.json"), part).expect("written");
        }
        stage
    }

    #[test]
    fn what_killed_runs_left_is_removed_and_what_is_in_use_stays() {
        let home = tempfile::tempdir().expect("a folder");
        let begun = left(home.path(), ".synth-a", "a", &["new"]);
        let replaced = left(home.path(), ".synth-b", "b", &["new", "old"]);
        let used = left(home.path(), ".synth-c", "c", &["new"]);
        let lock = OpenOptions::new().write(true).open(used.join(LOCK_FILE)).expect("there");
        lock.try_lock().expect("free");
        std::fs::create_dir(home.path().join(".synth-own")).expect("made");
        write_folder(&home.path().join("d"), |_| Ok(false), |_| Ok(())).expect("written");
        assert!(!begun.exists() && !replaced.exists() && used.exists() && home.path().join(".synth-own").exists());
        assert!(!home.path().join("a").exists() && home.path().join("d").is_dir());
        assert_eq!(std::fs::read_to_string(home.path().join("b/truth.json")).expect("put there"), "new");
    }
}
