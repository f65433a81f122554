//! Coherences of the features of the open bursts: how evenly the frames contribute to each feature.

use crate::app::project::Model;
use crate::app::project::side::{Side, Sides};
use crate::app::project::workspace::Workspace;
use crate::app::view::ColourBy;
use crate::detector::Detection;
use crate::engine::{Engine, Wanted};
use crate::requests::{CoherenceRequest, Coherences, JobError, Running};
use std::sync::Arc;

/// Known coherences, and the requests for missing ones.
#[derive(Debug, Default)]
pub struct CoherenceState {
    /// Coherences of the detections of the open bursts.
    known: Vec<Coherences>,
    /// Requests for the features of each burst.
    pub wanted: Sides<Wanted<CoherenceRequest>>,
}

impl CoherenceState {
    /// Keeps the coherences of a detection.
    fn take(&mut self, coherences: Coherences) {
        self.known.retain(|known| !Arc::ptr_eq(&known.detection, &coherences.detection));
        self.known.push(coherences);
    }

    /// Lets requests that failed or were cancelled be made again.
    pub fn try_again(&mut self) {
        self.wanted = Sides::default();
    }

    /// Progress of the running request.
    pub fn running(&self) -> Option<Running> {
        self.wanted.both().into_iter().find_map(Wanted::running)
    }

    /// Coherences of the features of `detection`, if they are known.
    pub fn of(&self, detection: &Arc<Detection>) -> Option<&Arc<Vec<Option<f32>>>> {
        self.known.iter().find(|known| Arc::ptr_eq(&known.detection, detection)).map(|known| &known.values)
    }

    /// Reason why the coherences of `detection` could not be computed, if they could not.
    pub fn failure_of(&self, detection: &Arc<Detection>) -> Option<&JobError> {
        let mut failures = self.wanted.both().into_iter().filter_map(Wanted::failure);
        failures.find(|(request, _)| Arc::ptr_eq(&request.detection, detection)).map(|(_, why)| why)
    }

    /// Forgets the coherences of all other detections.
    fn keep_only(&mut self, detections: &[Arc<Detection>]) {
        let is_open = |detection: &Arc<Detection>| detections.iter().any(|open| Arc::ptr_eq(open, detection));
        self.known.retain(|known| is_open(&known.detection));
    }
}

impl Model {
    /// The request for the features of `side`, if their coherence is to be shown and not known yet. A running detection
    /// comes first.
    pub fn missing_coherence(&self, side: Side) -> Option<CoherenceRequest> {
        let is_shown = match self.workspace {
            Workspace::Pair => true,
            Workspace::Inspect => self.look.overlay && self.panes.iter().any(|(_, pane)| pane.side == side),
            _ => false,
        };
        if self.colour_by != ColourBy::Coherence || !is_shown || self.slots[side].detecting.is_pending() {
            return None;
        }
        let (of, detection) = (self.found_source(side)?, self.found_of(side)?.detection.clone());
        self.coherence.of(&detection).is_none().then_some(CoherenceRequest { of, detection })
    }

    /// Takes the coherences that were computed, and forgets those of detections that are no longer open.
    pub(in crate::app) fn take_coherences(&mut self) {
        for side in Side::BOTH {
            for ended in self.coherence.wanted[side].take() {
                match ended.result {
                    Ok(coherences) => self.coherence.take(coherences),
                    Err(JobError::Cancelled) => {}
                    Err(error) => self.messages.error("Coherence", error.to_string()),
                }
            }
        }

        let open = Side::BOTH.into_iter().filter_map(|side| Some(self.found_of(side)?.detection.clone()));
        let open: Vec<_> = open.collect();
        self.coherence.keep_only(&open);
    }

    /// Requests the coherences that are missing.
    pub(in crate::app) fn ask_for_coherences(&mut self, engine: &Engine) {
        for side in Side::BOTH {
            let missing = self.missing_coherence(side);
            self.coherence.wanted[side].want(engine, missing);
        }
    }

    /// The coherence of a feature of the first burst in words; `None` while it is not known.
    pub fn coherence_text(&self, index: usize) -> Option<String> {
        let detection = &self.slots.a.found.as_ref()?.detection;
        Some(coherence_words(*self.coherence.of(detection)?.get(index)?))
    }
}

/// A coherence in words; `None` is too noisy to tell.
pub fn coherence_words(coherence: Option<f32>) -> String {
    coherence.map_or_else(|| "too noisy to tell".to_owned(), |coherence| format!("{coherence:.2}"))
}
