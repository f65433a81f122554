//! Records of running windows: the automatically saved session of each, and the lock that marks its owner.
//!
//! All windows keep theirs in one folder: `NAME.toml`, the session, and `NAME.lock`, on which the window holds a lock
//! of the system as long as it lives. A session without a lock is one whose window did not end in the ordinary way.

use crate::export::write_whole;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

const SESSION: &str = "toml";
const LOCK: &str = "lock";

/// The record of one window, whose lock nobody else can take while this value lives.
#[derive(Debug)]
pub struct Record {
    pub session: PathBuf,
    newest: AtomicU64,
    /// Locked while writing or removing.
    held: Mutex<Held>,
}

#[derive(Debug)]
struct Held {
    /// `None` once the record was removed.
    lock: Option<File>,
    written: u64,
}

impl Record {
    pub fn new(folder: &Path) -> io::Result<Self> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        std::fs::create_dir_all(folder)?;
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let (seconds, process) = (since.as_secs(), std::process::id());
        loop {
            let name = format!("{seconds}-{process}-{}", COUNT.fetch_add(1, Ordering::Relaxed));
            let session = folder.join(name).with_extension(SESSION);
            if !session.exists()
                && let Some(lock) = locked(&session)?
            {
                return Ok(Self::of(session, lock));
            }
        }
    }

    fn of(session: PathBuf, lock: File) -> Self {
        Self { session, newest: AtomicU64::new(0), held: Mutex::new(Held { lock: Some(lock), written: 0 }) }
    }

    /// Records in `folder` whose windows did not end normally, the latest first. Takes over their locks.
    pub fn left_behind(folder: &Path) -> Vec<Self> {
        let mut found = Vec::new();
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if !path.extension().is_some_and(|extension| extension == SESSION || extension == LOCK) {
                continue;
            }
            let session = path.with_extension(SESSION);
            let Ok(Some(lock)) = locked(&session) else { continue };
            let record = Self::of(session, lock);
            match record.saved() {
                Some(saved) => found.push((saved, record)),
                // Its window had not saved a session yet.
                None => record.remove(),
            }
        }
        found.sort_by_key(|(saved, _)| std::cmp::Reverse(*saved));
        found.into_iter().map(|(_, record)| record).collect()
    }

    pub fn is_kept_in(folder: &Path) -> bool {
        let is_held = |path: PathBuf| {
            path.extension().is_some_and(|extension| extension == LOCK) && matches!(locked(&path), Ok(None))
        };
        std::fs::read_dir(folder).into_iter().flatten().flatten().any(|entry| is_held(entry.path()))
    }

    pub fn saved(&self) -> Option<SystemTime> {
        std::fs::metadata(&self.session).ok()?.modified().ok()
    }

    pub fn turn(&self) -> u64 {
        self.newest.fetch_add(1, Ordering::Relaxed) + 1
    }

    pub fn write(&self, text: &str) -> Result<(), String> {
        self.write_in_turn(text, self.turn())
    }

    /// Does nothing if a newer text was written meanwhile, or the record was removed.
    pub fn write_in_turn(&self, text: &str, turn: u64) -> Result<(), String> {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        if held.lock.is_none() || held.written > turn {
            return Ok(());
        }
        write_whole(&self.session, |out| out.write_all(text.as_bytes())).map_err(|error| error.to_string())?;
        held.written = turn;
        Ok(())
    }

    pub fn remove(&self) {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(lock) = held.lock.take() {
            // The session first: a lock without one is not offered. A session that cannot be removed is offered again.
            let _ = std::fs::remove_file(&self.session);
            let _ = std::fs::remove_file(self.session.with_extension(LOCK));
            drop(lock);
        }
    }
}

/// Locks `session`; `None` if the lock is held already, or its owner has just removed it.
fn locked(session: &Path) -> io::Result<Option<File>> {
    let path = session.with_extension(LOCK);
    let file = crate::files::open_as(&path, OpenOptions::new().create(true).truncate(false).write(true))?;
    match file.try_lock() {
        // Between opening and locking its owner may have removed it.
        Ok(()) => Ok(path.exists().then_some(file)),
        Err(TryLockError::WouldBlock) => Ok(None),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_had_to_wait_does_not_replace_a_newer_one() {
        let home = tempfile::tempdir().expect("a folder");
        let record = Record::new(home.path()).expect("made");
        let turn = record.turn();
        record.write("new").expect("written");
        record.write_in_turn("old", turn).expect("nothing to do");
        assert_eq!(std::fs::read_to_string(&record.session).expect("read"), "new");
    }
}
