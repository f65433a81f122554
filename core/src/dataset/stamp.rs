//! Stamps of files, by which a changed file is recognised.
//!
//! By path, length, and the times at which a file was written and at which the system last changed anything about it,
//! which cannot be set. Where a time differs (access rights change it too) the checksum decides.

use crate::error::{Error, Result};
use crate::files::{self, path_text};
use crate::monitor::Monitor;
use serde::{Deserialize, Serialize};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::{fs::Metadata, time::UNIX_EPOCH};

/// Thoroughness of the comparison of files with their stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Comparison {
    /// By length and times; where the times differ, by content.
    #[default]
    Times,
    /// By content in all cases.
    Content,
    /// By length and times alone, without reading: a file with other times counts as changed.
    Glance,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct FileStamp {
    /// Path as text, see [`path_text`]: a name need not be text.
    path: String,
    bytes: u64,
    /// Nanoseconds since 1970; 0 where the system does not tell.
    modified_ns: u64,
    /// Nanoseconds since 1970; absent where the system does not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    changed_ns: Option<u64>,
    /// Checksum of the content; absent in stamps that are only compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    crc32: Option<u32>,
}

impl FileStamp {
    fn of(files: &[PathBuf]) -> Result<Vec<Self>> {
        files.iter().map(|path| Self::of_one(path).map_err(|e| Error::unread(path, &e))).collect()
    }

    /// Stamps of `files` with checksums. Times are taken before a file is read: one that changes meanwhile differs.
    pub fn with_checksums(files: &[PathBuf], monitor: &Monitor) -> Result<Vec<Self>> {
        let mut stamps = Self::of(files)?;
        for (stamp, path) in stamps.iter_mut().zip(files) {
            stamp.crc32 = Some(checksum(path, monitor)?);
        }
        Ok(stamps)
    }

    fn of_one(path: &Path) -> io::Result<Self> {
        let metadata = std::fs::metadata(path)?;
        let modified = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        let path = path_text(&std::path::absolute(path).unwrap_or_else(|_| path.into()));
        let modified_ns = modified.map_or(0, |since| since.as_nanos() as u64);
        let (bytes, changed_ns) = (metadata.len(), changed_ns(&metadata));
        Ok(Self { path, bytes, modified_ns, changed_ns, crc32: None })
    }

    pub fn all_agree(kept: &[Self], files: &[PathBuf], comparison: Comparison, monitor: &Monitor) -> Result<bool> {
        let now = Self::of(files)?;
        // Paths and lengths cost nothing, and mostly decide.
        let same_files = kept.len() == now.len()
            && kept.iter().zip(&now).all(|(kept, now)| kept.path == now.path && kept.bytes == now.bytes);
        if !same_files {
            return Ok(false);
        }
        for ((kept, now), path) in kept.iter().zip(&now).zip(files) {
            let same_times = (kept.modified_ns, kept.changed_ns) == (now.modified_ns, now.changed_ns);
            let agrees = match (same_times, comparison) {
                (true, Comparison::Times | Comparison::Glance) => true,
                (false, Comparison::Glance) => false,
                (_, Comparison::Times | Comparison::Content) => Some(checksum(path, monitor)?) == kept.crc32,
            };
            if !agrees {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The stamps `kept` with the times of `files` as they are now; their contents are the same.
    pub fn with_times_of(kept: &[Self], files: &[PathBuf]) -> Result<Vec<Self>> {
        let now = Self::of(files)?;
        Ok(kept.iter().zip(now).map(|(kept, now)| Self { crc32: kept.crc32, ..now }).collect())
    }

    pub fn content(&self) -> serde_json::Value {
        serde_json::json!({ "path": self.path, "bytes": self.bytes, "crc32": self.crc32 })
    }
}

#[cfg(unix)]
fn changed_ns(metadata: &Metadata) -> Option<u64> {
    use std::os::unix::fs::MetadataExt;
    let seconds = u64::try_from(metadata.ctime()).ok()?;
    seconds.checked_mul(1_000_000_000)?.checked_add(u64::try_from(metadata.ctime_nsec()).ok()?)
}

#[cfg(not(unix))]
fn changed_ns(_: &Metadata) -> Option<u64> {
    None
}

fn checksum(path: &Path, monitor: &Monitor) -> Result<u32> {
    let mut file = files::open(path).map_err(|e| Error::unread(path, &e))?;
    let (mut hasher, mut piece) = (crc32fast::Hasher::new(), vec![0; 1 << 18]);
    loop {
        monitor.check()?;
        match file.read(&mut piece) {
            Ok(0) => return Ok(hasher.finalize()),
            Ok(count) => hasher.update(&piece[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(Error::unread(path, &error)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn agree(kept: &[FileStamp], files: &[PathBuf], comparison: Comparison) -> bool {
        FileStamp::all_agree(kept, files, comparison, &Monitor::default()).expect("readable")
    }

    const ALL: [Comparison; 3] = [Comparison::Times, Comparison::Content, Comparison::Glance];

    #[test]
    fn a_file_of_the_same_length_and_date_is_told_from_the_one_that_was_read() {
        let home = tempfile::tempdir().expect("a folder");
        let path = home.path().join("a.png");
        let files = [path.clone()];
        std::fs::write(&path, "one").expect("written");
        let modified = std::fs::metadata(&path).and_then(|file| file.modified()).expect("a time");
        let kept = FileStamp::with_checksums(&files, &Monitor::default()).expect("readable");
        assert!(ALL.iter().all(|comparison| agree(&kept, &files, *comparison)));
        // The clock of the file system may stand still for some milliseconds.
        std::thread::sleep(std::time::Duration::from_millis(30));
        std::fs::write(&path, "two").expect("written");
        std::fs::File::options().write(true).open(&path).and_then(|file| file.set_modified(modified)).expect("set");
        assert!(!agree(&kept, &files, Comparison::Content));
        if cfg!(unix) {
            assert!(!agree(&kept, &files, Comparison::Times) && !agree(&kept, &files, Comparison::Glance));
        }
        // The same content written again: other times, so a glance reports a change.
        std::fs::write(&path, "one").expect("written");
        assert!(agree(&kept, &files, Comparison::Times) && agree(&kept, &files, Comparison::Content));
        if cfg!(unix) {
            assert!(!agree(&kept, &files, Comparison::Glance));
        }
        let renewed = FileStamp::with_times_of(&kept, &files).expect("readable");
        assert!(ALL.iter().all(|comparison| agree(&renewed, &files, *comparison)));
        std::fs::write(&path, "longer").expect("written");
        assert!(ALL.iter().all(|comparison| !agree(&kept, &files, *comparison)));
        assert!(ALL.iter().all(|comparison| !agree(&kept, &[], *comparison)));
        // Neither is one that cannot be read, nor a check that is cancelled.
        std::fs::write(&path, "two").expect("written");
        let cancelled = FileStamp::all_agree(&kept, &files, Comparison::Content, &Monitor::cancelled());
        assert!(cancelled.is_err_and(|error| error.is_cancelled()));
        std::fs::remove_file(&path).expect("removed");
        let gone = FileStamp::all_agree(&kept, &files, Comparison::Times, &Monitor::default());
        assert!(gone.as_ref().is_err_and(|error| error.problem.starts_with("cannot read this")), "{gone:?}");
    }
}
