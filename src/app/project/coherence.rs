//! How evenly the frames answer for the features of the open bursts, as far as that is known.

use crate::app::project::Model;
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::app::view::ColourBy;
use crate::detector::Detection;
use crate::requests::{CoherenceRequest, Coherences, DetectionSource, Running};
use std::sync::Arc;

/// What is known.
#[derive(Debug, Default)]
pub struct CoherenceState {
    /// Those of the detections of the open bursts.
    known: Vec<Coherences>,
    /// Of which detections they could not be found or were not waited for, and why.
    failed: Vec<(Arc<Detection>, String)>,
    /// What the engine is doing.
    pub busy: Option<Running>,
}

impl CoherenceState {
    /// Takes what was found.
    pub fn take(&mut self, coherences: Coherences) {
        self.known.retain(|known| !Arc::ptr_eq(&known.detection, &coherences.detection));
        self.known.push(coherences);
    }

    /// Takes over why nothing was found.
    pub fn fail(&mut self, detection: Arc<Detection>, why: String) {
        self.failed.push((detection, why));
    }

    /// Of what failed or was cancelled, nothing is known: it is asked for again.
    pub fn try_again(&mut self) {
        self.failed.clear();
    }

    /// Those of the features of `detection`, if they are known.
    pub fn of(&self, detection: &Arc<Detection>) -> Option<&Arc<Vec<Option<f32>>>> {
        self.known.iter().find(|known| Arc::ptr_eq(&known.detection, detection)).map(|known| &known.values)
    }

    /// Why those of `detection` are not known.
    pub fn failure_of(&self, detection: &Arc<Detection>) -> Option<&str> {
        self.failed.iter().find(|(failed, _)| Arc::ptr_eq(failed, detection)).map(|(_, why)| why.as_str())
    }

    /// Keeps what is known of these detections alone.
    fn keep_only(&mut self, detections: &[Arc<Detection>]) {
        let is_open = |detection: &Arc<Detection>| detections.iter().any(|open| Arc::ptr_eq(open, detection));
        self.known.retain(|known| is_open(&known.detection));
        self.failed.retain(|(detection, _)| is_open(detection));
    }
}

impl Model {
    /// The features whose coherence is to be shown and not known yet; those of A first.
    pub fn wanted_coherence(&self) -> Option<CoherenceRequest> {
        let sides: &[Side] = match self.workspace {
            _ if self.colour_by != ColourBy::Coherence => &[],
            Workspace::Pair => &Side::BOTH,
            Workspace::Inspect if self.look.overlay && self.panes.iter().any(|(_, pane)| pane.side == Side::B) => {
                &Side::BOTH
            }
            Workspace::Inspect if self.look.overlay => &[Side::A],
            _ => &[],
        };
        let request = |&side: &Side| {
            let (burst, found) = (self.burst_of(side)?.clone(), self.found_of(side)?);
            let detection = found.detection.clone();
            let is_open = self.coherence.of(&detection).is_none() && self.coherence.failure_of(&detection).is_none();
            let (asked, params, finding) = (found.asked.clone(), found.params.clone(), found.finding.clone());
            let of = DetectionSource { burst, asked, params, finding };
            is_open.then_some(CoherenceRequest { of, detection })
        };
        sides.iter().find_map(request)
    }

    /// Forgets the coherences of features that are not there any more.
    pub fn forget_old_coherences(&mut self) {
        let open = Side::BOTH.into_iter().filter_map(|side| Some(self.found_of(side)?.detection.clone()));
        let open: Vec<_> = open.collect();
        self.coherence.keep_only(&open);
    }

    /// The coherence of a feature of the first burst in words; `None` while it is not known.
    pub fn coherence_text(&self, index: usize) -> Option<String> {
        let detection = &self.found.as_ref()?.detection;
        Some(coherence_words(*self.coherence.of(detection)?.get(index)?))
    }
}

/// A coherence in words.
pub fn coherence_words(coherence: Option<f32>) -> String {
    coherence.map_or_else(|| "too noisy to tell".to_owned(), |coherence| format!("{coherence:.2}"))
}
