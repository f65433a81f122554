//! Memory of a detection beyond the burst itself is bounded, and a search of many slopes needs the memory that was
//! estimated before it; one that does not fit is done in groups of slopes, within its budget and with the same
//! features.
//!
//! Memory is counted at this program's allocator: the same on every system, whereas the operating system's count
//! depends on memory that an allocator keeps for later. The tests run one at a time, so that nothing else is counted.

#[cfg(feature = "colmap")]
mod colmap;

use burstscope_core::detector::{DetectorParams, SlopeGrid, memory};
use burstscope_core::synth::{SceneParams, synth_scene};
use burstscope_core::{Burst, Detection, Monitor, detect};
use peak_alloc::PeakAlloc;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Lock that blocks all other tests of this program until it is dropped.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

fn allocated_bytes() -> u64 {
    ALLOCATOR.current_usage() as u64
}

/// Peak of the bytes allocated during `work`, beyond those allocated before it.
pub fn peak_over(work: impl FnOnce()) -> u64 {
    let before = allocated_bytes();
    ALLOCATOR.reset_peak_usage();
    work();
    (ALLOCATOR.peak_usage() as u64).saturating_sub(before)
}

const MB: u64 = 1_000_000;

fn found(burst: &Burst, params: &DetectorParams) -> usize {
    detect(burst, params, &Monitor::default()).expect("valid parameters").features.len()
}

#[test]
fn a_search_over_a_line_and_over_a_plane_of_slopes_stay_within_their_bounds() {
    let _alone = crate::alone();
    let scene = SceneParams { width: 1600, height: 1200, snr: 8.0, seed: 7, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("valid parameters");
    let line = DetectorParams { octaves: 16, levels: 3, peak_threshold: 0.0015, ..DetectorParams::default() };
    let plane = DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), ..line.clone() };
    // Two threads, for which the bounds were set; each thread has a window of slopes of its own.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    // Weights of masked frames are kept beside their values.
    let (arm, truth) = synth_scene(&SceneParams { mask: 0.2, ..scene }, &Monitor::default()).expect("valid parameters");
    let masked = truth.masked(arm);
    for (name, burst, params, bound) in [
        ("a line", &burst, line.clone(), 200 * MB),
        ("a plane", &burst, plane, 400 * MB),
        ("masked frames", &masked, line, 200 * MB),
    ] {
        let mut count = 0;
        let params_of = params.clone();
        let peak = peak_over(|| count = pool.install(|| found(burst, &params)));
        println!("{name}: {count} features, {} MB over the burst, at most {} MB", peak / MB, bound / MB);
        let estimate = memory::estimate(&params_of, burst.len(), burst.size());
        println!("{name}: estimated {} MB", estimate / MB);
        assert!(estimate >= peak, "{name}: {} MB estimated, {} MB taken", estimate / MB, peak / MB);
        assert!(estimate < peak.max(bound / 4) * 6, "{name}: {} MB estimated, {} MB taken", estimate / MB, peak / MB);
        assert!(count > 1000, "a search that finds little needs little: {count} features");
        assert!(peak < bound * 9 / 10, "{name}: {} MB of {} MB", peak / MB, bound / MB);
    }
}

#[test]
fn a_search_in_groups_of_slopes_stays_within_its_budget_and_finds_the_same() {
    let _alone = crate::alone();
    let scene = SceneParams { width: 1600, height: 1200, snr: 8.0, seed: 7, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("valid parameters");
    let slopes = SlopeGrid::plane(-2.0..=2.0, 6, -3.0..=3.0, 16);
    let params = DetectorParams { slopes, levels: 3, peak_threshold: 0.0015, ..DetectorParams::default() };
    // Each thread has a window of slopes of its own.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    let search = |budget: u64| {
        memory::set_budget(Some(budget));
        let mut found: Option<Detection> = None;
        let work = || found = Some(detect(&burst, &params, &Monitor::default()).expect("it fits"));
        (peak_over(|| pool.install(work)), found.expect("it was searched"))
    };
    let estimate = pool.install(|| memory::estimate(&params, burst.len(), burst.size()));
    let budget = estimate * 2 / 3;
    let (peak, grouped) = search(budget);
    let (whole_peak, whole) = search(estimate);
    println!(
        "96 slopes: {} MB at once, estimated {} MB; {} MB in groups of {} MB",
        whole_peak / MB,
        estimate / MB,
        peak / MB,
        budget / MB
    );
    assert!(peak < budget, "{} MB of {} MB", peak / MB, budget / MB);
    assert!(peak + 80 * MB < whole_peak, "{} MB and {} MB", peak / MB, whole_peak / MB);
    // A far too large estimate would needlessly split a search that fits.
    assert!(whole_peak < estimate && estimate < 2 * whole_peak, "{} MB of {} MB", whole_peak / MB, estimate / MB);
    assert!(whole.features.len() > 1000 && grouped.features == whole.features);
    assert!(grouped.descriptors == whole.descriptors && grouped.tally == whole.tally);
}
