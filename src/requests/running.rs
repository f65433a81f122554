//! Progress of a request while it runs.

use crate::monitor::Progress;
use std::time::{Duration, Instant};

/// Identifies one request; later requests have larger ids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct JobId(pub(crate) u64);

/// Progress of a running request.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Running {
    /// Id of the request.
    pub id: JobId,
    /// Time at which it began.
    pub started: Instant,
    /// The stage and fraction it last reported.
    pub progress: Option<Progress>,
}

impl Running {
    /// Estimate of the time left at the present speed; `None` while there is none.
    pub fn time_left(&self) -> Option<Duration> {
        time_left(self.started.elapsed(), self.progress?.fraction)
    }
}

/// Estimate of the time left of work that has done `fraction` in `gone`, at the present speed; `None` below a
/// fraction of 0.03 and within the first 0.5 s.
fn time_left(gone: Duration, fraction: f32) -> Option<Duration> {
    let can_be_told = (0.03..1.0).contains(&fraction) && gone > Duration::from_millis(500);
    can_be_told.then(|| gone.mul_f32((1.0 - fraction) / fraction))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_follows_from_what_is_done() {
        let left = |millis, fraction| time_left(Duration::from_millis(millis), fraction);
        assert_eq!(left(10_000, 0.5), Some(Duration::from_secs(10)));
        assert_eq!(left(1_000, 0.25), Some(Duration::from_secs(3)));
        assert_eq!(left(10_000, 0.01), None, "too early to say");
        assert_eq!(left(400, 0.5), None, "too short to say");
        assert_eq!(left(10_000, 1.0), None, "it is done");
    }
}
