//! The worker that compares methods: one piece of work at a time, each with all threads, so that their times can be
//! compared too.
//!
//! Which piece comes next is for the asker to say, who sees what is missing whenever one is finished.

use super::fault::JobError;
use super::jobs::{JobAnswer, Jobs};
use super::pair::{MatchRequest, Matched, match_now};
use super::queue::{JobId, JobQueue, Priority};
use super::source::{BurstSource, OpenBurst};
use super::{DetectRequest, Detected, Running};
use crate::baseline;
use crate::detector::slopes::resolve;
use crate::detector::{Method, detect};
use crate::monitor::Monitor;
use crate::plane::Plane;
use std::sync::Arc;
use std::time::Duration;

/// A piece of work.
#[derive(Debug, Clone)]
pub enum CompareRequest {
    /// Opening a burst: the gold standard's image.
    Open(BurstSource),
    /// Finding features by the method that the parameters ask for.
    Detect(DetectRequest),
    /// Matching the features of two bursts.
    Match(MatchRequest),
}

/// What came of it.
#[derive(Debug, Clone)]
pub enum Compared {
    /// The opened burst.
    Opened(OpenBurst),
    /// The features, and the image that the method made of the burst, if it made one.
    Detected {
        /// The features.
        detected: Detected,
        /// The merged image.
        image: Option<Arc<Plane>>,
    },
    /// The matches.
    Matched(Matched),
}

/// The worker.
pub struct Comparer(Jobs<CompareRequest, Compared>);

impl Comparer {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        Self(Jobs::new(queue, Priority::Search, Duration::ZERO, work))
    }

    /// Starts a piece of work; the one that runs is cancelled.
    pub fn start(&self, request: CompareRequest) -> JobId {
        self.0.submit(request)
    }

    /// What came of the pieces that ended since the last call. Never waits.
    pub fn poll(&self) -> impl Iterator<Item = JobAnswer<Compared>> {
        self.0.take_answers()
    }

    /// What it is doing now, if anything.
    pub fn running(&self) -> Option<Running> {
        self.0.running()
    }

    /// Cancels what it is doing: its answer is [`JobError::Cancelled`].
    pub fn cancel(&self) {
        self.0.cancel();
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        self.0.is_idle()
    }
}

fn work(request: CompareRequest, monitor: &Monitor) -> Result<Compared, JobError> {
    match request {
        CompareRequest::Open(source) => source.open(monitor).map(Compared::Opened),
        CompareRequest::Match(request) => match_now(request, monitor).map(Compared::Matched),
        CompareRequest::Detect(DetectRequest { burst, params }) => {
            // As `baseline::search` does it, but the image that it makes on the way is kept.
            let asked = params;
            let (params, finding) = resolve(&burst.burst, &asked, monitor).map_err(super::picture::job_error)?;
            let (searched, with) =
                baseline::prepare(&burst.burst, &params, monitor).map_err(super::picture::job_error)?;
            let mut found = detect(&searched, &with, monitor).map_err(super::picture::job_error)?;
            found.frames_used = params.used_frames(burst.burst.len());
            let image = (params.method == Method::Merge).then(|| searched.frames[0].clone());
            let detected = Detected { burst: burst.id, asked, params, finding, detection: Arc::new(found) };
            Ok(Compared::Detected { detected, image })
        }
    }
}
