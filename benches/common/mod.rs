//! The burst that all benchmarks use.

use burstscope::synth::{SceneParams, synth_scene};
use burstscope::{Burst, Monitor, Plane};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Ten frames of a layered scene of the paper's size, well lit, so that about 3000 features are found at the thresholds
/// used.
pub fn burst(width: usize, height: usize) -> Burst {
    let params = SceneParams { width, height, snr: 8.0, seed: 7, ..SceneParams::default() };
    synth_scene(&params, &Monitor::default()).expect("valid parameters").0
}

/// Ten frames of 1600×1200 by day: a picture of `../shared/data` (or of the folder `BURSTSCOPE_SHARED`), repeated in
/// mirrored tiles and moving by `motion` px/frame, with white noise of 0.02. `None` where the folder is not there.
#[allow(dead_code, reason = "not all benchmarks use it")]
pub fn by_day((step_u, step_v): (usize, usize)) -> Option<Burst> {
    let shared = std::env::var("BURSTSCOPE_SHARED").unwrap_or_else(|_| "../shared".to_owned());
    let file = std::fs::read(format!("{shared}/data/light-field-shop/view_13.jpg")).ok()?;
    let picture = image::load_from_memory(&file).expect("a picture").to_luma8();
    let mirrored = |x: usize, n: u32| {
        let x = x as u32 % (2 * n);
        if x < n { x } else { 2 * n - 1 - x }
    };
    let pixel = |u, v| picture.get_pixel(mirrored(u, picture.width()), mirrored(v, picture.height()))[0];
    let mut generator = ChaCha8Rng::seed_from_u64(7);
    // The sum of six uniform values, with a standard deviation of 1.
    let mut normal = || {
        let sum: f32 = (0..6).map(|_| (generator.next_u32() >> 8) as f32 / (1 << 24) as f32).sum();
        (sum - 3.0) * 2f32.sqrt()
    };
    let mut frame = |t: usize| {
        let (du, dv) = ((9 - t) * step_u, (9 - t) * step_v);
        Plane::from_fn(1600, 1200, |u, v| (f32::from(pixel(u + du, v + dv)) / 255.0 + 0.02 * normal()).clamp(0.0, 1.0))
    };
    Some(Burst::from_planes("by day", (0..10).map(&mut frame).collect()))
}
