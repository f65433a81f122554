//! How evenly the frames answer for each feature: asked for while colours are to tell it, and taken when it is there. A
//! detection that is under way comes first.

use crate::app::window::BurstscopeApp;
use crate::requests::{CoherenceRequest, JobError, JobId};

/// What was asked and is not answered yet.
#[derive(Default)]
pub(in crate::app) struct CoherenceAsked(Option<(JobId, CoherenceRequest)>);

impl BurstscopeApp {
    /// Takes what was answered.
    pub(in crate::app) fn take_coherences(&mut self) {
        for answer in self.engine.coherence.poll() {
            let asked = self.coherence_asked.0.take_if(|(id, _)| *id == answer.id).map(|(_, request)| request);
            match (answer.result, asked) {
                (Ok(coherences), _) => self.model.coherence.take(coherences),
                (Err(_), None) => {}
                (Err(JobError::Cancelled), Some(request)) => {
                    self.model.coherence.fail(request.detection, "cancelled".to_owned());
                }
                (Err(error), Some(request)) => {
                    self.model.coherence.fail(request.detection, error.to_string());
                    self.model.messages.error("Coherence", error.to_string());
                }
            }
        }
        self.model.forget_old_coherences();
        self.model.coherence.busy = self.engine.coherence.running();
    }

    /// What is wanted and not there.
    fn coherence_missing(&self) -> Option<CoherenceRequest> {
        self.model.wanted_coherence().filter(|_| self.asked.detecting.is_none())
    }

    /// Whether nothing is wanted that is not there.
    pub(in crate::app) fn coherences_are_settled(&self) -> bool {
        self.coherence_missing().is_none()
    }

    /// Asks for what is wanted and not there, and stops what is not wanted any more.
    pub(in crate::app) fn request_coherence(&mut self) {
        let missing = self.coherence_missing();
        let is_asked = |(_, asked): &(JobId, CoherenceRequest)| {
            missing.as_ref().is_some_and(|missing| missing.same_features(asked))
        };
        if self.coherence_asked.0.as_ref().is_some_and(is_asked) {
            return;
        }
        if self.coherence_asked.0.take().is_some() {
            self.engine.coherence.cancel();
        }
        self.coherence_asked.0 = missing.map(|missing| (self.engine.coherence.start(missing.clone()), missing));
        self.model.coherence.busy = self.engine.coherence.running();
    }
}
