//! Tests of `detector::view`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::combine::*;
use burstscope_core::detector::field::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::stack::*;
use burstscope_core::detector::view::*;
use burstscope_core::detector::*;
use burstscope_core::detector::{NoiseModelKind, SlopeExtrema, SlopeGrid};
use burstscope_core::error::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use burstscope_core::synth::NoiseCase;
use rayon::prelude::*;
use std::ops::Range;

#[test]
fn a_map_of_the_noise_shows_where_it_is_stronger() {
    let burst = NoiseCase::NoisyHalf.burst((640, 400), 6, 0.02, 7, &Monitor::default()).expect("not cancelled");
    let map = |noise_model| {
        let params =
            DetectorParams { noise_model, slopes: SlopeGrid::line(-1.0..=1.0, 3), ..DetectorParams::default() };
        noise_map(&burst, &params, &Monitor::default()).expect("a map")
    };
    let local = map(NoiseModelKind::Local);
    assert_eq!(local.size(), burst.size());
    for (u, sigma) in [(40, 0.02), (600, 0.06)] {
        assert!((local.at(u, 200) / sigma - 1.0).abs() < 0.2, "{u}: {}", local.at(u, 200));
    }
    let white = map(NoiseModelKind::White);
    assert!(white.data().iter().all(|x| *x == white.data()[0]) && white.at(0, 0) > 0.02);
}
