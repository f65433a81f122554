//! Independent jobs in parallel, with progress, cancellation and bounded memory.

use super::EvaluateError;
use crate::monitor::{Monitor, Stage};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts the steps of all jobs; each job calls [`Self::done`] for every step of its own.
pub(super) struct Steps<'a> {
    monitor: &'a Monitor,
    finished: AtomicUsize,
    total: usize,
}

impl Steps<'_> {
    /// Counts one more finished step.
    pub(super) fn done(&self) {
        let finished = 1 + self.finished.fetch_add(1, Ordering::Relaxed);
        self.monitor.report(Stage::Evaluate, finished as f32 / self.total.max(1) as f32);
    }
}

/// Runs `f` on every job; results are in the order of the jobs. As many jobs run at a time as there are threads, so at
/// most that many hold their memory. (A flat parallel loop would not ensure that: a thread that waits inside one job,
/// for its own parallel parts, would begin another one.)
///
/// # Errors
/// The first failure in the order of the jobs, or cancellation of the work.
pub(super) fn run_jobs<J: Sync, R: Send>(
    jobs: &[J],
    steps_per_job: usize,
    monitor: &Monitor,
    f: impl Fn(&J, &Monitor, &Steps<'_>) -> Result<R, EvaluateError> + Sync,
) -> Result<Vec<R>, EvaluateError> {
    let steps = Steps { monitor, finished: AtomicUsize::new(0), total: jobs.len() * steps_per_job };
    let silent = monitor.silent();
    monitor.report(Stage::Evaluate, 0.0);
    let mut results = Vec::with_capacity(jobs.len());
    for group in jobs.chunks(rayon::current_num_threads()) {
        monitor.check()?;
        let answers: Vec<Result<R, EvaluateError>> =
            group.par_iter().with_max_len(1).map(|job| f(job, &silent, &steps)).collect();
        for answer in answers {
            results.push(answer?);
        }
    }
    monitor.check()?;
    Ok(results)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    #[test]
    fn results_are_in_order_and_progress_ends_at_one() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let sink = heard.clone();
        let monitor = Monitor::with_listener(move |p| sink.lock().expect("not poisoned").push(p.fraction));
        let jobs: Vec<usize> = (0..25).collect();
        let results = run_jobs(&jobs, 2, &monitor, |&job, _, steps| {
            steps.done();
            steps.done();
            Ok(job * job)
        });
        assert_eq!(results, Ok((0..25).map(|job| job * job).collect()));
        let largest = heard.lock().expect("not poisoned").iter().copied().fold(0.0, f32::max);
        assert_eq!(largest, 1.0);
    }

    #[test]
    fn the_first_failure_in_order_is_the_answer_and_cancelling_ends_it() {
        let jobs: Vec<usize> = (0..40).collect();
        let fail = |&job: &usize, _: &Monitor, _: &Steps<'_>| {
            if job % 7 == 5 { Err(EvaluateError::param("seeds", format!("{job}"), "none")) } else { Ok(()) }
        };
        let error = run_jobs(&jobs, 1, &Monitor::default(), fail).expect_err("job 5 fails");
        assert_eq!(error.to_string(), "seeds: 5; none");
        let monitor = Monitor::default();
        let cancelled = run_jobs(&jobs, 1, &monitor, |&job, monitor, _| {
            if job == 3 {
                monitor.cancel();
            }
            Ok(monitor.check()?)
        });
        assert!(matches!(cancelled, Err(EvaluateError::Cancelled(_))));
    }
}
