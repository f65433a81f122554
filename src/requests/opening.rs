//! Opening a burst.

use super::error::JobError;
use super::open::OpenBurst;
use super::request::{Request, Urgency, Work};
use super::source::BurstSource;
use crate::burst::OpenOptions;
use std::convert::Infallible;

/// A burst to be opened, and how.
#[derive(Debug, Clone)]
pub struct OpenRequest {
    /// Source of the burst.
    pub source: BurstSource,
    /// Options with which it is opened: its calibration.
    pub options: OpenOptions,
}

impl Request for OpenRequest {
    type Answer = OpenBurst;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn is_same(&self, other: &Self) -> bool {
        self.source == other.source && self.options == other.options
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<OpenBurst, JobError> {
        self.source.open(&self.options, work.monitor)
    }
}
