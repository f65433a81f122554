//! Memory is bounded: what a detection needs beyond the burst itself, as the operating system counts it.
//!
//! One test, alone in its program, so that nothing else is counted. Where the system has no `/proc` it says so and
//! stops.

use burstscope::detector::{DetectorParams, SlopeGrid};
use burstscope::synth::{SceneParams, synth_scene};
use burstscope::{Burst, Monitor, detect};

const MB: u64 = 1_000_000;

/// A number of bytes from `/proc/self/status`.
fn status_bytes(field: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with(field))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

/// The most memory that `work` had beyond what there was before. `None` where the system cannot tell.
fn peak_over(work: impl FnOnce()) -> Option<u64> {
    // Writing 5 makes the system forget the peak so far.
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    let before = status_bytes("VmRSS")?;
    work();
    Some(status_bytes("VmHWM")?.saturating_sub(before))
}

fn found(burst: &Burst, params: &DetectorParams) -> usize {
    detect(burst, params, &Monitor::default()).expect("valid parameters").features.len()
}

#[test]
fn a_search_over_a_line_and_over_a_plane_of_slopes_stay_within_their_bounds() {
    if peak_over(|| ()).is_none() {
        println!("skipped: this system does not tell how much memory a program has had");
        return;
    }
    let scene = SceneParams { width: 1600, height: 1200, snr: 8.0, seed: 7, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("valid parameters");
    let line = DetectorParams { octaves: 16, levels: 3, peak_threshold: 0.0015, ..DetectorParams::default() };
    let plane = DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), ..line.clone() };
    // Two threads, as the bounds were set for; each thread has a window of slopes of its own.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    for (name, params, bound) in [("a line", line, 200 * MB), ("a plane", plane, 400 * MB)] {
        let mut count = 0;
        let peak = peak_over(|| count = pool.install(|| found(&burst, &params))).expect("it could before");
        println!("{name}: {count} features, {} MB over the burst, at most {} MB", peak / MB, bound / MB);
        assert!(count > 1000, "a search that finds little needs little: {count} features");
        assert!(peak < bound * 9 / 10, "{name}: {} MB of {} MB", peak / MB, bound / MB);
    }
}
