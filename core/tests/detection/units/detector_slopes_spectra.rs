//! Tests of `detector::slopes::spectra`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::slopes::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use multiversion::multiversion;
use rayon::prelude::*;
use rustfft::num_complex::Complex32;
use rustfft::{Fft, FftPlanner};
use std::ops::Range;
use std::sync::Arc;
use burstscope_core::burst::Positions;
use burstscope_core::synth::random::Stream;

/// Frames of smooth noise that moves by `step` level pixels a frame.
fn moving(step: (f64, f64), count: usize) -> Vec<Plane> {
    let mut noise = Stream::new(3, 0);
    let waves: Vec<[f64; 4]> = (0..40)
        .map(|_| {
            let (u, v) = (noise.within(-0.9, 0.9), noise.within(-0.9, 0.9));
            [u, v, noise.within(0.0, std::f64::consts::TAU), noise.normal()]
        })
        .collect();
    let value = |u: f64, v: f64| waves.iter().map(|w| w[3] * (w[0] * u + w[1] * v + w[2]).cos()).sum::<f64>();
    let at = |t: usize, u: usize, v: usize| value(u as f64 - t as f64 * step.0, v as f64 - t as f64 * step.1);
    (0..count).map(|t| Plane::from_fn(40, 40, |u, v| at(t, u, v) as f32)).collect()
}

#[test]
fn a_correlation_is_the_sum_of_shifted_products() {
    let fourier = Fourier::new();
    let frames = moving((2.0, -1.0), 3);
    let mut scratch = fourier.scratch(3);
    let lags = Lags::of(&Positions::even(3));
    let products = fourier.products(&frames, &lags, (4, 3), &mut scratch);
    let mut pairs = PairSpectra::zeros(&lags);
    fourier.add_pairs(&mut pairs, &lags, &scratch);
    let correlations = fourier.correlations(&products.lags, &mut scratch);
    assert_eq!((products.lags.len(), correlations.len(), pairs.neighbours().len()), (2, 2, 2));
    assert_eq!((lags.near, &pairs.products[2]), (vec![(0, 1), (1, 2), (0, 2)], &products.lags[1]));
    // The band-passed windows themselves, one at a time.
    let band_passed = |frame: &Plane| {
        let mut packed = vec![Complex32::default(); AREA];
        fourier.pack(frame, None, (4, 3), &mut packed);
        let mut turned = packed.clone();
        let mut fft = vec![Complex32::default(); scratch.fft.len()];
        transform(&*fourier.forward, &mut packed, &mut turned, &mut fft);
        let mut spectrum = Spectrum::zeros();
        unpack(&packed, &fourier.band, &mut spectrum, None);
        fourier.correlations(&[spectrum], &mut fourier.scratch(0)).remove(0)
    };
    let planes: Vec<Vec<f32>> = frames.iter().map(band_passed).collect();
    let by_hand = |a: &[f32], b: &[f32], (du, dv): (usize, usize)| -> f32 {
        (0..AREA).map(|i| a[i] * b[(i / SIDE + dv) % SIDE * SIDE + (i % SIDE + du) % SIDE]).sum()
    };
    for shift in [(0, 0), (2, 31), (5, 7), (30, 1)] {
        let index = shift.1 * SIDE + shift.0;
        let lag_1 = by_hand(&planes[0], &planes[1], shift) + by_hand(&planes[1], &planes[2], shift);
        let scale = by_hand(&planes[0], &planes[0], (0, 0));
        assert!((correlations[0][index] - lag_1).abs() < 1e-3 * scale, "{shift:?}");
        let lag_2 = by_hand(&planes[0], &planes[2], shift);
        assert!((correlations[1][index] - lag_2).abs() < 1e-3 * scale, "{shift:?}");
    }
    // It is largest where the scene has moved to.
    let largest = (0..AREA).max_by(|&a, &b| correlations[0][a].total_cmp(&correlations[0][b]));
    assert_eq!(largest, Some((SIDE - 1) * SIDE + 2));
}

#[test]
fn the_variance_is_that_of_frames_with_nothing_in_common() {
    let fourier = Fourier::new();
    let mut noise = Stream::new(9, 0);
    let (mut measured, mut predicted, mut scratch) = (0.0, 0.0, fourier.scratch(4));
    for _ in 0..20 {
        let frames: Vec<Plane> = (0..4).map(|_| Plane::from_fn(32, 32, |_, _| noise.normal() as f32)).collect();
        let products = fourier.products(&frames, &Lags::of(&Positions::even(4)), (0, 0), &mut scratch);
        let correlations = fourier.correlations(&products.lags, &mut scratch);
        measured += correlations[0].iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / AREA as f64;
        predicted += products.variance[0];
    }
    assert!((measured / predicted - 1.0).abs() < 0.1, "{measured} {predicted}");
}

#[test]
fn a_level_holds_the_means_of_its_squares() {
    let frame = Plane::from_fn(43, 38, |u, v| (u * 3 + v * 7 % 5) as f32);
    let levels = pyramids(&[&frame, &frame], 1..3, &Monitor::default()).expect("not cancelled");
    assert_eq!((levels.len(), levels[0].len()), (2, 2));
    for (plane, side) in levels.iter().map(|l| &l[1]).zip([2, 4]) {
        assert_eq!(plane.size(), (43 / side, 38 / side));
        let sum: f32 = (0..side * side).map(|i| frame.at(2 * side + i % side, 3 * side + i / side)).sum();
        assert!((plane.at(2, 3) - sum / (side * side) as f32).abs() < 1e-4);
    }
}

#[test]
fn levels_suit_the_size_and_never_get_too_small() {
    assert_eq!(levels_for((120, 160), 32), 0..2);
    assert_eq!(levels_for((480, 360), 32), 1..4);
    assert_eq!(levels_for((1600, 1200), 32), 2..5);
    assert_eq!(levels_for((4000, 40), 32), 0..1);
    assert!(levels_for((31, 500), 32).is_empty());
}

