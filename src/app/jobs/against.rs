//! Comparisons of the features with others: asked for when they are wanted and not there, and taken when they are.

use crate::app::window::BurstscopeApp;
use crate::requests::{AgainstRequest, JobError};

/// What was asked for last.
#[derive(Default)]
pub(in crate::app) struct AgainstAsked(Option<AgainstRequest>);

impl BurstscopeApp {
    /// Takes what the worker published.
    pub(in crate::app) fn take_against_updates(&mut self) {
        for answer in self.engine.against.poll().filter(|answer| !answer.is_superseded()) {
            match answer.result {
                Ok(compared) => self.model.take_comparison(compared),
                Err(JobError::Cancelled) => self.model.against.problem = Some("Cancelled".to_owned()),
                Err(error) => self.model.against.problem = Some(error.to_string()),
            }
        }
        self.model.against.busy = self.engine.against.running();
    }

    /// Asks for the comparison that is wanted and not there.
    pub(in crate::app) fn request_comparison(&mut self) {
        self.model.check_against();
        let Some(wanted) = self.model.wanted_comparison() else {
            if self.against_asked.0.take().is_some() {
                self.engine.against.cancel();
            }
            return;
        };
        let is_asked = self.against_asked.0.as_ref().is_some_and(|asked| asked.same_comparison(&wanted));
        let is_there = self.model.shown_comparison().is_some_and(|shown| Some(shown.with) == self.model.against.with);
        let ended = is_there || self.model.against.problem.is_some();
        if !is_asked || !(ended || self.engine.against.running().is_some()) {
            self.engine.against.start(wanted.clone());
            self.against_asked = AgainstAsked(Some(wanted));
            self.model.against.problem = None;
        }
    }

    /// Whether the comparison that is wanted is there.
    pub(in crate::app) fn comparison_is_settled(&self) -> bool {
        self.model.wanted_comparison().is_none()
            || self.model.shown_comparison().is_some()
            || self.model.against.problem.is_some()
    }
}
