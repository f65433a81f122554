//! Automatic saving of the window's session, and the offer to restore that of a window that did not end normally.
//! Nothing is restored unasked. A restored record becomes the window's own, so that its session is never lost.

mod record;

pub use record::Record;

use super::document::Journal;
use super::session::Session;
use crate::app::{messages::Messages, results::Read};
use crate::engine::{Engine, TaskDone, TaskId};
use crate::files::{MAX_SESSION_BYTES, read_text, written_by};
use crate::requests::JobId;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

const TITLE: &str = "Save the session by itself";

pub const SAVED_EVERY: Duration = Duration::from_secs(10);

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeptIn {
    pub folder: PathBuf,
    pub every: Duration,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    pub label: String,
    pub age: Duration,
    pub more: usize,
    pub is_restoring: bool,
    pub is_asking: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecoveryChoice {
    Restore,
    /// Offer it again at the next start.
    Later,
    /// Ask whether to remove it.
    Discard,
    Remove,
    Keep,
}

fn session_text(project: Read<'_>, did: &Journal) -> Option<String> {
    Some(written_by() + &did.last_lines() + &Session::of(project)?.to_toml())
}

#[derive(Debug)]
pub struct Recovery {
    own: Arc<Record>,
    every: Duration,
    written: Option<String>,
    given: Option<String>,
    failed: Option<String>,
    looked: Option<Instant>,
    writing: Option<TaskId>,
    left: std::collections::VecDeque<(Record, String)>,
    /// Request that opens the burst of the session that is restored.
    pub restoring: Option<JobId>,
    pub is_asking: bool,
}

impl Recovery {
    pub fn new(kept: &KeptIn) -> std::io::Result<Self> {
        let own = Arc::new(Record::new(&kept.folder)?);
        // A session that this program cannot read, of a newer version for example, is left in place.
        let readable = |record: Record| {
            let text = read_text(&record.session, MAX_SESSION_BYTES).ok()?;
            Some((record, Session::from_toml(&text).ok()?.burst.label()))
        };
        let left = Record::left_behind(&kept.folder).into_iter().filter_map(readable).collect();
        let (written, given, failed) = (None, None, None);
        let (looked, writing, restoring) = (None, None, None);
        Ok(Self { own, every: kept.every, written, given, failed, looked, writing, left, restoring, is_asking: false })
    }

    pub fn begin(kept: Option<&KeptIn>, messages: &mut Messages) -> Option<Self> {
        let (kept, end) = (kept?, "until then, nothing can be restored after a crash");
        let begun = Self::new(kept).map_err(|error| format!("{error}: {}; {end}", kept.folder.display()));
        messages.settle(TITLE, begun)
    }

    /// Returns the time to wait before calling again, if nothing else happens.
    pub fn keep(&mut self, project: Read<'_>, did: &Journal, engine: &Engine) -> Option<Duration> {
        if self.writing.is_some() || self.restoring.is_some() {
            return None;
        }
        let since = self.looked.map(|looked| looked.elapsed());
        if let Some(rest) = since.and_then(|since| self.every.checked_sub(since)).filter(|rest| !rest.is_zero()) {
            return Some(rest);
        }
        self.looked = Some(Instant::now());
        let text = session_text(project, did).filter(|text| self.written.as_ref() != Some(text))?;
        self.given = Some(text.clone());
        // A late write must not replace a newer text: its turn orders it among the others.
        let (record, turn) = (self.own.clone(), self.own.turn());
        self.writing = Some(engine.task(TITLE, move || record.write_in_turn(&text, turn).map(|()| String::new())));
        None
    }

    /// Another window goes on with it, and if that fails it is offered later. The error: title and text of a message.
    pub fn keep_now(&self, project: Read<'_>, did: &Journal) -> Result<(), (&'static str, String)> {
        session_text(project, did).map_or(Ok(()), |text| self.own.write(&text).map_err(|error| (TITLE, error)))
    }

    /// A failure is reported once for each reason, and the session is due again at the next interval.
    pub fn has_kept(&mut self, done: &TaskDone, messages: &mut Messages) -> bool {
        if self.writing.take_if(|writing| *writing == done.id).is_none() {
            return false;
        }
        let given = self.given.take();
        match &done.result {
            Ok(_) => {
                self.written = given;
                if self.failed.take().is_some() {
                    messages.resolved(TITLE);
                }
            }
            Err(error) => {
                let why = error.to_string();
                if self.failed.as_ref() != Some(&why) {
                    messages.error(TITLE, why.clone());
                    self.failed = Some(why);
                }
            }
        }
        true
    }

    pub fn settle(&mut self, choice: RecoveryChoice, messages: &mut Messages) -> Option<PathBuf> {
        self.is_asking = choice == RecoveryChoice::Discard;
        match choice {
            RecoveryChoice::Discard | RecoveryChoice::Keep => {}
            // Files and the other windows' turn at them stay; this window has no more to do with them.
            RecoveryChoice::Later => self.left.clear(),
            RecoveryChoice::Remove => {
                let offered = if self.restoring.is_none() { self.left.pop_front() } else { None };
                offered.into_iter().for_each(|(record, _)| record.remove());
                messages.note("Removed the saved session");
            }
            RecoveryChoice::Restore => return Some(self.left.front()?.0.session.clone()),
        }
        None
    }

    pub fn offer(&self) -> Option<Offer> {
        let (record, label) = self.left.front()?;
        let age = record.saved().and_then(|saved| SystemTime::now().duration_since(saved).ok()).unwrap_or_default();
        let (is_restoring, is_asking) = (self.restoring.is_some(), self.is_asking);
        Some(Offer { label: label.clone(), age, more: self.left.len() - 1, is_restoring, is_asking })
    }

    /// If it was that of the offer and `is_done`, the offered record replaces the window's own.
    pub fn restored(&mut self, request: JobId, is_done: bool) {
        if self.restoring.take_if(|restoring| *restoring == request).is_some()
            && is_done
            && let Some((record, _)) = self.left.pop_front()
        {
            // The restored record goes on as the window's own: its session is in a file at any time.
            std::mem::replace(&mut self.own, Arc::new(record)).remove();
            self.written = None;
        }
    }

    pub fn end(&self) {
        self.own.remove();
    }
}
