//! Messages of the window: errors stay until they are dismissed, a note until the next one.

/// Severity of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// An action succeeded.
    Note,
    /// An action failed; the text gives the reason.
    Error,
}

/// A message to the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Unique number of the message.
    pub id: u64,
    /// The action that was tried, in a few words.
    pub title: String,
    /// The problem, and how to resolve it.
    pub text: String,
}

/// The messages that are open, and the last note.
#[derive(Debug, Clone, Default)]
pub struct Messages {
    errors: Vec<Message>,
    note: Option<String>,
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

    /// Shows a note in the status bar until the next one.
    pub fn note(&mut self, text: impl Into<String>) {
        self.note = Some(text.into());
    }

    /// Removes the last note: its subject is no longer on show.
    pub fn forget_note(&mut self) {
        self.note = None;
    }

    /// Errors that were not dismissed, oldest first.
    pub fn errors(&self) -> &[Message] {
        &self.errors
    }

    /// The last note.
    pub fn last_note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Removes an error.
    pub fn dismiss(&mut self, id: u64) {
        self.errors.retain(|m| m.id != id);
    }

    /// Removes the errors with this title: the action has succeeded since.
    pub fn resolved(&mut self, title: &str) {
        self.errors.retain(|m| m.title != title);
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
        assert_eq!(messages.errors().len(), 2);
        messages.dismiss(messages.errors()[0].id);
        assert_eq!(messages.errors()[0].title, "Detect");
        for i in 0..10 {
            messages.error("Many", i.to_string());
        }
        assert_eq!(messages.errors().len(), MAX_ERRORS);
        messages.resolved("Many");
        assert!(messages.errors().is_empty());
    }
}
