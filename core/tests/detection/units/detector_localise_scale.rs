//! Tests of `detector::localise::scale`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::localise::*;
use burstscope_core::detector::localise::scale::*;
use multiversion::multiversion;
use burstscope_core::plane::Plane;
use burstscope_core::synth::chart::draw_disc;

#[test]
fn a_gaussian_blob_has_its_own_scale() {
    // The blob's own σ is b less the pixels': D is largest at σ = b/√k.
    for (b, levels) in [(3.0f64, 3), (4.4, 4), (3.6, 1)] {
        let plane = Plane::from_fn(120, 110, |u, v| {
            (0.3 - 0.2 * (-((u as f64 - 60.3).powi(2) + (v as f64 - 54.8).powi(2)) / (2.0 * b * b)).exp()) as f32
        });
        let k = 2f64.powf(1.0 / levels as f64);
        for from in [0.0, 0.5, 1.6] {
            let expected = (b * b - from * from).sqrt() / k.sqrt();
            for start in [0.96, 1.0, 1.05] {
                let found = scale_peak(&PixelView::of(&plane), (60.3, 54.8), start * expected, levels, from);
                if expected.powi(2) > from * from + MIN_VARIANCE * 1.3 {
                    let found = found.expect("a blob");
                    assert!((found / expected - 1.0).abs() < 1e-3, "{b} {levels} {from}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn a_disc_has_the_expected_scale() {
    for radius in [3.6, 5.0, 8.3] {
        let mut plane = Plane::from_fn(140, 130, |_, _| 0.1);
        draw_disc(&mut plane, 70.4, 64.7, radius, 0.12);
        let expected = radius / rim_radius(1.0, 4);
        let found = scale_peak(&PixelView::of(&plane), (70.4, 64.7), 1.04 * expected, 4, 0.5).expect("a disc");
        assert!((found / expected - 1.0).abs() < 2e-3, "{radius}: {found} {expected}");
    }
}

#[test]
fn where_there_is_no_blob_there_is_no_scale() {
    let ramp = Plane::from_fn(80, 70, |u, v| (u + 2 * v) as f32 * 0.003);
    let edge = Plane::from_fn(80, 70, |u, _| f32::from(u > 40));
    for plane in [ramp, edge] {
        assert_eq!(scale_peak(&PixelView::of(&plane), (40.5, 35.0), 3.0, 3, 0.5), None);
    }
}

