//! Tests of `detector::noise`.
#![allow(unused_imports)]

use burstscope_core::burst::Positions;
use burstscope_core::burst::*;
use burstscope_core::detector::noise::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::params::{CoarseStart, Interpolation, Slope, SlopeGrid};
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::stack::frame_offsets;
use burstscope_core::detector::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use burstscope_core::synth::random::Stream;
use multiversion::multiversion;
use rayon::prelude::*;
use std::ops::Range;

fn noisy_burst(sigma: f32, n: usize, scene: impl Fn(usize, usize) -> f32, round_to: f32) -> Burst {
    let mut noise = Stream::new(7, 0);
    let frames = (0..n)
        .map(|_| {
            Plane::from_fn(300, 200, |u, v| {
                let value = scene(u, v) + sigma * noise.normal() as f32;
                if round_to > 0.0 { (value / round_to).round() * round_to } else { value }
            })
        })
        .collect();
    let mut burst = Burst::from_planes("noise", frames);
    burst.quantisation_step = round_to;
    burst
}

fn estimate(burst: &Burst) -> f32 {
    frame_noise(burst, 0..burst.len(), &Monitor::default()).expect("not cancelled")
}

#[test]
fn the_estimate_is_within_three_percent_on_noise_with_edges() {
    for sigma in [0.002f32, 0.01, 0.1] {
        let burst = noisy_burst(sigma, 4, |u, v| if (u / 40 + v / 50) % 2 == 0 { 0.2 } else { 0.6 }, 0.0);
        assert!((estimate(&burst) / sigma - 1.0).abs() < 0.03, "{sigma}: {}", estimate(&burst));
    }
}

#[test]
fn coarse_numbers_do_not_spoil_the_estimate() {
    // 8-bit frames whose noise is none, half, one and two grey values; rounding adds a twelfth of a step².
    for grey_values in [0.0, 0.5f32, 1.0, 2.0] {
        let step = 1.0 / 255.0;
        let burst = noisy_burst(grey_values * step, 3, |u, _| 0.3 + u as f32 * 1e-4, step);
        let expected = (grey_values * grey_values + 1.0 / 12.0).sqrt() * step;
        assert!((estimate(&burst) / expected - 1.0).abs() < 0.05, "{grey_values}: {}", estimate(&burst));
    }
}

#[test]
fn black_parts_where_the_noise_is_cut_off_do_not_count() {
    // Two thirds of the image are so dark that nearly all of their noise is cut off at zero.
    let (sigma, step) = (3.0 / 255.0, 1.0 / 255.0);
    let mut burst = noisy_burst(sigma, 3, |u, _| if u < 200 { -0.03 } else { 0.4 }, step);
    for frame in &mut burst.frames {
        let cut = Plane::from_vec(300, 200, frame.data().iter().map(|x| x.max(0.0)).collect());
        *frame = std::sync::Arc::new(cut);
    }
    assert!((estimate(&burst) / sigma - 1.0).abs() < 0.06, "{}", estimate(&burst) / sigma);
}

#[test]
fn tiny_images_and_single_frames_have_an_answer() {
    let flat = |n: usize, size: usize| {
        estimate(&Burst::from_planes("flat", (0..n).map(|_| Plane::from_fn(size, size, |_, _| 0.3)).collect()))
    };
    assert_eq!((flat(3, 2), flat(1, 3), flat(2, 9)), (0.0, 0.0, 0.0));
}

#[test]
fn larger_searches_have_higher_gates() {
    let line = SlopeGrid::line(-3.0..=3.0, 7);
    let gate = |slopes, noise_gate| gate_factor(&DetectorParams { slopes, noise_gate, ..DetectorParams::default() });
    let one = gate(line, NoiseGate::Auto);
    assert!(gate(SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), NoiseGate::Auto) > one + 0.2);
    // A tenth of the false alarms is about ln 10 / k more.
    assert!((gate(line, NoiseGate::Strict) - one - 10f32.ln() / one).abs() < 0.1);
    assert!((0.8..1.1).contains(&(one - gate(line, NoiseGate::Matching))));
    assert_eq!(gate(line, NoiseGate::Factor(4.5)), 4.5);
}
