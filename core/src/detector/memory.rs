//! Memory limit of a search: its need is estimated first; a larger one goes in groups of slopes, or is refused.
//!
//! For every slope the first level of each octave after the first is held. Besides, there are the frames, cleaned by
//! the noise model and at each octave's resolution, and the threads' windows of slopes.
//!
//! All searches of the process share one budget: a search plans with the memory that running ones leave. A search that
//! does not fit goes in its smallest form rather than waiting: another may be waiting for the thread that started it.

pub use crate::plane::memory::machine_bytes;

use super::params::{DetectorParams, Method, SearchParams};
use super::scale_space::{octave_size, searched_octaves};
use crate::detector::localise::slopes_around;
use crate::detector::search::setup::SlopeGroup;
use crate::detector::search::slope_window::OtherSlopes;
use crate::error::{Error, Result};
use crate::kernel::machine::{WINDOW_BYTES, WINDOWS_BYTES};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Part of the machine's memory that searches may take by default.
pub const DEFAULT_PART: f64 = 0.75;

/// Name of the budget on the command line.
pub const OPTION: &str = "memory";

/// Budget in bytes; 0 for the default.
static BUDGET: AtomicU64 = AtomicU64::new(0);

/// Sets the memory of all searches of this process together, bytes; `None` is [`DEFAULT_PART`] of the machine's.
pub fn set_budget(bytes: Option<u64>) {
    BUDGET.store(bytes.map_or(0, |bytes| bytes.max(1)), Ordering::Relaxed);
}

/// Memory that searches may take, bytes; `None` where none was set and the machine's memory is not known.
pub fn budget() -> Option<u64> {
    match BUDGET.load(Ordering::Relaxed) {
        0 => machine_bytes().map(|bytes| (bytes as f64 * DEFAULT_PART) as u64),
        bytes => Some(bytes),
    }
}

/// Part of the budget for data that detections keep to explain their results, at most [`KEPT_BYTES`].
const KEPT_PART: f64 = 0.125;
/// Maximum of that data, whatever the budget, bytes.
const KEPT_BYTES: u64 = 512 << 20;

/// Memory for data that detections keep to explain their results, bytes; such a search has the rest.
pub fn kept_bytes() -> u64 {
    budget().map_or(KEPT_BYTES, |budget| ((budget as f64 * KEPT_PART) as u64).min(KEPT_BYTES))
}

/// Checks, before a burst is opened, that its search will be possible: `frames` frames of `size` (columns, rows), of
/// which `params` may leave some out, within [`budget`]. Slopes yet to be found count as a single slope, the fewest.
///
/// # Errors
/// As the search itself: the error gives the memory that it needs at least, and settings that need less.
pub fn check_before_opening(params: &SearchParams, frames: usize, size: (usize, usize)) -> Result<()> {
    let detector = params.at_given();
    // A merge is a single image when it is searched.
    let frames = if detector.method == Method::Merge { 1 } else { detector.used_frames(frames).len() };
    Plan::new(SearchSize { params: &detector, frames, size }, budget()).map(|_| ())
}

/// Estimate of the bytes that a search of all slopes at once needs besides a burst of `frames` frames of `size`.
pub fn estimate(params: &DetectorParams, frames: usize, size: (usize, usize)) -> u64 {
    SearchSize { params, frames, size }.bytes_on(rayon::current_num_threads())
}

/// A search with `params` in which `frames` frames of `size` (columns, rows) take part.
#[derive(Clone, Copy)]
pub(crate) struct SearchSize<'a> {
    pub(crate) params: &'a DetectorParams,
    pub(crate) frames: usize,
    pub(crate) size: (usize, usize),
}

impl SearchSize<'_> {
    fn bytes_on(self, threads: usize) -> u64 {
        let slopes = self.params.used_slopes().len() as u64;
        slopes.saturating_mul(self.bytes_of_slope()).saturating_add(self.bytes_beside_slopes(threads))
    }

    /// Memory that a search on `threads` threads needs, whatever the number of slopes; bytes.
    fn bytes_beside_slopes(self, threads: usize) -> u64 {
        let windows = threads.saturating_mul(WINDOW_BYTES).min(WINDOWS_BYTES);
        // Cleaned frames and their octaves, or binned frames and the means of the octaves above: 7/3 of the frames.
        let of_frames = (self.frames as u64).saturating_mul(plane_bytes(self.size)).saturating_mul(7) / 3;
        of_frames.saturating_add(windows as u64)
    }

    fn bytes_of_slope(self) -> u64 {
        let octaves = searched_octaves(self.params, self.size).skip(1);
        octaves.map(|octave| plane_bytes(octave_size(self.size, octave))).sum()
    }
}

fn plane_bytes((width, height): (usize, usize)) -> u64 {
    (width as u64).saturating_mul(height as u64).saturating_mul(size_of::<f32>() as u64)
}

#[derive(Debug)]
pub(crate) struct Account {
    taken: Mutex<u64>,
}

pub(crate) static OF_PROCESS: Account = Account::new();

/// Memory of a search, returned to the account when dropped.
#[derive(Debug)]
pub(crate) struct Share<'account> {
    account: &'account Account,
    bytes: u64,
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        let mut taken = self.account.taken();
        *taken = taken.saturating_sub(self.bytes);
    }
}

impl Account {
    pub(crate) const fn new() -> Self {
        Self { taken: Mutex::new(0) }
    }

    fn taken(&self) -> MutexGuard<'_, u64> {
        // A number stays valid if a thread panics while it holds the lock.
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Plans as [`Plan::new`], within the part of `budget` that the other searches of this account leave.
    pub(crate) fn plan(&self, wanted: SearchSize<'_>, budget: Option<u64>) -> Result<(Plan, Share<'_>)> {
        // The lock is held while planning, so that two searches cannot take the same room.
        let mut taken = self.taken();
        let left = budget.map(|budget| budget.saturating_sub(*taken));
        // A search that finds no room takes the least memory of its own instead of waiting for others.
        let plan = Plan::new(wanted, left).or_else(|_| Plan::smallest(wanted, budget))?;
        let share = Share { account: self, bytes: plan.bytes };
        *taken = taken.saturating_add(share.bytes);
        Ok((plan, share))
    }
}

/// Groups, threads and memory of a search; they do not change the result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Plan {
    /// Groups in which slopes are searched; a single one if all fit.
    pub(crate) search: Vec<SlopeGroup>,
    /// Groups in which keypoints are localised and described; one if the search has one.
    pub(crate) describe: Vec<SlopeGroup>,
    /// Number of threads. Each holds its own window of slopes, so a small budget may have room for few.
    pub(crate) threads: usize,
    /// Estimate of the most memory taken besides the burst, bytes.
    pub(crate) bytes: u64,
}

impl Plan {
    /// Plans the `wanted` search within `budget` bytes, or without a bound, on as many threads as have room. Where even
    /// the smallest form needs more, the error gives its least memory.
    pub(crate) fn new(wanted: SearchSize<'_>, budget: Option<u64>) -> Result<Self> {
        // Each thread holds a window of its own: as many threads are taken as have room.
        let several = (2..=rayon::current_num_threads()).rev();
        let fitting = several.map(|threads| Self::on(threads, wanted, budget)).find_map(Result::ok);
        // The error for one thread gives the least memory.
        fitting.map_or_else(|| Self::on(1, wanted, budget), Ok)
    }

    /// Plan with the least memory, within `budget` bytes: one thread, and groups of the fewest slopes.
    pub(crate) fn smallest(wanted: SearchSize<'_>, budget: Option<u64>) -> Result<Self> {
        let of_slopes = wanted.bytes_of_slope().saturating_mul(min_slopes(wanted.params) as u64);
        let min = wanted.bytes_beside_slopes(1).saturating_add(of_slopes);
        Self::on(1, wanted, Some(budget.map_or(min, |budget| budget.min(min))))
    }

    fn on(threads: usize, wanted: SearchSize<'_>, budget: Option<u64>) -> Result<Self> {
        let params = wanted.params;
        let grid = params.used_slopes();
        let (count, of_slope, needed) = (grid.len(), wanted.bytes_of_slope(), wanted.bytes_on(threads));
        let Some(budget) = budget.filter(|budget| *budget < needed) else {
            let whole = vec![SlopeGroup::whole(count)];
            return Ok(Self { search: whole.clone(), describe: whole, threads, bytes: needed });
        };
        let beside = wanted.bytes_beside_slopes(threads);
        let fitting = (budget.saturating_sub(beside) / of_slope.max(1)).min(count as u64) as usize;
        let reach = OtherSlopes::of(params).reach(&grid);
        // Since the whole did not fit, even no slopes may exceed the budget.
        let cut = |reach| SlopeGroup::cut(count, reach, fitting).filter(|_| beside <= budget);
        if let (Some(search), Some(describe)) = (cut(reach), cut(Some(slopes_around(params, &grid)))) {
            let visited = search.iter().chain(&describe).map(|group| group.visited.len()).max().unwrap_or(count);
            let bytes = beside.saturating_add(of_slope.saturating_mul(visited as u64));
            return Ok(Self { search, describe, threads, bytes });
        }
        let min = beside.saturating_add(of_slope.saturating_mul(min_slopes(params) as u64));
        Err(refusal(wanted, min, budget, fitting))
    }

    pub(crate) fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        // If the system gives no more threads, the pool's are used, and the search may take more memory.
        if self.threads >= rayon::current_num_threads() { work() } else { on_threads(self.threads, work) }
    }
}

/// Calls `work` in a pool of `threads` threads (0: as usual), or in the current one if the system gives no threads.
pub(crate) fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

/// Least number of slopes held at once: a slope, and its neighbours for comparison and localisation.
fn min_slopes(params: &DetectorParams) -> usize {
    let grid = params.used_slopes();
    let reach = OtherSlopes::of(params).reach(&grid);
    reach.map_or(grid.len(), |reach| (2 * reach.max(slopes_around(params, &grid)) + 1).min(grid.len()))
}

/// Error for a search that needs at least `min` bytes where `budget` bytes hold `fitting` slopes.
fn refusal(SearchSize { params, frames, size }: SearchSize<'_>, min: u64, budget: u64, fitting: usize) -> Error {
    let (grid, min_slopes) = (params.used_slopes(), min_slopes(params));
    let less = match fitting {
        0 => "a larger first octave, fewer frames or a smaller picture would take less".to_owned(),
        count => format!("{count} slopes fit, and a larger first octave takes less"),
    };
    let way_out = match OtherSlopes::of(params).reach(&grid) {
        None => format!("other rules than buff need only some slopes at once; {less}"),
        Some(_) if fitting > 0 && grid.is_plane() => format!("rows of fewer slopes take less; {less}"),
        Some(_) => less,
    };
    Error::param(
        OPTION,
        format!(
            "this search of {} slopes in {frames} frames of {}×{} needs about {} at least, with {min_slopes} slopes at \
             once, and {} may be used",
            grid.len(),
            size.0,
            size.1,
            said(min),
            said(budget)
        ),
        format!("{way_out}; or allow more"),
    )
}

fn said(bytes: u64) -> String {
    let bytes = bytes as f64;
    if bytes < 1e9 { format!("{:.0} MB", bytes / 1e6) } else { format!("{:.1} GB", bytes / 1e9) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::{Rules, SlopeExtrema, SlopeGrid};

    const SIZE: (usize, usize) = (1600, 1200);

    fn plane(side: usize) -> DetectorParams {
        DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, side, -3.0..=3.0, side), ..DetectorParams::default() }
    }

    fn wanted(params: &DetectorParams) -> SearchSize<'_> {
        SearchSize { params, frames: 10, size: SIZE }
    }

    fn plan(params: &DetectorParams, budget: Option<u64>) -> Result<Plan> {
        Plan::new(wanted(params), budget)
    }

    #[test]
    fn a_search_plans_with_what_others_leave() {
        let (params, account) = (plane(20), Account::new());
        let plan = |budget| account.plan(wanted(&params), Some(budget));
        let (alone, share) = plan(1 << 50).expect("it fits");
        assert_eq!((alone.search.len(), share.bytes), (1, alone.bytes));
        let budget = alone.bytes + alone.bytes / 2;
        let (beside, second) = plan(budget).expect("in groups");
        assert!(beside.search.len() > 1 && beside.bytes < alone.bytes, "{beside:?}");
        let (third, _) = plan(budget).expect("in its smallest form");
        assert_eq!(third, Plan::smallest(wanted(&params), Some(budget)).expect("it fits"));
        assert_eq!(third.threads, 1);
        drop((share, second));
        let (again, _) = plan(budget).expect("the others gave back what they had");
        assert_eq!(again, alone);
        assert!(plan(1000).is_err(), "a search that never fits is refused");
    }

    #[test]
    fn what_fits_is_one_group_and_what_does_not_is_several_that_fit() {
        for budget in [None, Some(1 << 40)] {
            let plan = plan(&plane(49), budget).expect("it fits");
            assert_eq!((plan.search.len(), plan.describe.len()), (1, 1));
        }
        let of_slope = wanted(&plane(49)).bytes_of_slope();
        let beside = wanted(&plane(49)).bytes_beside_slopes(rayon::current_num_threads());
        let budget = 2_000_000_000;
        let Plan { search, describe, .. } = plan(&plane(49), Some(budget)).expect("in groups");
        assert!(search.len() > 2 && describe.len() >= search.len());
        for group in search.iter().chain(&describe) {
            assert!(beside + of_slope * group.visited.len() as u64 <= budget, "{group:?}");
        }
        // Slopes are searched each for itself, and localised between their neighbours.
        assert_eq!(search[1].own, search[1].visited);
        assert_eq!(describe[1].own.start - describe[1].visited.start, 50);
    }

    #[test]
    fn a_small_budget_takes_fewer_threads_before_it_refuses() {
        let params = plane(49);
        let small = SearchSize { size: (480, 360), ..wanted(&params) };
        let of = |threads, budget| Plan::on(threads, small, Some(budget));
        let one = (1..).map(|step| step * 1_000_000).find(|budget| of(1, *budget).is_ok()).expect("one is enough");
        let many = rayon::ThreadPoolBuilder::new().num_threads(8).build().expect("a pool");
        let threads = |budget| many.install(|| Plan::new(small, Some(budget))).map(|plan| plan.threads);
        assert!(of(8, one).is_err(), "one thread needs less than eight");
        assert_eq!(threads(one), Ok(1));
        assert!(threads(one + 20_000_000).is_ok_and(|threads| (2..8).contains(&threads)));
        assert_eq!(threads(1 << 40), Ok(8));
        let plan = many.install(|| Plan::new(small, Some(one))).expect("it fits");
        assert_eq!(many.install(|| plan.run(rayon::current_num_threads)), 1);
    }

    #[test]
    fn what_does_not_fit_even_so_is_refused_with_the_number_and_the_way_out() {
        let refused = |params: &DetectorParams, budget| plan(params, Some(budget)).expect_err("too much").to_string();
        let all = DetectorParams { slope_extrema: SlopeExtrema::Joint, rules: Rules::BUFF, ..plane(49) };
        let error = refused(&all, 1_000_000_000);
        assert!(error.contains("memory: ") && error.contains("2401 slopes at once"), "{error}");
        assert!(error.contains("1.0 GB") && error.contains("other rules than buff"), "{error}");
        let error = refused(&plane(49), 300_000_000);
        assert!(error.contains("101 slopes at once") && error.contains("rows of fewer slopes"), "{error}");
        let error = refused(&plane(49), 1000);
        assert!(error.contains("larger first octave") && error.contains("0 MB may be used"), "{error}");
        // Without coarser octaves nothing is held for a slope: the frames alone are too much.
        assert!(plan(&DetectorParams { octaves: 1, ..plane(49) }, Some(1000)).is_err());
    }
}
