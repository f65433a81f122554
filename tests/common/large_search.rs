//! A search over many slopes, whose memory is measured. Each program that measures one does it first, in a process of its
//! own: an allocator keeps of a search what the next one may or may not use again.

use burstscope::detector::{DetectorParams, SlopeGrid};
use burstscope::synth::{SceneParams, synth_scene};
use burstscope::{Burst, Monitor};

pub const MB: u64 = 1_000_000;

/// The burst, and the parameters of a search of it over 96 slopes.
pub fn large_search() -> (Burst, DetectorParams) {
    let scene = SceneParams { width: 1600, height: 1200, snr: 8.0, seed: 7, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("valid parameters");
    let slopes = SlopeGrid::plane(-2.0..=2.0, 6, -3.0..=3.0, 16);
    (burst, DetectorParams { slopes, levels: 3, peak_threshold: 0.0015, ..DetectorParams::default() })
}

/// Two threads, on any machine: each has a window of slopes of its own.
pub fn two_threads() -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool")
}
