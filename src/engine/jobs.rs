//! Kinds of background work: each with its urgency, a function from requests to answers, and a place where these are
//! polled. Before the one answer, work may report partial results.

use super::queue::{Lane, Manner, Publish, QueuedJob, Standing};
use super::{JobQueue, OnUpdate, fault, locked};
use crate::monitor::Monitor;
use crate::requests::{JobError, JobId, Running, Urgency};
use std::convert::Infallible;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

#[derive(Debug, Clone)]
pub struct JobAnswer<A> {
    pub id: JobId,
    pub result: Result<A, JobError>,
    /// Wall-clock time of the work; zero for an answer that was kept.
    pub elapsed: Duration,
}

struct News<A, P> {
    answers: Vec<JobAnswer<A>>,
    partial: Vec<(JobId, P)>,
}

type Work<Q, A, P> = dyn Fn(Q, &(dyn Fn(P) + Sync), &Monitor) -> Result<A, JobError> + Send + Sync;

struct Shared<Q, A, P> {
    work: Box<Work<Q, A, P>>,
    news: Mutex<News<A, P>>,
    on_update: OnUpdate,
}

impl<Q, A, P> Shared<Q, A, P> {
    fn answer(&self, id: JobId, result: Result<A, JobError>, elapsed: Duration) {
        let mut news = locked(&self.news);
        if matches!(result, Err(JobError::Superseded)) {
            // Partial results of a superseded request are dropped: the newer request reports its own.
            news.partial.retain(|(of, _)| *of != id);
        }
        news.answers.push(JobAnswer { id, result, elapsed });
    }
}

pub struct Jobs<Q, A, P = Infallible> {
    queue: Arc<JobQueue>,
    kind: u32,
    pub(super) manner: Manner,
    shared: Arc<Shared<Q, A, P>>,
}

impl<Q: Send + 'static, A: Send + 'static> Jobs<Q, A> {
    /// Superseded, a request is cancelled once it has run for `grace`; if it ends before, its answer stands.
    pub fn new(
        queue: &Arc<JobQueue>,
        urgency: Urgency,
        grace: Duration,
        work: impl Fn(Q, &Monitor) -> Result<A, JobError> + Send + Sync + 'static,
    ) -> Self {
        Self::telling(queue, urgency, grace, move |request, _: &(dyn Fn(Infallible) + Sync), monitor| {
            work(request, monitor)
        })
    }
}

impl<Q: Send + 'static, A: Send + 'static, P: Send + 'static> Jobs<Q, A, P> {
    pub fn telling(
        queue: &Arc<JobQueue>,
        urgency: Urgency,
        grace: Duration,
        work: impl Fn(Q, &(dyn Fn(P) + Sync), &Monitor) -> Result<A, JobError> + Send + Sync + 'static,
    ) -> Self {
        let news = Mutex::new(News { answers: Vec::new(), partial: Vec::new() });
        let shared = Arc::new(Shared { work: Box::new(work), news, on_update: queue.on_update().clone() });
        let kind = queue.new_kind();
        Self { queue: queue.clone(), kind, manner: Manner { urgency, grace, lane: Lane::Kind(kind) }, shared }
    }

    pub(super) fn submit_as(&self, manner: Manner, request: Q) -> JobId {
        let job = TypedJob { request, grace: manner.grace, shared: self.shared.clone() };
        self.queue.submit(self.kind, manner, Box::new(job))
    }

    pub fn publish(&self, answer: A) -> JobId {
        self.queue.publish(self.kind, |id| self.shared.answer(id, Ok(answer), Duration::ZERO))
    }

    /// Cancels running and waiting requests, whose answers are [`JobError::Cancelled`].
    pub fn cancel(&self) {
        self.queue.cancel(self.kind);
    }

    pub fn running(&self) -> Option<Running> {
        self.queue.running(self.kind)
    }

    pub fn take_answers(&self) -> Vec<JobAnswer<A>> {
        std::mem::take(&mut locked(&self.shared.news).answers)
    }

    pub(super) fn take_partial(&self) -> Vec<P> {
        std::mem::take(&mut locked(&self.shared.news).partial).into_iter().map(|(_, told)| told).collect()
    }
}

struct TypedJob<Q, A, P> {
    request: Q,
    grace: Duration,
    shared: Arc<Shared<Q, A, P>>,
}

impl<Q: Send + 'static, A: Send + 'static, P: Send + 'static> QueuedJob for TypedJob<Q, A, P> {
    fn run(self: Box<Self>, id: JobId, thread: &str, monitor: &Monitor) -> Publish {
        let Self { request, grace, shared } = *self;
        let started = Instant::now();
        let tell = |told: P| {
            // Cancelled work may still report a partial result, for which nobody waits.
            if !monitor.is_cancelled() {
                locked(&shared.news).partial.push((id, told));
                (shared.on_update)();
            }
        };
        let result = fault::guard(thread, || (shared.work)(request, &tell, monitor));
        let elapsed = started.elapsed();
        Box::new(move |standing| {
            // With grace, an answer to an older request that comes in time is better than none; without, it is stale.
            let unwanted = match standing {
                Standing::Latest => false,
                Standing::Superseded => grace.is_zero() || matches!(result, Err(JobError::Cancelled)),
                Standing::Overtaken => true,
            };
            shared.answer(id, if unwanted { Err(JobError::Superseded) } else { result }, elapsed);
        })
    }

    fn end(self: Box<Self>, id: JobId, why: JobError) {
        self.shared.answer(id, Err(why), Duration::ZERO);
    }
}
