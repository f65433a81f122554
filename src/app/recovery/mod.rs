//! Automatic saving of the window's session, and the offer to restore that of a window that did not end normally.
//!
//! A [`Recovery`] has a [`Record`] of its own, into which the session is written in the background: at a limited rate,
//! and only after changes. It holds the records that other windows left behind, and offers them one after the other;
//! nothing is restored unasked. A restored record becomes the window's own, so that its session is never lost.

mod record;

pub use record::{Record, Turn};

use super::session::Session;
use crate::engine::TaskId;
use crate::files::{MAX_SESSION_BYTES, read_text};
use crate::requests::JobId;
use std::collections::VecDeque;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

/// Shortest time between two savings of the session.
pub const SAVED_EVERY: Duration = Duration::from_secs(10);

/// Folder and interval of automatic saving.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeptIn {
    /// The folder of all windows' records.
    pub folder: PathBuf,
    /// Shortest time between two savings.
    pub every: Duration,
}

/// Offer to restore a session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    /// The burst that was open, in a few words.
    pub label: String,
    /// Time since it was saved.
    pub age: Duration,
    /// Number of further sessions that can be offered.
    pub more: usize,
    /// Whether it is being restored.
    pub is_restoring: bool,
}

/// Text of a session that is due for writing.
#[derive(Debug)]
pub struct DueSession {
    record: Arc<Record>,
    turn: Turn,
    text: String,
}

impl DueSession {
    /// Writes the session, unless a newer one was written meanwhile.
    ///
    /// # Errors
    /// When it cannot be written; the message is a sentence.
    pub fn write(&self) -> Result<(), String> {
        self.record.write_in_turn(&self.text, self.turn)
    }
}

/// Result of writing a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WritingEnded {
    /// It was written.
    Well,
    /// It was written, after earlier failures.
    WellAgain,
    /// It could not be written.
    Failed,
    /// It could not be written, for the reason of the last failure.
    FailedAgain,
}

/// The record of a window, and the records that other windows left behind.
#[derive(Debug)]
pub struct Recovery {
    own: Arc<Record>,
    every: Duration,
    /// The text that was written last.
    written: Option<String>,
    /// The text that is being written.
    given: Option<String>,
    /// Reason why the last writing failed, if it did.
    failed: Option<String>,
    /// Time of the last check for changes.
    looked: Option<Instant>,
    writing: Option<TaskId>,
    left: VecDeque<(Record, String)>,
    restoring: Option<JobId>,
}

impl Recovery {
    /// Creates the record of a new window, and collects those left behind.
    ///
    /// # Errors
    /// When no record can be created in the folder.
    pub fn new(kept: &KeptIn) -> io::Result<Self> {
        let own = Arc::new(Record::new(&kept.folder)?);
        // A session that this program cannot read, of a newer version for example, is left in place.
        let readable = |record: Record| {
            let text = read_text(record.session(), MAX_SESSION_BYTES).ok()?;
            let session = Session::from_toml(&text).ok()?;
            Some((record, session.burst.label()))
        };
        let left = Record::left_behind(&kept.folder).into_iter().filter_map(readable).collect();
        let (written, given, failed) = (None, None, None);
        let (looked, writing, restoring) = (None, None, None);
        Ok(Self { own, every: kept.every, written, given, failed, looked, writing, left, restoring })
    }

    /// Session to be written now, from the text of `session`. The error is the time to wait before calling again, or
    /// `None` if nothing is due.
    pub fn due(&mut self, session: impl FnOnce() -> Option<String>) -> Result<DueSession, Option<Duration>> {
        if self.writing.is_some() || self.restoring.is_some() {
            return Err(None);
        }
        let since = self.looked.map(|looked| looked.elapsed());
        if let Some(rest) = since.and_then(|since| self.every.checked_sub(since)).filter(|rest| !rest.is_zero()) {
            return Err(Some(rest));
        }
        self.looked = Some(Instant::now());
        let text = session().ok_or(None)?;
        if self.written.as_ref() == Some(&text) {
            return Err(None);
        }
        self.given = Some(text.clone());
        Ok(DueSession { record: self.own.clone(), turn: self.own.turn(), text })
    }

    /// Writes `text` at once.
    ///
    /// # Errors
    /// When it cannot be written; the message is a sentence.
    pub fn write_now(&self, text: &str) -> Result<(), String> {
        self.own.write(text)
    }

    /// Notes the task that is writing the session.
    pub fn begun(&mut self, task: TaskId) {
        self.writing = Some(task);
    }

    /// Result of writing the session, if `task` was writing it. After a failure the session is due again at the next
    /// interval.
    pub fn has_ended(&mut self, task: TaskId, result: Result<(), &str>) -> Option<WritingEnded> {
        self.writing.take_if(|writing| *writing == task)?;
        let given = self.given.take();
        match result {
            Ok(()) => {
                self.written = given;
                Some(self.failed.take().map_or(WritingEnded::Well, |_| WritingEnded::WellAgain))
            }
            Err(why) if self.failed.as_deref() == Some(why) => Some(WritingEnded::FailedAgain),
            Err(why) => {
                self.failed = Some(why.to_owned());
                Some(WritingEnded::Failed)
            }
        }
    }

    /// The offer to show, if there is one.
    pub fn offer(&self) -> Option<Offer> {
        let (record, label) = self.left.front()?;
        let age = record.saved().and_then(|saved| SystemTime::now().duration_since(saved).ok()).unwrap_or_default();
        Some(Offer { label: label.clone(), age, more: self.left.len() - 1, is_restoring: self.restoring.is_some() })
    }

    /// The session file that is offered.
    pub fn offered(&self) -> Option<&Path> {
        self.left.front().map(|(record, _)| record.session())
    }

    /// Deletes the offered session, unless it is being restored.
    pub fn forget(&mut self) {
        if self.restoring.is_none()
            && let Some((record, _)) = self.left.pop_front()
        {
            record.remove();
        }
    }

    /// Notes the request that restores the offered session.
    pub fn is_restored_by(&mut self, request: JobId) {
        self.restoring = Some(request);
    }

    /// Takes the end of a request to restore a session. If it was that of the offer and `is_done`, the offered record
    /// replaces the window's own; otherwise it stays offered.
    pub fn restored(&mut self, request: JobId, is_done: bool) {
        if self.restoring.take_if(|restoring| *restoring == request).is_some()
            && is_done
            && let Some((record, _)) = self.left.pop_front()
        {
            std::mem::replace(&mut self.own, Arc::new(record)).remove();
            self.written = None;
        }
    }

    /// Removes the window's own record: the window ends normally.
    pub fn end(&self) {
        self.own.remove();
    }
}
