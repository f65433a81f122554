//! Reading many frames at once: progress by frame, cancellation between frames, and the first failure in frame order.

use super::error::OpenError;
use crate::monitor::{Monitor, Stage};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counter of finished frames, for use from any thread.
pub(super) struct Ticker<'a> {
    monitor: &'a Monitor,
    done: AtomicUsize,
    total: usize,
    quiet: bool,
}

impl<'a> Ticker<'a> {
    /// Counter that reports the finished fraction of `total` frames to `monitor`.
    pub(super) fn new(monitor: &'a Monitor, total: usize) -> Self {
        Self { monitor, done: AtomicUsize::new(0), total, quiet: false }
    }

    /// Counter that checks for cancellation, but reports nothing.
    pub(super) fn quiet(monitor: &'a Monitor) -> Self {
        Self { quiet: true, ..Self::new(monitor, 0) }
    }

    /// The monitor for cancellation and reports.
    pub(super) fn monitor(&self) -> &'a Monitor {
        self.monitor
    }

    /// Fails once the user has cancelled.
    pub(super) fn check(&self) -> Result<(), OpenError> {
        Ok(self.monitor.check()?)
    }

    /// Counts one more finished frame.
    pub(super) fn tick(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        if !self.quiet {
            self.monitor.report(Stage::Open, done as f32 / self.total.max(1) as f32);
        }
    }
}

/// Computes `f(0) … f(count − 1)` in parallel. When several fail, the error is that of the lowest index, whatever the
/// number of threads, so that a user who mends one file after the other sees them in order.
pub(super) fn in_order<T: Send>(
    count: usize,
    f: impl Fn(usize) -> Result<T, OpenError> + Sync,
) -> Result<Vec<T>, OpenError> {
    let first_failure = AtomicUsize::new(usize::MAX);
    let answers: Vec<Option<Result<T, OpenError>>> = (0..count)
        .into_par_iter()
        .with_max_len(1)
        .map(|i| {
            if i > first_failure.load(Ordering::Relaxed) {
                return None; // an earlier one failed: this one is not needed
            }
            let answer = f(i);
            if answer.is_err() {
                first_failure.fetch_min(i, Ordering::Relaxed);
            }
            Some(answer)
        })
        .collect();
    // Skipped items come after a failure, so `flatten` never drops one before the first error.
    answers.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_failure_in_order_is_the_answer() {
        let fail = |path: usize| OpenError::EmptyFile { path: path.to_string().into() };
        for _ in 0..50 {
            let answer = in_order(100, |i| if i % 7 == 5 { Err(fail(i)) } else { Ok(i) });
            assert_eq!(answer, Err(fail(5)));
        }
        assert_eq!(in_order(100, Ok), Ok((0..100).collect()));
    }
}
