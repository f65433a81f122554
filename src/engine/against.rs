//! The worker that compares the features of a burst with others: an earlier result, somebody else's, what is really
//! there.

use super::Running;
use super::fault::JobError;
use super::jobs::{JobAnswer, Jobs};
use super::picture::job_error;
use super::queue::{JobId, JobQueue, Priority};
use super::source::OpenBurst;
use crate::detector::{Detection, DetectorParams};
use crate::inspect::ProbeCache;
use crate::inspect::changes::{Changes, Spot, compare};
use crate::inspect::foreign::{ForeignFeature, read_features};
use crate::inspect::truth::{AgainstTruth, against_truth, truth_of};
use crate::monitor::Monitor;
use crate::synth::Truth;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// With what features are compared.
#[derive(Debug, Clone)]
pub enum Reference {
    /// An earlier result of the same burst.
    Earlier(Arc<Detection>),
    /// Somebody else's features.
    File {
        /// The file.
        path: PathBuf,
        /// What it holds, once it was read.
        features: Option<Arc<Vec<ForeignFeature>>>,
    },
    /// What is known of a synthetic burst.
    Truth {
        /// The burst.
        burst: OpenBurst,
        /// The parameters of the detection, with its slopes: the search is repeated with all that it leaves behind.
        params: DetectorParams,
    },
}

/// What is compared with what.
#[derive(Debug, Clone)]
pub struct AgainstRequest {
    /// The features.
    pub detection: Arc<Detection>,
    /// The others.
    pub with: Reference,
}

impl AgainstRequest {
    /// Whether both ask for the same comparison.
    pub fn same_comparison(&self, other: &Self) -> bool {
        let same_reference = match (&self.with, &other.with) {
            (Reference::Earlier(a), Reference::Earlier(b)) => Arc::ptr_eq(a, b),
            (Reference::File { path: a, .. }, Reference::File { path: b, .. }) => a == b,
            (Reference::Truth { burst: a, params: p }, Reference::Truth { burst: b, params: q }) => {
                a.id == b.id && p == q
            }
            _ => false,
        };
        same_reference && Arc::ptr_eq(&self.detection, &other.detection)
    }
}

/// What came of a comparison.
#[derive(Debug, Clone)]
pub enum Against {
    /// Gained, lost and moved.
    Changes {
        /// Which.
        changes: Changes,
        /// The others, in the order of their indices.
        before: Arc<Vec<Spot>>,
        /// What a file holds, to be handed in the next time.
        read: Option<Arc<Vec<ForeignFeature>>>,
    },
    /// Found, missed, repeated and false.
    Truth {
        /// Which.
        against: Box<AgainstTruth>,
        /// What is really there.
        truth: Arc<Truth>,
    },
}

/// A comparison with what it was made of.
#[derive(Debug, Clone)]
pub struct ComparedWith {
    /// What was asked for.
    pub request: AgainstRequest,
    /// What came of it.
    pub against: Against,
}

/// The worker.
pub struct AgainstWorker(Jobs<AgainstRequest, ComparedWith>);

impl AgainstWorker {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        Self(Jobs::new(queue, Priority::Search, Duration::ZERO, work))
    }

    /// Starts a comparison; the one that runs is cancelled.
    pub fn start(&self, request: AgainstRequest) -> JobId {
        self.0.submit(request)
    }

    /// What came of those that ended since the last call. Never waits.
    pub fn poll(&self) -> impl Iterator<Item = JobAnswer<ComparedWith>> {
        self.0.take_answers()
    }

    /// What it is doing now, if anything.
    pub fn running(&self) -> Option<Running> {
        self.0.running()
    }

    /// Cancels what it is doing.
    pub fn cancel(&self) {
        self.0.cancel();
    }
}

fn work(request: AgainstRequest, monitor: &Monitor) -> Result<ComparedWith, JobError> {
    let failed = |e: &dyn std::fmt::Display| JobError::Failed(e.to_string());
    let spots: Vec<Spot> = request.detection.features.iter().map(Spot::from).collect();
    let against = match &request.with {
        Reference::Earlier(before) => {
            let before: Vec<Spot> = before.features.iter().map(Spot::from).collect();
            Against::Changes { changes: compare(&before, &spots), before: Arc::new(before), read: None }
        }
        Reference::File { path, features } => {
            let read = match features {
                Some(features) => features.clone(),
                None => Arc::new(read_features(path).map_err(|e| failed(&e))?),
            };
            monitor.check()?;
            let before: Vec<Spot> = read.iter().map(Spot::from).collect();
            Against::Changes { changes: compare(&before, &spots), before: Arc::new(before), read: Some(read) }
        }
        Reference::Truth { burst, params } => {
            let truth = truth_of(&burst.burst).map_err(|e| failed(&e))?;
            let truth = truth.ok_or_else(|| JobError::Failed("nothing is known of what is really there".to_owned()))?;
            let cache = ProbeCache::new(&burst.burst, &params.clone().into(), monitor).map_err(job_error)?;
            let against = against_truth(&cache, &truth, monitor)?;
            Against::Truth { against: Box::new(against), truth: Arc::new(truth) }
        }
    };
    monitor.check()?;
    Ok(ComparedWith { request, against })
}
