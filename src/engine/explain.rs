//! The worker that explains a detection as a whole: which slopes the burst needs, where the candidates went.
//!
//! All answers come from what the detection left behind (see [`super::trails`]).

use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use super::trails::Trails;
use crate::monitor::Monitor;
use crate::requests::{ExplainRequest, ExplainSubject, Explained, JobId};
use std::sync::Arc;
use std::time::Duration;

/// The worker.
pub struct Explainer(Jobs<ExplainRequest, Explained>);

impl Explainer {
    pub(super) fn new(queue: &Arc<JobQueue>, trails: &Trails) -> Self {
        let its = trails.clone();
        let work = move |request: ExplainRequest, monitor: &Monitor| request.compute(&its, monitor);
        Self(Jobs::new(queue, Priority::Search, Duration::ZERO, work))
    }

    /// Asks; an earlier question of the same subject is superseded, and cancelled.
    pub fn ask(&self, request: ExplainRequest) -> JobId {
        self.0.submit_for(request.question.subject() as u32, request)
    }

    /// What was answered since the last call. Never waits.
    pub fn poll(&self) -> Vec<(ExplainSubject, JobAnswer<Explained>)> {
        let subject = |slot: u32| {
            if slot == ExplainSubject::Slopes as u32 { ExplainSubject::Slopes } else { ExplainSubject::Candidates }
        };
        let answers = self.0.take_answers_for().into_iter().filter(|(_, answer)| !answer.is_superseded());
        answers.map(|(slot, answer)| (subject(slot), answer)).collect()
    }

    /// Nobody wants to know this any more.
    pub fn forget(&self, subject: ExplainSubject) {
        self.0.cancel_for(subject as u32);
    }
}
