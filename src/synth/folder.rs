//! A folder that is written whole or not at all: everything goes into a hidden folder beside the target, which then
//! takes the target's place.

use crate::monitor::Cancelled;
use std::path::{Path, PathBuf};

/// Why a burst was not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteBurstError {
    /// The folder holds something that is not an earlier synthetic burst.
    #[error("the folder holds files that are not a synthetic burst; name a new or an empty folder: {}", .0.display())]
    Occupied(PathBuf),
    /// Writing failed.
    #[error("cannot write: {source}: {}", .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It was cancelled; nothing was written.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What turns a failure at `path` into an error.
pub(super) fn io(path: &Path) -> impl Fn(std::io::Error) -> WriteBurstError + use<> {
    let path = path.to_owned();
    move |source| WriteBurstError::Io { path: path.clone(), source }
}

/// Makes the folder `dir` by `fill`, which writes into the empty folder that it is given. What is in `dir` is replaced
/// as a whole if `replaceable` says so (an empty folder always is), and otherwise left alone.
///
/// # Errors
/// See [`WriteBurstError`]; the folder is then as it was before.
pub(super) fn write_folder(
    dir: &Path,
    replaceable: impl FnOnce(&Path) -> std::io::Result<bool>,
    fill: impl FnOnce(&Path) -> Result<(), WriteBurstError>,
) -> Result<(), WriteBurstError> {
    let empty = || Ok(dir.is_dir() && std::fs::read_dir(dir)?.next().is_none());
    if dir.exists() && !empty().map_err(io(dir))? && !replaceable(dir).map_err(io(dir))? {
        return Err(WriteBurstError::Occupied(dir.to_owned()));
    }
    let parent = match dir.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    std::fs::create_dir_all(&parent).map_err(io(&parent))?;
    let stage = tempfile::Builder::new().prefix(".synth-").tempdir_in(&parent).map_err(io(&parent))?;
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
