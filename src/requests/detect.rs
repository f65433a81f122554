//! Finding the features of a burst.

use super::error::JobError;
use super::open::{BurstId, OpenBurst};
use super::request::{Request, Urgency, Work};
use crate::detector::{Detection, DetectorParams, SearchParams, SlopeFinding};
use crate::inspect::ProbeCache;
use std::convert::Infallible;
use std::sync::Arc;

/// Request for a detection: snapshot of a burst and of the parameters.
#[derive(Debug, Clone)]
pub struct DetectRequest {
    /// The burst.
    pub burst: OpenBurst,
    /// The parameters, and how the slopes are chosen.
    pub params: SearchParams,
}

impl Request for DetectRequest {
    type Answer = Detected;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn is_same(&self, other: &Self) -> bool {
        self.burst.id == other.burst.id && self.params == other.params
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<Detected, JobError> {
        let Self { burst, params: asked } = self;
        let (trails, monitor) = (work.kept.trails, work.monitor);
        let cache = match trails.asked(&burst, &asked) {
            Some(kept) => kept,
            None => {
                trails.make_room();
                let made = Arc::new(ProbeCache::new(&burst.burst, &asked, monitor)?);
                trails.put(&burst, &made);
                made
            }
        };
        let params = cache.made_with();
        // A method that searches one merged frame made that of all frames.
        let detection = Detection { frames_used: params.used_frames(burst.burst.len()), ..cache.detection().clone() };
        Ok(Detected { burst: burst.id, asked, params, finding: cache.finding.clone(), detection: Arc::new(detection) })
    }
}

/// Finished detection with its burst and parameters.
#[derive(Debug, Clone)]
pub struct Detected {
    /// The burst it belongs to.
    pub burst: BurstId,
    /// Parameters that were asked for.
    pub asked: SearchParams,
    /// The parameters that were used, with the slopes that were found if they were to be found.
    pub params: DetectorParams,
    /// Result of the search for slopes, if they were to be found.
    pub finding: Option<SlopeFinding>,
    /// The features.
    pub detection: Arc<Detection>,
}
