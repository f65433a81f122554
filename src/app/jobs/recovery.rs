//! Automatic saving of the session, and restoring of the session of a window that did not end normally.

use crate::app::panel::status::RecoveryChoice;
use crate::app::recovery::{KeptIn, Offer, Recovery, WritingEnded};
use crate::app::session::Session;
use crate::app::window::BurstscopeApp;
use crate::engine::TaskDone;
use crate::files::written_by;

/// Title of its messages.
const TITLE: &str = "Save the session by itself";

impl BurstscopeApp {
    /// Begins to save the session automatically, if `kept` gives a place.
    pub(in crate::app) fn begin_keeping_session(&mut self, kept: Option<&KeptIn>) {
        let Some(kept) = kept else { return };
        match Recovery::new(kept) {
            Ok(recovery) => self.recovery = Some(recovery),
            Err(error) => {
                let text =
                    format!("{error}: {}; until then, nothing can be restored after a crash", kept.folder.display());
                self.model.messages.error(TITLE, text);
            }
        }
    }

    /// Text of the present session, without the model of a lesson.
    fn session_text(&self) -> Option<String> {
        let model = self.lessons.open.as_ref().map_or(&self.model, |open| open.before());
        Some(written_by() + &Session::of(model)?.to_toml())
    }

    /// Saves the session in the background, if it is due and has changed.
    pub(in crate::app) fn keep_session(&mut self, ctx: &egui::Context) {
        // A burst that is being opened would be missing; the session is saved in a pass after that.
        if self.model.slots.both().into_iter().any(|slot| slot.opening.is_pending()) {
            return;
        }
        let Some(mut recovery) = self.recovery.take() else { return };
        match recovery.due(|| self.session_text()) {
            Ok(due) => recovery.begun(self.engine.task(TITLE, move || due.write().map(|()| String::new()))),
            Err(Some(rest)) => ctx.request_repaint_after(rest),
            Err(None) => {}
        }
        self.recovery = Some(recovery);
    }

    /// Saves the session at once: another window goes on with it, and if that fails it is offered later.
    pub(in crate::app) fn keep_session_now(&mut self) {
        if let (Some(recovery), Some(text)) = (&self.recovery, self.session_text())
            && let Err(error) = recovery.write_now(&text)
        {
            self.model.messages.error(TITLE, error);
        }
    }

    /// Whether the task that ended was the saving of the session. Reports each failure of that once.
    pub(in crate::app) fn has_kept_session(&mut self, done: &TaskDone) -> bool {
        let Some(recovery) = &mut self.recovery else { return false };
        let why = done.result.as_ref().err().map(ToString::to_string);
        let Some(ended) = recovery.has_ended(done.id, why.as_deref().map_or(Ok(()), Err)) else { return false };
        match ended {
            WritingEnded::Well | WritingEnded::FailedAgain => {}
            WritingEnded::WellAgain => self.model.messages.resolved(TITLE),
            WritingEnded::Failed => self.model.messages.error(TITLE, why.unwrap_or_default()),
        }
        true
    }

    /// Session of an earlier window that is offered for restoring.
    pub(in crate::app) fn offered_session(&self) -> Option<Offer> {
        self.recovery.as_ref()?.offer()
    }

    /// Applies the choice for the offered session.
    pub(in crate::app) fn settle_offer(&mut self, choice: RecoveryChoice) {
        let Some(recovery) = &mut self.recovery else { return };
        match choice {
            RecoveryChoice::Forget => {
                recovery.forget();
                self.model.messages.note("Removed the saved session");
            }
            RecoveryChoice::Restore => {
                let Some(path) = recovery.offered().map(ToOwned::to_owned) else { return };
                let request = self.restore_session(&path);
                if let (Some(recovery), Some(request)) = (&mut self.recovery, request) {
                    recovery.is_restored_by(request);
                }
            }
        }
    }
}
