//! Trait of all requests (an answer or an error, an urgency, equality of two requests), and the progress of one that
//! runs.

use super::{BurstSource, Caches};
use crate::burst::Dump;
use crate::dataset::BurstPicture;
use crate::error::Error;
use crate::monitor::{Cancelled, Monitor, Progress};
use std::time::{Duration, Instant};

/// Two requests are equal if they have the same answer.
pub trait Request: Clone + PartialEq + Send + 'static {
    type Answer: Send + 'static;
    /// A result reported before the answer, such as one burst of many.
    type Partial: Send + 'static;

    /// Urgency of all requests of this kind, unless [`Self::urgency`] says another.
    const URGENCY: Urgency = Urgency::Search;

    fn urgency(&self) -> Urgency {
        Self::URGENCY
    }

    /// Time left to a superseded request of a picture: a slider shows steps in between, and the next waits no longer.
    fn grace(&self) -> Duration {
        Duration::from_millis(250)
    }

    /// The answer, if it is kept and needs no work.
    fn cached(&self, _caches: &Caches) -> Option<Self::Answer> {
        None
    }

    fn compute(self, work: &Work<'_, Self::Partial>) -> Result<Self::Answer, JobError>;
}

/// Makes a request of a type: the answer's type, after a semicolon that of what is reported before it, an urgency other
/// than that of a search, and the computation.
macro_rules! request {
    ($of:ty => $answer:ty $(, $urgency:ident)?: |$this:ident, $work:ident| $compute:block) => {
        request! { $of => $answer; std::convert::Infallible $(, $urgency)?: |$this, $work| $compute }
    };
    ($of:ty => $answer:ty; $partial:ty $(, $urgency:ident)?: |$this:ident, $work:ident| $compute:block) => {
        impl $crate::requests::Request for $of {
            type Answer = $answer;
            type Partial = $partial;
            $(const URGENCY: $crate::requests::Urgency = $crate::requests::Urgency::$urgency;)?

            fn compute($this, $work: &$crate::requests::Work<'_, Self::Partial>) -> Result<$answer, JobError> $compute
        }
    };
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Urgency {
    /// Answers that a person is looking at: pictures, patches, a probed place.
    Picture,
    /// Files that are being written; finished even when the window closes.
    Write,
    /// Pictures that take a search, such as the map of winning slopes.
    SlowPicture,
    Search,
    Dataset,
}

pub struct Work<'a, T> {
    pub caches: Caches,
    pub monitor: &'a Monitor,
    pub tell: &'a (dyn Fn(T) + Sync),
}

impl<'a, T> Work<'a, T> {
    /// Context without results of earlier requests; partial results are dropped.
    pub fn alone(monitor: &'a Monitor) -> Self {
        Self { caches: Caches::new(0), monitor, tell: &|_| {} }
    }
}

/// Identifies one request; later requests have larger ids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct JobId(pub(crate) u64);

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Running {
    pub id: JobId,
    pub started: Instant,
    pub progress: Option<Progress>,
}

impl Running {
    pub fn time_left(&self) -> Option<Duration> {
        time_left(self.started.elapsed(), self.progress?.fraction)
    }
}

/// Time that the rest of a piece of work takes at the pace of the `fraction` that is done; `None` below a fraction of
/// 0.03 and within the first 0.5 s.
pub fn time_left(gone: Duration, fraction: f32) -> Option<Duration> {
    let can_be_told = (0.03..1.0).contains(&fraction) && gone > Duration::from_millis(500);
    can_be_told.then(|| gone.mul_f32((1.0 - fraction) / fraction))
}

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum JobError {
    #[error("cancelled")]
    Cancelled,
    #[error("a newer request took its place")]
    Superseded,
    /// The input, a parameter or a limit is at fault; the message says which and what would be right.
    #[error("{0}")]
    Failed(String),
    #[error("there are {} bursts here; open one of them", .0.len())]
    Several(Vec<BurstSource>),
    /// A file without header: why it was not opened, and the shapes that fill it.
    #[error("{0}")]
    NoShape(String, Vec<PossibleShape>),
    #[error("this is a mistake in Burstscope, please report it: {message} (at {place})")]
    Panicked {
        message: String,
        /// File, line and column.
        place: String,
    },
}

#[derive(Debug, Clone, PartialEq)]
pub struct PossibleShape {
    pub dump: Dump,
    pub frames: u64,
    pub picture: BurstPicture,
}

impl JobError {
    pub(super) fn failed(error: impl std::fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<Cancelled> for JobError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<Error> for JobError {
    fn from(error: Error) -> Self {
        if error.is_cancelled() { Self::Cancelled } else { Self::failed(error) }
    }
}
