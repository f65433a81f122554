//! Steps of the comparison of methods: detecting or matching. Only the answer is kept, so that times can be compared.

use super::detect::{DetectRequest, Detected};
use super::error::JobError;
use super::pair::{MatchRequest, Matched};
use super::request::{Request, Urgency, Work};
use crate::baseline::{self, Searched};
use std::convert::Infallible;
use std::sync::Arc;

/// Request for one step of the comparison of methods.
#[derive(Debug, Clone)]
pub enum CompareRequest {
    /// Finding features by the method that the parameters ask for.
    Detect(DetectRequest),
    /// Matching the features of two bursts.
    Match(MatchRequest),
}

/// Answer to a `CompareRequest`.
#[derive(Debug, Clone)]
pub enum Compared {
    /// The features.
    Detected(Detected),
    /// The matches.
    Matched(Matched),
}

impl Request for CompareRequest {
    type Answer = Compared;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Detect(a), Self::Detect(b)) => a.is_same(b),
            (Self::Match(a), Self::Match(b)) => a.is_same(b),
            _ => false,
        }
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<Compared, JobError> {
        match self {
            Self::Match(request) => request.compute(work).map(Compared::Matched),
            Self::Detect(DetectRequest { burst, params }) => {
                let searched = baseline::search(&burst.burst, &params, work.monitor)?;
                let Searched { detection, params: used, finding, .. } = searched;
                let detection = Arc::new(detection);
                Ok(Compared::Detected(Detected { burst: burst.id, asked: params, params: used, finding, detection }))
            }
        }
    }
}
