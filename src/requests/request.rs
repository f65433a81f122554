//! Trait of all requests: an answer, an urgency, and equality of two requests.

use super::error::JobError;
use super::picture::{Picture, PictureRequest};
use super::trail::{NothingKept, TrailStore};
use crate::monitor::Monitor;

/// Request with all that decides its answer.
pub trait Request: Clone + Send + 'static {
    /// The answer.
    type Answer: Send + 'static;
    /// A result that is told before the answer, such as one burst of many;
    /// [`Infallible`](std::convert::Infallible) where there is none.
    type Told: Send + 'static;

    /// Urgency of the answer.
    fn urgency(&self) -> Urgency;

    /// Whether `other` has the same answer.
    fn is_same(&self, other: &Self) -> bool;

    /// The answer, if it is kept already and needs no work.
    fn kept(&self, _kept: &Kept<'_>) -> Option<Self::Answer> {
        None
    }

    /// Computes the answer on the calling thread and its pool.
    ///
    /// # Errors
    /// [`JobError::Cancelled`] once the monitor was cancelled; otherwise the reason for which there is no answer.
    fn compute(self, work: &Work<'_, Self::Told>) -> Result<Self::Answer, JobError>;
}

/// The urgency of a request. The first in this order goes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Urgency {
    /// Answers that a person is looking at: pictures, patches, a probed place.
    Picture,
    /// Files that are being written; finished even when the window closes.
    Write,
    /// Pictures that take a search, such as the map of winning slopes.
    SlowPicture,
    /// Opening, detecting, matching.
    Search,
    /// Work on many bursts.
    Dataset,
}

/// Results of earlier requests.
#[derive(Clone, Copy)]
pub struct Kept<'a> {
    /// Trails of detections.
    pub trails: &'a dyn TrailStore,
    /// Pictures.
    pub pictures: &'a dyn PictureStore,
}

/// Pictures that were computed before.
pub trait PictureStore {
    /// The picture of `request`, if it is kept.
    fn get(&self, request: &PictureRequest) -> Option<Picture>;

    /// Keeps `picture`.
    fn put(&self, picture: &Picture);
}

impl PictureStore for NothingKept {
    fn get(&self, _: &PictureRequest) -> Option<Picture> {
        None
    }

    fn put(&self, _: &Picture) {}
}

/// Context in which a request is computed.
pub struct Work<'a, T> {
    /// Results of earlier requests.
    pub kept: Kept<'a>,
    /// Reports progress, and tells of cancellation.
    pub monitor: &'a Monitor,
    /// Takes results that are told before the answer.
    pub tell: &'a (dyn Fn(T) + Sync),
}

impl<'a, T> Work<'a, T> {
    /// Context without results of earlier requests, which drops results that are told before the answer.
    pub fn alone(monitor: &'a Monitor) -> Self {
        Self { kept: Kept { trails: &NothingKept, pictures: &NothingKept }, monitor, tell: &|_| {} }
    }

    /// Uses the trails in `trails`.
    #[must_use]
    pub fn with_trails(self, trails: &'a dyn TrailStore) -> Self {
        Self { kept: Kept { trails, ..self.kept }, ..self }
    }

    /// Passes results before the answer to `tell`.
    #[must_use]
    pub fn telling(self, tell: &'a (dyn Fn(T) + Sync)) -> Self {
        Self { tell, ..self }
    }
}
