//! Price of a change that advice proposes: the number of features with it.

use super::error::JobError;
use super::request::{Request, Urgency, Work};
use super::trail::{DetectionSource, trail_and_rest};
use crate::detector::{ParamChange, Sample};
use crate::inspect::price::{Price, price};
use std::convert::Infallible;

/// Request for the price of a change to a detection.
#[derive(Debug, Clone)]
pub struct PriceRequest {
    /// The detection.
    pub of: DetectionSource,
    /// The change.
    pub change: ParamChange,
    /// Candidate that the change is about, if it is about one.
    pub sample: Option<Sample>,
}

/// Price with its request.
#[derive(Debug, Clone)]
pub struct Priced {
    /// The request.
    pub request: PriceRequest,
    /// The price.
    pub price: Price,
}

impl Request for PriceRequest {
    type Answer = Priced;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn is_same(&self, other: &Self) -> bool {
        self.of.is_same(&other.of) && (&self.change, self.sample) == (&other.change, other.sample)
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<Priced, JobError> {
        let (cache, rest) = trail_and_rest(work.kept.trails, &self.of, work.monitor)?;
        let price = price(&cache, &self.of.burst.burst, &self.change, self.sample, &rest)?;
        Ok(Priced { request: self, price })
    }
}
