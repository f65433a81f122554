//! Tests of `detector::noise_model::variance`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::plane::*;
use burstscope_core::plane::blur::*;
use serde::{Serialize, Serializer};
use burstscope_core::monitor::Monitor;
use burstscope_core::synth::random::Stream;
use burstscope_core::synth::{Camera, NoiseCase};

fn camera(full_scale_electrons: f64, read_noise_electrons: f64, black_level: f64) -> Camera {
    Camera { full_scale_electrons, read_noise_electrons, black_level, bits: Some(14) }
}

fn squares(camera: &Camera, signal: &Plane) -> Vec<(f32, f32)> {
    let frames: Vec<Plane> = (1..=3)
        .map(|t| camera.capture(signal, &mut Stream::new(9, t), &Monitor::default()).expect("not cancelled"))
        .collect();
    let squares = HighPass::new(&frames.iter().collect::<Vec<_>>());
    let variances = squares.variances(&[(0, 1.0), (1, -2.0), (2, 1.0)]);
    squares.brightness[1].iter().copied().zip(variances).collect()
}

#[test]
fn sensors_of_known_slope_and_offset_are_found() {
    for (electrons, read_noise) in [(500.0, 4.0), (2000.0, 20.0), (15_000.0, 3.0)] {
        let camera = camera(electrons, read_noise, 0.0625);
        let signal = Plane::from_fn(640, 400, |u, _| 0.8 * (u as f32 / 640.0).powi(2));
        let fit = PhotonTransfer::fit(&squares(&camera, &signal), 256, FREE_VALUES);
        let a = 1.0 / electrons;
        let b = (read_noise * read_noise / electrons - camera.black_level) / electrons;
        assert!((f64::from(fit.slope) / a - 1.0).abs() < 0.08, "{electrons}: {fit:?}");
        for signal in [0.02, 0.2, 0.7] {
            let brightness = signal + camera.black_level;
            let expected = a * brightness + b;
            let got = f64::from(fit.variance(brightness as f32));
            assert!((got / expected - 1.0).abs() < 0.12, "{electrons} {signal}: {got} {expected}");
        }
    }
}

#[test]
fn noise_that_knows_no_brightness_has_no_slope() {
    let mut stream = Stream::new(1, 0);
    let frame = Plane::from_fn(640, 400, |u, _| u as f32 / 640.0 + 0.01 * stream.normal() as f32);
    let squares = HighPass::new(&[&frame]);
    let pairs: Vec<(f32, f32)> =
        squares.brightness[0].iter().copied().zip(squares.variances(&[(0, 1.0)])).collect();
    let fit = PhotonTransfer::fit(&pairs, 256, FREE_VALUES);
    assert_eq!(fit.slope, 0.0);
    assert!((fit.dark / 1e-4 - 1.0).abs() < 0.05, "{fit:?}");
}

#[test]
fn clipped_black_and_texture_bend_nothing() {
    // The darkest tenth is so dark that half of its noise is cut off, a seventh of all squares has texture.
    let camera = camera(1000.0, 20.0, 0.0);
    let signal = Plane::from_fn(640, 400, |u, _| (0.6 * (u as f32 - 64.0) / 576.0).max(0.0));
    let mut pairs = squares(&camera, &signal);
    pairs.iter_mut().step_by(7).for_each(|p| p.1 *= 8.0);
    let fit = PhotonTransfer::fit(&pairs, 256, FREE_VALUES);
    assert!((fit.slope / 1e-3 - 1.0).abs() < 0.3, "{fit:?}");
    assert!((fit.variance(0.3) / (0.3e-3 + 0.4e-3) - 1.0).abs() < 0.12, "{fit:?}");
}

#[test]
fn no_noise_and_no_squares_have_an_answer() {
    assert_eq!(PhotonTransfer::fit(&[], 256, 17.0), PhotonTransfer::default());
    let still = PhotonTransfer::fit(&[(0.5, 0.0); 60], 256, 17.0);
    assert_eq!((still.slope, still.dark), (0.0, 0.0));
}

const SIZE: (usize, usize) = (480, 360);



#[test]
fn the_same_noise_everywhere_needs_no_map() {
    for case in [NoiseCase::White, NoiseCase::Correlated, NoiseCase::ClippedBlack] {
        assert_eq!(map(&squares_in_place(case)), None, "{case:?}");
    }
}

#[test]
fn a_noisier_half_is_found_with_its_border() {
    let map = map(&squares_in_place(NoiseCase::NoisyHalf)).expect("the halves differ");
    let at = |u: f32, v: f32| map.at(Some(0), u, v);
    let (left, right) = (at(60.0, 180.0), at(420.0, 180.0));
    assert!((right / left / 9.0 - 1.0).abs() < 0.25, "{left} {right}");
    assert!(at(236.0, 100.0) > 0.4 * right, "{} {right}", at(236.0, 100.0));
    let (min, max) = map.range();
    assert!(min <= left && right <= max);
}

#[test]
fn noise_that_varies_smoothly_is_followed() {
    // Steep slopes of the noise are taken for borders, which raises the quiet places between them.
    for (times, min_ratio) in [(2u8, 0.75), (6, 0.45)] {
        let map = map(&squares_in_place(NoiseCase::Varying(times))).expect("it varies");
        // Most and least noise, and half-way.
        let at = |octave: i32, u: f32, v: f32| map.at(Some(octave), u, v).sqrt();
        let (most, least, middle) = (at(0, 62.5, 62.5), at(0, 187.5, 62.5), at(0, 125.0, 125.0));
        let ratio = most / least / f32::from(times);
        assert!((min_ratio..1.35).contains(&ratio), "{times}: {most} {least} {middle}");
        assert!(middle < most && middle > least, "{times}: {most} {least} {middle}");
        assert!(at(5, 62.5, 62.5) < 0.95 * most, "coarse octaves see a mean");
    }
}

#[test]
fn texture_is_no_noise() {
    let mut squares_in_place = squares_in_place(NoiseCase::White);
    // Texture of various strengths in a corner.
    let in_corner = squares_in_place.iter_mut().filter(|s| s.place.0 < 150.0 && s.place.1 < 150.0);
    in_corner.enumerate().for_each(|(i, s)| s.variance *= 1.0 + (i % 7) as f32);
    assert_eq!(map(&squares_in_place), None);
}

