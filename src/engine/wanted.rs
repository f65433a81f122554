//! Client's side of a request: the request, its progress, and its end.

use super::Engine;
use super::jobs::Jobs;
use super::queue::{Lane, Manner};
use crate::monitor::Monitor;
use crate::requests::{JobError, JobId, Request, Running, Urgency, Work};
use std::any::TypeId;
use std::fmt;
use std::time::Duration;

type JobsOf<R> = Jobs<R, <R as Request>::Answer, <R as Request>::Partial>;

/// [`Self::want`] takes, in each pass, what is missing. A request that failed or was cancelled is not repeated until
/// another one was wanted, [`Self::ask`] repeats it, or [`Self::forget`] is called. Dropping cancels the request.
pub struct Wanted<R: Request> {
    jobs: Option<JobsOf<R>>,
    /// Requests without an answer, the latest last.
    pending: Vec<(JobId, R)>,
    ended: Option<(R, Option<JobError>)>,
    /// Progress of the running request, as of the last [`Self::take`] or [`Self::ask`].
    pub(crate) running: Option<Running>,
}

#[derive(Debug, Clone)]
pub struct Ended<R: Request> {
    pub id: JobId,
    pub request: R,
    pub result: Result<R::Answer, JobError>,
    /// Wall-clock time of the work; zero for an answer that was kept.
    pub elapsed: Duration,
}

impl<R: Request> Default for Wanted<R> {
    fn default() -> Self {
        Self { jobs: None, pending: Vec::new(), ended: None, running: None }
    }
}

impl<R: Request> fmt::Debug for Wanted<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Wanted").field("pending", &self.pending.len()).field("running", &self.running).finish()
    }
}

impl<R: Request> Drop for Wanted<R> {
    fn drop(&mut self) {
        self.cancel();
    }
}

impl<R: Request> Wanted<R> {
    /// Requests `wanted` unless it is running, or ended last and failed. `None` cancels the running request.
    pub fn want(&mut self, engine: &Engine, wanted: Option<R>) {
        let Some(wanted) = wanted else {
            if self.is_pending() {
                self.forget();
            }
            return;
        };
        let is_known = match (self.pending(), &self.ended) {
            (Some(pending), _) => *pending == wanted,
            // A failure repeats itself: without this it would be requested again in every pass.
            (None, Some((failed, Some(_)))) => *failed == wanted,
            (None, _) => false,
        };
        if !is_known {
            self.ask(engine, wanted);
        }
    }

    /// Requests `request` in any case; a running request is superseded.
    pub fn ask(&mut self, engine: &Engine, request: R) -> JobId {
        let jobs = self.jobs.get_or_insert_with(|| jobs(engine));
        let urgency = request.urgency();
        let is_picture = matches!(urgency, Urgency::Picture | Urgency::SlowPicture);
        let id = match request.cached(&engine.caches) {
            Some(answer) => jobs.publish(answer),
            None if is_picture => {
                // One picture at a time has all cores.
                let lane = Lane::Type(TypeId::of::<R>(), urgency);
                jobs.submit_as(Manner { urgency, grace: request.grace(), lane }, request.clone())
            }
            None => jobs.submit_as(Manner { urgency, grace: Duration::ZERO, ..jobs.manner }, request.clone()),
        };
        self.pending.push((id, request));
        self.ended = None;
        self.running = jobs.running();
        id
    }

    /// Takes the ends of requests since the last call, oldest first, without superseded ones. Never waits.
    pub fn take(&mut self) -> Vec<Ended<R>> {
        let Some(jobs) = &self.jobs else { return Vec::new() };
        self.running = jobs.running();
        let mut taken = Vec::new();
        for answer in jobs.take_answers() {
            // An answer to a request that was forgotten has no place here.
            let Some(place) = self.pending.iter().position(|(id, _)| *id == answer.id) else { continue };
            let (id, request) = self.pending.remove(place);
            if !matches!(answer.result, Err(JobError::Superseded)) {
                self.ended = Some((request.clone(), answer.result.as_ref().err().cloned()));
                taken.push(Ended { id, request, result: answer.result, elapsed: answer.elapsed });
            }
        }
        taken
    }

    /// Takes the partial results since the last call, oldest first. Call it before [`Self::take`].
    pub fn take_partial(&mut self) -> Vec<R::Partial> {
        self.jobs.as_ref().map_or_else(Vec::new, Jobs::take_partial)
    }

    pub fn pending(&self) -> Option<&R> {
        self.pending.last().map(|(_, request)| request)
    }

    pub fn pending_id(&self) -> Option<JobId> {
        self.pending.last().map(|(id, _)| *id)
    }

    pub fn is_pending(&self) -> bool {
        !self.pending.is_empty()
    }

    pub fn failure(&self) -> Option<(&R, &JobError)> {
        let (request, error) = self.ended.as_ref()?;
        Some((request, error.as_ref()?))
    }

    pub fn has_failed(&self, request: &R) -> bool {
        self.failure().is_some_and(|(failed, _)| failed == request)
    }

    pub fn cancel(&self) {
        if let Some(jobs) = self.jobs.as_ref().filter(|_| self.is_pending()) {
            jobs.cancel();
        }
    }

    /// Cancels the running request without reporting its end, and forgets how the last one ended.
    pub fn forget(&mut self) {
        self.cancel();
        if let Some(jobs) = &self.jobs {
            drop((jobs.take_partial(), jobs.take_answers()));
        }
        self.pending.clear();
        (self.ended, self.running) = (None, None);
    }
}

fn jobs<R: Request>(engine: &Engine) -> JobsOf<R> {
    let caches = engine.caches.clone();
    let work = move |request: R, tell: &(dyn Fn(R::Partial) + Sync), monitor: &Monitor| {
        request.compute(&Work { caches: caches.clone(), monitor, tell })
    };
    Jobs::telling(&engine.queue, Urgency::Search, Duration::ZERO, work)
}

/// Methods that do not depend on the request of a [`Wanted`], for lists of them.
pub trait Want {
    fn is_settled(&self) -> bool;

    fn urgency(&self) -> Option<Urgency>;

    fn cancel(&self);
}

impl<R: Request> Want for Wanted<R> {
    fn is_settled(&self) -> bool {
        !self.is_pending()
    }

    fn urgency(&self) -> Option<Urgency> {
        self.pending().map(Request::urgency)
    }

    fn cancel(&self) {
        Wanted::cancel(self);
    }
}
