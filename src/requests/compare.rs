//! A piece of the comparison of methods: opening, detecting, matching, as it is done without keeping anything.

use super::detect::{DetectRequest, Detected};
use super::error::JobError;
use super::open::OpenBurst;
use super::pair::{MatchRequest, Matched};
use super::source::BurstSource;
use crate::baseline::{self, Searched};
use crate::burst::OpenOptions;
use crate::monitor::Monitor;
use std::sync::Arc;

/// A piece of work.
#[derive(Debug, Clone)]
pub enum CompareRequest {
    /// Opening a burst: the gold standard's image, and how.
    Open(BurstSource, OpenOptions),
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
    /// The features.
    Detected(Detected),
    /// The matches.
    Matched(Matched),
}

impl CompareRequest {
    /// Does it. Of a detection nothing is kept, so that its time can be compared with those of other methods.
    ///
    /// # Errors
    /// As opening, detecting, and matching; [`JobError::Cancelled`].
    pub fn compute(self, monitor: &Monitor) -> Result<Compared, JobError> {
        match self {
            Self::Open(source, options) => source.open(&options, monitor).map(Compared::Opened),
            Self::Match(request) => request.compute(monitor).map(Compared::Matched),
            Self::Detect(DetectRequest { burst, params }) => {
                let searched = baseline::search(&burst.burst, &params, monitor)?;
                let Searched { detection, params: used, finding, .. } = searched;
                let detection = Arc::new(detection);
                Ok(Compared::Detected(Detected { burst: burst.id, asked: params, params: used, finding, detection }))
            }
        }
    }
}
