//! Evaluation of the detector on input of exactly known truth, and of camera poses found with its features.
//!
//! Five studies of the detector, each one command (`burstscope evaluate chart|frames|accuracy|noise|advice`):
//!
//! - [`chart`]: in the dark. The number of a chart's discs that each method finds before a tenth of its features are
//!   false, and true against false features over the threshold (the ROC curve).
//! - [`frames`]: the measures of `chart` over the number of frames of a burst; [`frames_of_burst`] for a given burst.
//! - [`accuracy`]: in enough light. Errors of positions, scales and motions.
//! - [`pure_noise`]: on noise alone. The number of features found where all are false.
//! - [`advice`]: the sentence about the slopes, against the truth.
//!
//! One study of the use of features, [`mod@matches`] (`burstscope evaluate matches`): matches between bursts.
//!
//! And one of camera poses, [`poses`] (`burstscope evaluate poses`): how far a trajectory is from the true one.
//!
//! A study of the detector is a set of parameters; its `run` makes the synthetic bursts, runs the detector in parallel
//! over them and returns a report that can be written as JSON. [`result`](burstscope_core::inspect::result) decides which
//! discs count as found, [`curves`] draws the curves. The same study gives the same report for any number of threads,
//! and memory holds at most one burst for each thread.

pub mod accuracy;
pub mod advice;
pub mod chart;
pub mod curves;
pub mod frames;
pub mod frames_of_burst;
pub mod matches;
mod methods;
pub mod poses;
pub mod pure_noise;
pub mod statistics;

pub use accuracy::{AccuracyReport, AccuracyStudy};
pub use advice::{AdviceReport, AdviceStudy};
pub use burstscope_core::inspect::result::{Curve, Ranking};
pub use chart::{ChartReport, ChartStudy, LookedChart};
pub use frames::{FramesReport, FramesStudy};
pub use frames_of_burst::{BurstFramesReport, BurstFramesStudy};
pub use matches::{MatchReport, MatchStudy, Shot};
pub use methods::{BurstMethod, Searches, slopes_of};
pub use pure_noise::{NoiseReport, NoiseStudy};

use crate::synth::Motion;
use burstscope_core::error::{Error, Result};
use burstscope_core::monitor::{Monitor, Stage};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Name of a motion, as on the command line.
pub fn motion_name(motion: Motion) -> &'static str {
    match motion {
        Motion::OneD => "1d",
        Motion::TwoD => "2d",
    }
}

fn check_lists(snrs: &[f64], seeds: u64) -> Result<()> {
    if snrs.is_empty() {
        return Err(Error::param("snr", "no ratio is given", "give one or more, such as 0.2,0.35,0.6"));
    }
    if seeds == 0 {
        return Err(Error::param("seeds", "0 charts", "give 1 or more"));
    }
    Ok(())
}

/// Counts the steps of all jobs; each job calls [`Self::done`] for every step of its own.
struct Steps<'a> {
    monitor: &'a Monitor,
    finished: AtomicUsize,
    total: usize,
}

impl Steps<'_> {
    fn done(&self) {
        let finished = 1 + self.finished.fetch_add(1, Ordering::Relaxed);
        self.monitor.report(Stage::Evaluate, finished as f32 / self.total.max(1) as f32);
    }
}

/// Runs `f` on every job; results, and the failure that counts, follow the order of the jobs. As many jobs run at a
/// time as there are threads, so at most that many hold their memory.
fn run_jobs<J: Sync, R: Send>(
    jobs: &[J],
    steps_per_job: usize,
    monitor: &Monitor,
    f: impl Fn(&J, &Monitor, &Steps<'_>) -> Result<R> + Sync,
) -> Result<Vec<R>> {
    let steps = Steps { monitor, finished: AtomicUsize::new(0), total: jobs.len() * steps_per_job };
    let silent = monitor.silent();
    monitor.report(Stage::Evaluate, 0.0);
    let mut results = Vec::with_capacity(jobs.len());
    // In a flat parallel loop a thread that waits inside a job, for its parallel parts, would begin another job.
    for group in jobs.chunks(rayon::current_num_threads()) {
        monitor.check()?;
        // One job a piece: a longer piece would leave threads idle at the end.
        let answers: Vec<Result<R>> = group.par_iter().with_max_len(1).map(|job| f(job, &silent, &steps)).collect();
        for answer in answers {
            results.push(answer?);
        }
    }
    monitor.check()?;
    Ok(results)
}

/// A ratio and the results of its finished charts, in the order of their seeds.
type RatioCharts<C> = (f64, Vec<C>);

/// Runs `f`, which has `steps` steps, on every ratio and seed, and returns the `report` of the results. Calls `tell`
/// with the report so far after every chart, from any thread, one call at a time; ratios without a chart are left out.
fn run_charts<C: Clone + Send, R>(
    snrs: &[f64],
    seeds: Range<u64>,
    steps: usize,
    monitor: &Monitor,
    f: impl Fn(f64, u64, &Monitor, &Steps<'_>) -> Result<C> + Sync,
    report: impl Fn(&[RatioCharts<C>]) -> R + Sync,
    tell: &(dyn Fn(R) + Sync),
) -> Result<R> {
    // Seed by seed over all ratios, so that every point of a curve exists early and then improves.
    let jobs: Vec<(usize, u64)> = seeds.flat_map(|seed| (0..snrs.len()).map(move |row| (row, seed))).collect();
    let report_of = |finished: &BTreeMap<(usize, u64), C>| {
        let of_ratio = |(row, &snr): (usize, &f64)| {
            let charts: Vec<C> = finished.range((row, 0)..=(row, u64::MAX)).map(|(_, chart)| chart.clone()).collect();
            (!charts.is_empty()).then_some((snr, charts))
        };
        report(&snrs.iter().enumerate().filter_map(of_ratio).collect::<Vec<_>>())
    };
    let finished = Mutex::new(BTreeMap::new());
    run_jobs(&jobs, steps, monitor, |&(row, seed), monitor, steps| {
        let chart = f(snrs[row], seed, monitor, steps)?;
        let mut finished = finished.lock().unwrap_or_else(PoisonError::into_inner);
        finished.insert((row, seed), chart);
        // Under the lock, so that reports arrive one at a time, each with more charts than the one before.
        tell(report_of(&finished));
        Ok(())
    })?;
    Ok(report_of(&finished.into_inner().unwrap_or_else(PoisonError::into_inner)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

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
            if job % 7 == 5 { Err(Error::param("seeds", format!("{job}"), "none")) } else { Ok(()) }
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
        assert!(cancelled.is_err_and(|error| error.is_cancelled()));
    }
}
