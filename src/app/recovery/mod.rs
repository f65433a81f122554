//! The session that the window saves by itself, and the offer to restore that of a window which did not end in the
//! ordinary way.
//!
//! A [`Recovery`] has a [`Record`] of its own, into which the session goes in the background: at most once in a while,
//! and only when something has changed. It holds the records that it found left behind, and offers them, one after the
//! other; nothing is restored unasked. One that is restored becomes the window's own, so that it is lost at no moment.

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

/// The session is saved at most this often.
pub const SAVED_EVERY: Duration = Duration::from_secs(10);

/// Where and how often windows save their sessions by themselves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeptIn {
    /// The folder of all windows' records.
    pub folder: PathBuf,
    /// At most this often.
    pub every: Duration,
}

/// A session that is offered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    /// What was open, in a few words.
    pub label: String,
    /// How long ago it was saved.
    pub age: Duration,
    /// How many more there are.
    pub more: usize,
    /// Whether it is being restored.
    pub is_restoring: bool,
}

/// A session that is to be written.
#[derive(Debug)]
pub struct DueSession {
    record: Arc<Record>,
    turn: Turn,
    text: String,
}

impl DueSession {
    /// Writes it, unless a newer one was written meanwhile.
    ///
    /// # Errors
    /// Why it cannot be written, as a sentence.
    pub fn write(&self) -> Result<(), String> {
        self.record.write_in_turn(&self.text, self.turn)
    }
}

/// How the writing of a session ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WritingEnded {
    /// It is written.
    Well,
    /// It is written, which it could not be before.
    WellAgain,
    /// It could not be written.
    Failed,
    /// It could not be written, for the reason for which the one before could not.
    FailedAgain,
}

/// What one window keeps for the case that it does not end in the ordinary way, and what others have left so.
#[derive(Debug)]
pub struct Recovery {
    own: Arc<Record>,
    every: Duration,
    /// What was written last.
    written: Option<String>,
    /// What is being written.
    given: Option<String>,
    /// Why the last writing failed, if it did.
    failed: Option<String>,
    /// When it was last looked whether something has changed.
    looked: Option<Instant>,
    writing: Option<TaskId>,
    left: VecDeque<(Record, String)>,
    restoring: Option<JobId>,
}

impl Recovery {
    /// A new window's.
    ///
    /// # Errors
    /// Why nothing can be kept there.
    pub fn new(kept: &KeptIn) -> io::Result<Self> {
        let own = Arc::new(Record::new(&kept.folder)?);
        // One that this program cannot read, of a newer one say, is left to those who can.
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

    /// What is to be written now, of what `session` says. Otherwise how long to wait before asking again, if that is
    /// needed.
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
    /// Why it cannot be written, as a sentence.
    pub fn write_now(&self, text: &str) -> Result<(), String> {
        self.own.write(text)
    }

    /// It is being written.
    pub fn begun(&mut self, task: TaskId) {
        self.writing = Some(task);
    }

    /// What became of the writing of the session, if the task that ended with `result` was that. What could not be
    /// written is due again after a while.
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

    /// What is offered.
    pub fn offer(&self) -> Option<Offer> {
        let (record, label) = self.left.front()?;
        let age = record.saved().and_then(|saved| SystemTime::now().duration_since(saved).ok()).unwrap_or_default();
        Some(Offer { label: label.clone(), age, more: self.left.len() - 1, is_restoring: self.restoring.is_some() })
    }

    /// The session file that is offered.
    pub fn offered(&self) -> Option<&Path> {
        self.left.front().map(|(record, _)| record.session())
    }

    /// Forgets what is offered, for good.
    pub fn forget(&mut self) {
        if self.restoring.is_none()
            && let Some((record, _)) = self.left.pop_front()
        {
            record.remove();
        }
    }

    /// What is offered is being restored, as this request.
    pub fn is_restored_by(&mut self, request: JobId) {
        self.restoring = Some(request);
    }

    /// A request to restore a session has ended. If it was that of the offer and did what it should, the record is the
    /// window's own from now on, in place of the one that it had; otherwise it is offered still.
    pub fn restored(&mut self, request: JobId, is_done: bool) {
        if self.restoring.take_if(|restoring| *restoring == request).is_some()
            && is_done
            && let Some((record, _)) = self.left.pop_front()
        {
            std::mem::replace(&mut self.own, Arc::new(record)).remove();
            self.written = None;
        }
    }

    /// The window ends in the ordinary way: its own record goes.
    pub fn end(&self) {
        self.own.remove();
    }
}
