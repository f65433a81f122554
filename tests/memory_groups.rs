//! A search that does not fit its memory is done in groups of slopes: within its budget, as the operating system counts
//! it, and with the same features.
//!
//! One test, alone in its program, so that nothing else is counted. Where the system has no `/proc` it says so and
//! stops.

#[path = "common/large_search.rs"]
mod large_search;
#[path = "common/resident.rs"]
mod resident;

use burstscope::detector::memory;
use burstscope::{Detection, Monitor, detect};
use large_search::{MB, large_search, two_threads};
use resident::{peak_bytes, resident_bytes};

#[test]
fn a_search_in_groups_of_slopes_stays_within_its_budget_and_finds_the_same() {
    let (burst, params) = large_search();
    let Some((before, _)) = resident_bytes().zip(peak_bytes(|| ())) else {
        println!("skipped: this system does not tell how much memory a program has had");
        return;
    };
    let pool = two_threads();
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
    // Its peak has in it what the first search left, so that it is held against that one only.
    let (whole_peak, whole) = search(estimate);
    println!("96 slopes: {} MB in groups of {} MB, then {} MB at once", peak / MB, budget / MB, whole_peak / MB);
    assert!(peak < budget, "{} MB of {} MB", peak / MB, budget / MB);
    assert!(peak + 80 * MB < whole_peak, "{} MB and {} MB", peak / MB, whole_peak / MB);
    assert!(whole.features.len() > 1000 && grouped.features == whole.features);
    assert!(grouped.descriptors == whole.descriptors && grouped.tally == whole.tally);
}
