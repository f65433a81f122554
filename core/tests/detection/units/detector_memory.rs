//! Tests of `detector::memory`.
#![allow(unused_imports)]

use burstscope_core::detector::localise::*;
use burstscope_core::detector::memory::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::*;
use burstscope_core::detector::{Rules, SlopeExtrema, SlopeGrid};
use burstscope_core::error::*;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

const SIZE: (usize, usize) = (1600, 1200);

fn plane(side: usize) -> DetectorParams {
    let slopes = SlopeGrid::plane(-3.0..=3.0, side, -3.0..=3.0, side);
    DetectorParams { slopes, ..DetectorParams::default() }
}

#[test]
fn the_estimate_grows_with_slopes_and_the_first_octave() {
    let plane = plane(64);
    let fine = DetectorParams { first_octave: -1, ..plane.clone() };
    let of = |params: &DetectorParams| estimate(params, 10, SIZE) as f64 / 1e9;
    assert!((8.0..13.0).contains(&of(&plane)) && (32.0..45.0).contains(&of(&fine)));
    assert!(of(&DetectorParams::default()) < 0.5);
    assert!(estimate(&plane, usize::MAX >> 8, (1 << 30, 1 << 30)) > 1 << 60, "huge, and no overflow");
}
