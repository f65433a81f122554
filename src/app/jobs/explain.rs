//! What the window asks about the detection on show as a whole: its slopes, once it is there, and its candidates, while
//! they are to be seen. A detection that is under way comes first.

use crate::app::project::workspace::Workspace;
use crate::app::window::BurstscopeApp;
use crate::requests::{ExplainRequest, ExplainSubject, JobError, JobId};

/// What was asked and is not answered yet.
#[derive(Default)]
pub(in crate::app) struct ExplainAsked(Vec<(JobId, ExplainRequest)>);

impl BurstscopeApp {
    /// What is wanted about the detection on show and not there.
    fn explanations_missing(&self) -> Vec<ExplainRequest> {
        let model = &self.model;
        if model.workspace != Workspace::Inspect || self.asked.detecting.is_some() {
            return Vec::new();
        }
        let slopes = model.wanted_slopes().filter(|_| model.spectrum().is_none());
        let candidates = model.wanted_candidates().filter(|_| model.survey().is_none());
        let is_open = |request: &ExplainRequest| model.explained.failure_of(request).is_none();
        slopes.into_iter().chain(candidates).filter(is_open).collect()
    }

    /// Whether nothing is wanted about the detection on show that is not there.
    pub(in crate::app) fn explanations_are_settled(&self) -> bool {
        self.explanations_missing().is_empty()
    }

    /// Takes what was answered.
    pub(in crate::app) fn take_explanations(&mut self) {
        for (_, answer) in self.engine.explainer().poll() {
            let asked = &mut self.explain_asked.0;
            let request = asked.iter().position(|(id, _)| *id == answer.id).map(|place| asked.swap_remove(place).1);
            match (answer.result, request) {
                (Ok(explained), _) => self.model.explained.take(explained),
                (Err(JobError::Cancelled), _) | (Err(_), None) => {}
                (Err(error), Some(request)) => {
                    self.model.explained.fail(request, error.to_string());
                    self.model.messages.error("Explanation", error.to_string());
                }
            }
        }
    }

    /// Asks for what is wanted and not there, and stops what is not wanted any more.
    pub(in crate::app) fn request_explanations(&mut self) {
        let missing = self.explanations_missing();
        let is_of = |request: &ExplainRequest, subject| request.question.subject() == subject;
        for subject in [ExplainSubject::Slopes, ExplainSubject::Candidates] {
            let wanted = missing.iter().find(|request| is_of(request, subject));
            let asked = self.explain_asked.0.iter().position(|(_, request)| is_of(request, subject));
            match (wanted, asked) {
                (Some(wanted), Some(place)) if self.explain_asked.0[place].1.same_answer(wanted) => continue,
                (None, Some(_)) => self.engine.explainer().forget(subject),
                _ => {}
            }
            asked.into_iter().for_each(|place| drop(self.explain_asked.0.swap_remove(place)));
            if let Some(wanted) = wanted {
                self.explain_asked.0.push((self.engine.explainer().ask(wanted.clone()), wanted.clone()));
            }
        }
    }
}
