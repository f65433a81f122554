//! The burst that all benchmarks use.

use burstscope::synth::{SceneParams, synth_scene};
use burstscope::{Burst, Monitor};

/// Ten frames of a layered scene of the paper's size, well lit, so that about 3000 features are found at the thresholds
/// used.
pub fn burst(width: usize, height: usize) -> Burst {
    let params = SceneParams { width, height, snr: 8.0, seed: 7, ..SceneParams::default() };
    synth_scene(&params, &Monitor::default()).expect("valid parameters").0
}
