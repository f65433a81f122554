//! Tests of `detector::localise`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::feature::*;
use burstscope_core::detector::localise::*;
use burstscope_core::detector::localise::scale::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::stack::*;
use burstscope_core::plane::Plane;
use burstscope_core::synth::chart::draw_disc;

/// A dark blob of standard deviation `sigma` at (x, y).
fn blob(sigma: f64, x: f64, y: f64) -> Plane {
    let s2 = 2.0 * sigma * sigma;
    Plane::from_fn(80, 70, |u, v| {
        (0.3 - 0.2 * (-((u as f64 - x).powi(2) + (v as f64 - y).powi(2)) / s2).exp()) as f32
    })
}





#[test]
fn slopes_are_interpolated_between_neighbours_whatever_interpolation_blurs() {
    for blur in [(0.0, 0.0), (0.25, 0.0), (0.25, 0.25)] {
        let (i, j) = steps_to_peak(blur, (9, 9));
        assert!((i - 0.3).abs() < 2e-3 && (j + 0.2).abs() < 2e-3, "{i} {j} {blur:?}");
    }
    // An axis that ends keeps the slope of the grid.
    let (i, j) = steps_to_peak((0.0, 0.0), (0, 1));
    assert!((i - 0.3).abs() < 2e-3 && j == 0.0, "{i} {j}");
}

