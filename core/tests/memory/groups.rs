//! A search of many slopes needs the memory that was estimated before it; one that does not fit its memory is done in
//! groups of slopes, within its budget and with the same features.

use crate::allocated::peak_over;
use burstscope_core::detector::{DetectorParams, SlopeGrid, memory};
use burstscope_core::synth::{SceneParams, synth_scene};
use burstscope_core::{Detection, Monitor, detect};

const MB: u64 = 1_000_000;

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
