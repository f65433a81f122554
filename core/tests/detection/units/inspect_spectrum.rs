//! Tests of `inspect::spectrum`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::*;
use burstscope_core::detector::slopes::*;
use burstscope_core::inspect::*;
use burstscope_core::inspect::shares::*;
use burstscope_core::inspect::spectrum::*;
use burstscope_core::inspect::suspicion::*;
use burstscope_core::inspect::texture::*;
use burstscope_core::monitor::*;
use serde::Serialize;


#[test]
fn the_loss_grows_with_step_and_frames_and_not_with_scale() {
    let step_loss = |step: f32, frames, sigma| response_loss(0.5 * step, &Positions::even(frames), sigma);
    // The step 2σ/(N − 1) loses little.
    let recommended = 2.0 * 1.9 / 9.0;
    let loss = step_loss(recommended, 10, 1.9);
    assert!((0.02..0.08).contains(&loss), "{loss}");
    assert!(step_loss(3.0 * recommended, 10, 1.9) > 5.0 * loss);
    assert!(step_loss(recommended, 20, 1.9) > loss && step_loss(recommended, 10, 4.0) < loss);
    assert_eq!((step_loss(1.0, 1, 2.0), step_loss(0.0, 10, 2.0)), (0.0, 0.0));
    assert!(step_loss(60.0, 20, 1.9) > 0.9);
}

