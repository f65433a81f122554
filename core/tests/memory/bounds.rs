//! Memory is bounded: the memory of a detection beyond the burst itself.

use crate::allocated::peak_over;
use burstscope_core::detector::{DetectorParams, SlopeGrid, memory};
use burstscope_core::synth::{SceneParams, synth_scene};
use burstscope_core::{Burst, Monitor, detect};

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
    for (name, params, bound) in [("a line", line, 200 * MB), ("a plane", plane, 400 * MB)] {
        let mut count = 0;
        let params_of = params.clone();
        let peak = peak_over(|| count = pool.install(|| found(&burst, &params)));
        println!("{name}: {count} features, {} MB over the burst, at most {} MB", peak / MB, bound / MB);
        let estimate = memory::estimate(&params_of, burst.len(), burst.size());
        println!("{name}: estimated {} MB", estimate / MB);
        assert!(
            estimate >= peak && estimate < peak.max(bound / 4) * 6,
            "{name}: {} MB estimated, {} MB taken",
            estimate / MB,
            peak / MB
        );
        assert!(count > 1000, "a search that finds little needs little: {count} features");
        assert!(peak < bound * 9 / 10, "{name}: {} MB of {} MB", peak / MB, bound / MB);
    }
}
