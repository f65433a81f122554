//! Evaluation of the detector on input of exactly known truth, and of camera poses found with its features.
//!
//! Five studies of the detector, each one command (`burstscope evaluate chart|frames|accuracy|noise|advice`):
//!
//! - [`chart`]: in the dark. The number of a chart's discs that each method finds before a tenth of its features are
//!   false, and true against false features over the threshold (the ROC curve).
//!   The same over the number of frames of a burst; [`frames_of_burst`] for a given burst.
//! - [`accuracy`]: in enough light. Errors of positions, scales and motions.
//! - [`pure_noise`]: on noise alone. The number of features found where all are false.
//! - [`advice`]: the sentence about the slopes, against the truth.
//!
//! One study of the use of features, [`mod@matches`] (`burstscope evaluate matches`): matches between bursts.
//!
//! And one of camera poses, [`poses`] (`burstscope evaluate poses`): how far a trajectory is from the true one.
//!
//! A study of the detector is a set of parameters, most of them a [`RowStudy`]: its `run` makes the synthetic bursts,
//! runs the detector in parallel over them and returns a report that can be written as JSON.
//! [`result`](burstscope_core::inspect::result) decides which discs count as found, [`curves`] draws the curves. A
//! study gives the same report for any number of threads, and memory holds at most one burst for each thread.

pub mod accuracy;
pub mod advice;
pub mod chart;
pub mod curves;
pub mod frames_of_burst;
pub mod matches;
mod methods;
pub mod poses;
pub mod pure_noise;
pub mod statistics;

pub use accuracy::{AccuracyReport, AccuracyStudy};
pub use advice::{AdviceReport, AdviceStudy};
pub use burstscope_core::inspect::result::{Curve, Ranking};
pub use chart::{ChartReport, ChartStudy, LookedChart, RowAt};
pub use frames_of_burst::{BurstFramesReport, BurstFramesStudy};
pub use matches::{MatchReport, MatchStudy, Shot};
pub use methods::{BurstMethod, Searches, slopes_of};
pub use pure_noise::{NoiseReport, NoiseStudy};

use crate::synth::Motion;
use burstscope_core::error::{Error, Result};
use burstscope_core::monitor::{Monitor, Stage};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Name of a motion, as on the command line.
pub fn motion_name(motion: Motion) -> &'static str {
    if motion == Motion::OneD { "1d" } else { "2d" }
}

/// Name of a motion in a text.
pub fn motion_label(motion: Motion) -> String {
    motion_name(motion).to_uppercase()
}

/// A study of rows, such as ratios or kinds of noise, each measured on as many synthetic bursts, which differ by their
/// seeds. A study adds the measurement of one burst, and the report of all measurements.
pub trait RowStudy: Sync {
    /// Property that tells a row from others, such as a ratio.
    type Row: Copy + Sync;
    /// Measurements on one burst.
    type Cell: Clone + Send;
    /// Report of a finished study, and of an unfinished one.
    type Report;

    /// Checks all parameters before the first burst is made, because a late error would lose the finished ones.
    ///
    /// # Errors
    /// A parameter of study, chart or detector that makes no sense.
    fn check(&self) -> Result<()>;

    /// The rows, in the order of the report.
    fn rows(&self) -> Vec<Self::Row>;

    /// The first seed, and the number of seeds.
    fn seeds(&self) -> (u64, u64);

    /// Cost of a burst of a row, in steps of the progress, beside that of other rows.
    fn steps(&self, _row: Self::Row) -> usize {
        1
    }

    /// Makes and measures a burst; calls `done` with each number of steps that is finished.
    ///
    /// # Errors
    /// As of [`Self::check`], or cancellation.
    fn cell(&self, row: Self::Row, seed: u64, monitor: &Monitor, done: &(dyn Fn(usize) + Sync)) -> Result<Self::Cell>;

    /// The report of the rows with finished bursts, whose measurements are in the order of their seeds.
    fn report(&self, rows: &[(Self::Row, Vec<Self::Cell>)]) -> Self::Report;

    /// Makes the bursts, measures them and reports.
    ///
    /// # Errors
    /// As of [`Self::cell`].
    fn run(&self, monitor: &Monitor) -> Result<Self::Report> {
        run_rows(self, monitor, None)
    }

    /// Runs the study as `run` does; calls `tell` with the report so far after every burst, one call at a time.
    ///
    /// # Errors
    /// As of [`Self::cell`].
    fn run_telling(&self, monitor: &Monitor, tell: &(dyn Fn(Self::Report) + Sync)) -> Result<Self::Report> {
        run_rows(self, monitor, Some(tell))
    }
}

fn run_rows<S: RowStudy + ?Sized>(
    study: &S,
    monitor: &Monitor,
    tell: Option<&(dyn Fn(S::Report) + Sync)>,
) -> Result<S::Report> {
    study.check()?;
    let (rows, (first_seed, seeds)) = (study.rows(), study.seeds());
    // Seed by seed over all rows, so that every point of a curve exists early and then improves.
    let jobs: Vec<(usize, u64)> = (0..seeds).flat_map(|turn| (0..rows.len()).map(move |row| (row, turn))).collect();
    let report_of = |finished: &BTreeMap<(usize, u64), S::Cell>| {
        let of_row = |(index, &row): (usize, &S::Row)| {
            let cells: Vec<_> = finished.range((index, 0)..=(index, u64::MAX)).map(|(_, cell)| cell.clone()).collect();
            (!cells.is_empty()).then_some((row, cells))
        };
        study.report(&rows.iter().enumerate().filter_map(of_row).collect::<Vec<_>>())
    };
    let finished = Mutex::new(BTreeMap::new());
    let steps = |&(row, _): &(usize, u64)| study.steps(rows[row]);
    run_jobs(&jobs, steps, monitor, |&(row, turn), monitor, done| {
        let cell = study.cell(rows[row], first_seed.wrapping_add(turn), monitor, done)?;
        let mut finished = finished.lock().unwrap_or_else(PoisonError::into_inner);
        finished.insert((row, turn), cell);
        // Under the lock, so that reports arrive one at a time, each with more bursts than the one before.
        if let Some(tell) = tell {
            tell(report_of(&finished));
        }
        Ok(())
    })?;
    Ok(report_of(&finished.into_inner().unwrap_or_else(PoisonError::into_inner)))
}

/// Runs `f` on every job; results, and the failure that counts, follow the order of the jobs. As many jobs run at a
/// time as there are threads, so at most that many hold their memory. `f` reports its steps, of those of `steps`.
fn run_jobs<J: Sync, R: Send>(
    jobs: &[J],
    steps: impl Fn(&J) -> usize,
    monitor: &Monitor,
    f: impl Fn(&J, &Monitor, &(dyn Fn(usize) + Sync)) -> Result<R> + Sync,
) -> Result<Vec<R>> {
    let (total, finished) = (jobs.iter().map(steps).sum::<usize>().max(1), AtomicUsize::new(0));
    let done = |steps: usize| {
        let finished = steps + finished.fetch_add(steps, Ordering::Relaxed);
        monitor.report(Stage::Evaluate, finished as f32 / total as f32);
    };
    let silent = monitor.silent();
    monitor.report(Stage::Evaluate, 0.0);
    let mut results = Vec::with_capacity(jobs.len());
    // In a flat parallel loop a thread that waits inside a job, for its parallel parts, would begin another job.
    for group in jobs.chunks(rayon::current_num_threads()) {
        monitor.check()?;
        // One job a piece: a longer piece would leave threads idle at the end.
        let answers: Vec<Result<R>> = group.par_iter().with_max_len(1).map(|job| f(job, &silent, &done)).collect();
        results.extend(answers.into_iter().collect::<Result<Vec<R>>>()?);
    }
    monitor.check()?;
    Ok(results)
}

/// Numbers of frames in ascending order, each once.
fn ascending(counts: &[usize]) -> Vec<usize> {
    counts.iter().copied().collect::<BTreeSet<_>>().into_iter().collect()
}

fn check_lists(snrs: &[f64], seeds: u64) -> Result<()> {
    if snrs.is_empty() {
        return Err(Error::param("snr", "no ratio is given", "give one or more, such as 0.2,0.35,0.6"));
    }
    if seeds == 0 { Err(Error::param("seeds", "0 charts", "give 1 or more")) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::ChartParams;
    use std::{ops::RangeInclusive, sync::Arc};

    pub fn chart(size: (usize, usize), discs: usize, radius: RangeInclusive<f64>, max_slope: f64) -> ChartParams {
        ChartParams { width: size.0, height: size.1, discs, radius, max_slope, ..ChartParams::default() }
    }

    #[test]
    fn results_are_in_order_and_progress_ends_at_one() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let sink = heard.clone();
        let monitor = Monitor::with_listener(move |p| sink.lock().expect("not poisoned").push(p.fraction));
        let jobs: Vec<usize> = (0..25).collect();
        let square = |&job: &usize, _: &Monitor, done: &(dyn Fn(usize) + Sync)| {
            done(1);
            done(2);
            Ok(job * job)
        };
        assert_eq!(run_jobs(&jobs, |_| 3, &monitor, square), Ok((0..25).map(|job| job * job).collect()));
        let largest = heard.lock().expect("not poisoned").iter().copied().fold(0.0, f32::max);
        assert_eq!(largest, 1.0);
    }

    #[test]
    fn the_first_failure_in_order_is_the_answer_and_cancelling_ends_it() {
        let jobs: Vec<usize> = (0..40).collect();
        let fail = |&job: &usize, _: &Monitor, _: &(dyn Fn(usize) + Sync)| {
            if job % 7 == 5 { Err(Error::param("seeds", format!("{job}"), "none")) } else { Ok(()) }
        };
        let error = run_jobs(&jobs, |_| 1, &Monitor::default(), fail).expect_err("job 5 fails");
        assert_eq!(error.to_string(), "seeds: 5; none");
        let monitor = Monitor::default();
        let cancel = |&job: &usize, monitor: &Monitor, _: &(dyn Fn(usize) + Sync)| {
            if job == 3 {
                monitor.cancel();
            }
            Ok(monitor.check()?)
        };
        assert!(run_jobs(&jobs, |_| 1, &monitor, cancel).is_err_and(|error| error.is_cancelled()));
    }
}
