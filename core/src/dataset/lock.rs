//! One process at a time writes into a dataset's folder.
//!
//! The system's own lock is taken on a file in the folder; it ends with the process that has it, however that ends. The
//! file's text names the owner, for whoever is refused.

use super::DatasetError;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;

/// The name of the file.
pub(crate) const LOCK_FILE: &str = ".burstscope-lock";

/// The right to write into a folder, as long as it lives.
#[derive(Debug)]
pub(crate) struct FolderLock {
    _file: File,
}

impl FolderLock {
    /// Takes the lock of `folder`, which is made.
    ///
    /// # Errors
    /// [`DatasetError::Locked`] when another process has it; [`DatasetError::Export`] when the folder cannot be
    /// written.
    pub(crate) fn take(folder: &Path) -> Result<Self, DatasetError> {
        let path = folder.join(LOCK_FILE);
        let failed = |error: std::io::Error| DatasetError::Export(crate::export::ExportError::write(&path, &error));
        std::fs::create_dir_all(folder).map_err(failed)?;
        let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = open.map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut owner = String::new();
                // Where a lock keeps others from reading, nobody can be named.
                let _ = file.read_to_string(&mut owner);
                let owner =
                    if owner.trim().is_empty() { "another process".to_owned() } else { owner.trim().to_owned() };
                return Err(DatasetError::Locked { folder: folder.into(), owner });
            }
            // A file system without locks: two processes are then the person's own affair, as before.
            Err(TryLockError::Error(error)) if error.kind() == std::io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(error)) => return Err(failed(error)),
        }
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        let on_host = if host.trim().is_empty() { String::new() } else { format!(" on {}", host.trim()) };
        file.set_len(0).and_then(|()| file.rewind()).map_err(failed)?;
        writeln!(file, "process {}{on_host}", std::process::id()).map_err(failed)?;
        Ok(Self { _file: file })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time_and_the_owner_is_named() {
        let home = tempfile::tempdir().expect("a folder");
        let folder = home.path().join("new");
        let first = FolderLock::take(&folder).expect("free");
        match FolderLock::take(&folder) {
            Err(DatasetError::Locked { owner, .. }) => {
                assert!(owner.contains(&format!("process {}", std::process::id())), "{owner}");
            }
            other => panic!("two have the lock: {other:?}"),
        }
        drop(first);
        FolderLock::take(&folder).expect("free again");
    }
}
