//! A search of all slopes at once takes no more than was estimated before it, as the operating system counts it.
//!
//! One test, alone in its program, so that nothing else is counted. Where the system has no `/proc` it says so and
//! stops.

#[path = "common/large_search.rs"]
mod large_search;
#[path = "common/resident.rs"]
mod resident;

use burstscope::detector::memory;
use burstscope::{Monitor, detect};
use large_search::{MB, large_search, two_threads};
use resident::{peak_bytes, resident_bytes};

#[test]
fn a_search_of_all_slopes_at_once_takes_no_more_than_was_estimated() {
    let (burst, params) = large_search();
    let Some((before, _)) = resident_bytes().zip(peak_bytes(|| ())) else {
        println!("skipped: this system does not tell how much memory a program has had");
        return;
    };
    let pool = two_threads();
    let estimate = pool.install(|| memory::estimate(&params, burst.len(), burst.size()));
    memory::set_budget(Some(estimate));
    let mut features = 0;
    let work = || features = detect(&burst, &params, &Monitor::default()).expect("it fits").features.len();
    let peak = peak_bytes(|| pool.install(work)).expect("it could before").saturating_sub(before);
    println!("96 slopes: {} MB at once, estimated {} MB", peak / MB, estimate / MB);
    assert!(features > 1000);
    assert!(peak < estimate, "{} MB, estimated {} MB", peak / MB, estimate / MB);
    // An estimate that is far too large would cut what fits.
    assert!(2 * peak > estimate, "{} MB, estimated {} MB", peak / MB, estimate / MB);
}
