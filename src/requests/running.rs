//! What is told of a request while it runs.

use crate::monitor::Progress;
use std::time::{Duration, Instant};

/// Identifies one request; later requests have larger ids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct JobId(pub(crate) u64);

/// How far a running request is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Running {
    /// Which request.
    pub id: JobId,
    /// Since when.
    pub started: Instant,
    /// The stage and fraction it last reported.
    pub progress: Option<Progress>,
}

impl Running {
    /// How long it still takes if it goes on as it went so far; `None` while that cannot be told.
    pub fn time_left(&self) -> Option<Duration> {
        let fraction = self.progress?.fraction;
        let gone = self.started.elapsed();
        let can_be_told = (0.03..1.0).contains(&fraction) && gone > Duration::from_millis(500);
        can_be_told.then(|| gone.mul_f32((1.0 - fraction) / fraction))
    }
}
