//! What the window does to compare methods: takes what the worker found, and gives it the next piece of work that is
//! missing.

use crate::app::project::compare::{Busy, CompareJob, MethodFound};
use crate::app::project::pair::{Matches, Side};
use crate::app::project::workspace::Workspace;
use crate::app::window::BurstscopeApp;
use crate::requests::{BurstSource, CompareRequest, Compared, JobError, JobId};

/// What the worker was given.
#[derive(Default)]
pub(in crate::app) struct CompareAsked {
    job: Option<(JobId, CompareJob)>,
    /// A gold standard that is being opened, and on which side.
    opening: Option<(JobId, Side)>,
    /// Gold standards that are to be opened.
    gold: Vec<(BurstSource, Side)>,
}

impl BurstscopeApp {
    /// Opens a sharp image of the view of `side`, in the background.
    pub fn open_gold(&mut self, source: BurstSource, side: Side) {
        self.compare_asked.gold.push((source, side));
        self.open_next_gold();
    }

    /// Opens the next gold standard. A search that runs gives way to it, and is begun again afterwards.
    fn open_next_gold(&mut self) {
        if self.compare_asked.opening.is_none()
            && let Some((source, side)) = self.compare_asked.gold.pop()
        {
            let id = self.engine.comparer().start(CompareRequest::Open(source, self.model.calibration.clone()));
            (self.compare_asked.job, self.compare_asked.opening) = (None, Some((id, side)));
        }
    }

    pub(in crate::app) fn take_compare_updates(&mut self) {
        let answers: Vec<_> = self.engine.comparer().poll().collect();
        for answer in answers.into_iter().filter(|answer| !answer.is_superseded()) {
            let job = self.compare_asked.job.take_if(|(id, _)| *id == answer.id).map(|(_, job)| job);
            let opened_for = self.compare_asked.opening.take_if(|(id, _)| *id == answer.id).map(|(_, side)| side);
            match (answer.result, job, opened_for) {
                (Ok(Compared::Opened(open)), _, Some(side)) => {
                    self.model.messages.resolved("Open gold standard");
                    let said = crate::app::jobs::burst::describe_burst(&open);
                    self.model.messages.note(format!("Opened as gold standard of {}: {said}", side.name()));
                    self.model.compare.gold[side as usize] = Some(open);
                }
                (Ok(Compared::Detected(detected)), Some(job), _) => {
                    let found = MethodFound::new(detected, answer.elapsed);
                    self.model.compare.take_found(job.method, job.side, found);
                }
                (Ok(Compared::Matched(matched)), Some(job), _) => {
                    self.model.compare.take_matches(job.method, Matches::new(matched, answer.elapsed));
                }
                (Ok(_), _, _) => {}
                (Err(error), job, opened_for) => {
                    if let Some(job) = job {
                        let why = error.to_string();
                        if error != JobError::Cancelled {
                            self.model.messages.error(job.method.label(), why.clone());
                        }
                        self.model.compare.take_failure(job, why);
                    } else if opened_for.is_some() && error != JobError::Cancelled {
                        self.model.messages.error("Open gold standard", error.to_string());
                    }
                }
            }
        }
        self.open_next_gold();
        let running = self.engine.comparer().running();
        self.model.compare.busy = running
            .zip(self.compare_asked.job.as_ref())
            .map(|(running, (_, job))| Busy { method: job.method, running });
    }

    /// Gives the worker the next piece of work, if it has none. `dragging` says whether the pointer still drags
    /// something.
    pub(in crate::app) fn request_for_compare(&mut self, dragging: bool) {
        if self.model.workspace != Workspace::Methods || self.model.burst.is_none() {
            return;
        }
        self.model.share_what_is_found();
        if dragging || !self.model.auto_detect || !self.engine.comparer().is_idle() {
            return;
        }
        if let Some(job) = self.model.next_compare_job() {
            let id = self.engine.comparer().start(job.request.clone());
            self.compare_asked.job = Some((id, job));
        }
    }

    /// Whether every method that is shown has been run.
    pub(in crate::app) fn compare_is_settled(&self) -> bool {
        self.model.workspace != Workspace::Methods || !self.model.auto_detect || self.model.next_compare_job().is_none()
    }
}
