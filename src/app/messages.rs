//! Messages of the window: errors stay until they are dismissed, a note until the next one.

use crate::app::document::Purpose;
use crate::requests::JobError;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    pub id: u64,
    pub title: String,
    pub text: String,
}

#[derive(Debug, Clone, Default)]
pub struct Messages {
    pub errors: Vec<Message>,
    pub note: Option<String>,
    /// Question that the system's dialog left open, and the name it suggested; its path can be typed instead.
    pub unanswered: Option<(Purpose, String)>,
    newest: u64,
}

/// Largest number of open errors; a further one removes the oldest.
const MAX_ERRORS: usize = 4;

impl Messages {
    /// Shows an error until it is dismissed. The same error again is shown once.
    pub fn error(&mut self, title: impl Into<String>, text: impl Into<String>) {
        let (title, text) = (title.into(), text.into());
        self.errors.retain(|m| m.title != title || m.text != text);
        self.newest += 1;
        self.errors.push(Message { id: self.newest, title, text });
        if self.errors.len() > MAX_ERRORS {
            self.errors.remove(0);
        }
    }

    pub fn note(&mut self, text: impl Into<String>) {
        self.note = Some(text.into());
        self.unanswered = None;
    }

    /// The path can be typed instead, until the next note.
    pub fn note_unanswered(&mut self, purpose: Purpose, suggested_name: String, why: &str) {
        self.note(format!("{}: {why}", purpose.title()));
        self.unanswered = Some((purpose, suggested_name));
    }

    pub fn forget_note(&mut self) {
        (self.note, self.unanswered) = (None, None);
    }

    pub fn dismiss(&mut self, id: u64) {
        self.errors.retain(|m| m.id != id);
    }

    pub fn resolved(&mut self, title: &str) {
        self.errors.retain(|m| m.title != title);
    }

    /// The answer to a request; a failure becomes an error with this title, unless it was cancelled.
    pub fn answer<T>(&mut self, result: Result<T, JobError>, title: &str) -> Option<T> {
        match result {
            Ok(answer) => return Some(answer),
            Err(JobError::Cancelled) => {}
            Err(error) => self.error(title, error.to_string()),
        }
        None
    }

    /// The answer, with which earlier failures are forgotten; a cancel becomes a note.
    pub fn outcome<T>(&mut self, result: Result<T, JobError>, title: &str) -> Option<T> {
        match &result {
            Ok(_) => self.resolved(title),
            Err(JobError::Cancelled) => self.note(format!("{title} cancelled")),
            Err(error) => self.error(title, error.to_string()),
        }
        result.ok()
    }

    /// Says why something failed, or forgets that it did before.
    pub fn settle<T>(&mut self, title: &str, outcome: Result<T, String>) -> Option<T> {
        match &outcome {
            Ok(_) => self.resolved(title),
            Err(why) => self.error(title, why),
        }
        outcome.ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_stay_until_dismissed_and_are_not_repeated() {
        let mut messages = Messages::default();
        messages.error("Open", "a.png: empty");
        messages.error("Open", "a.png: empty");
        messages.error("Detect", "no");
        assert_eq!(messages.errors.len(), 2);
        messages.dismiss(messages.errors[0].id);
        assert_eq!(messages.errors[0].title, "Detect");
        for i in 0..10 {
            messages.error("Many", i.to_string());
        }
        assert_eq!(messages.errors.len(), MAX_ERRORS);
        messages.resolved("Many");
        assert!(messages.errors.is_empty());
    }
}
