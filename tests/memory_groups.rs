//! A search that does not fit its memory is done in groups of slopes: within its budget, as the operating system counts
//! it, and with the same features.
//!
//! One test, alone in its program, so that nothing else is counted. Where the system has no `/proc` it says so and
//! stops.

#[path = "common/resident.rs"]
mod resident;

use burstscope::detector::{DetectorParams, SlopeGrid, memory};
use burstscope::synth::{SceneParams, synth_scene};
use burstscope::{Detection, Monitor, detect};
use resident::{peak_bytes, resident_bytes};

const MB: u64 = 1_000_000;

#[test]
fn a_search_in_groups_of_slopes_stays_within_its_budget_and_finds_the_same() {
    let scene = SceneParams { width: 1600, height: 1200, snr: 8.0, seed: 7, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("valid parameters");
    let slopes = SlopeGrid::plane(-2.0..=2.0, 6, -3.0..=3.0, 16);
    let params = DetectorParams { slopes, levels: 3, peak_threshold: 0.0015, ..DetectorParams::default() };
    let Some((before, _)) = resident_bytes().zip(peak_bytes(|| ())) else {
        println!("skipped: this system does not tell how much memory a program has had");
        return;
    };
    // Each thread has a window of slopes of its own.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    // What a search gives back may stay with the program, so both are held against what there was before both.
    let search = |budget: u64| {
        memory::set_budget(Some(budget));
        let mut found: Option<Detection> = None;
        let work = || found = Some(detect(&burst, &params, &Monitor::default()).expect("it fits"));
        let peak = peak_bytes(|| pool.install(work)).expect("it could before").saturating_sub(before);
        (peak, found.expect("it was searched"))
    };
    let estimate = pool.install(|| memory::estimate(&params, burst.len(), burst.size()));
    let budget = estimate * 2 / 3;
    let (peak, grouped) = search(budget);
    let (whole_peak, whole) = search(estimate);
    println!("96 slopes: {} MB at once, {} MB in groups of {} MB", whole_peak / MB, peak / MB, budget / MB);
    assert!(peak < budget && whole_peak < estimate, "{} MB and {} MB", peak / MB, whole_peak / MB);
    assert!(peak + 80 * MB < whole_peak, "{} MB and {} MB", peak / MB, whole_peak / MB);
    assert!(whole.features.len() > 1000 && grouped.features == whole.features);
    assert!(grouped.descriptors == whole.descriptors && grouped.tally == whole.tally);
}
