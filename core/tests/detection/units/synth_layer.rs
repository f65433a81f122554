//! Tests of `synth::layer`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use burstscope_core::synth::*;
use burstscope_core::synth::paint::*;
use burstscope_core::synth::truth::*;

fn centroid(plane: &Plane) -> (f64, f64, f64) {
    let (mut mass, mut mu, mut mv) = (0.0, 0.0, 0.0);
    for v in 0..plane.height() {
        for (u, &x) in plane.row(v).iter().enumerate() {
            let x = f64::from(x);
            mass += x;
            mu += x * u as f64;
            mv += x * v as f64;
        }
    }
    (mu / mass, mv / mass, mass)
}

#[test]
fn a_layer_moves_by_its_slope() {
    let mut layer = Layer::new("dot", (64, 48), (1.37, -0.61), 4.5);
    layer.landmark(31.2, 24.7, 5.0, 1.0, true);
    let still = draw_layers(std::slice::from_ref(&layer), (64, 48), 0.0, &Monitor::default()).expect("done");
    let (u0, v0, mass) = centroid(&still);
    assert!((mass - std::f64::consts::PI * 25.0).abs() < 0.3, "{mass}");
    assert!((u0 - 31.2).abs() < 0.01 && (v0 - 24.7).abs() < 0.01, "{u0} {v0}");
    for k in 0..10 {
        let dt = f64::from(k) - 4.5;
        let moved = draw_layers(std::slice::from_ref(&layer), (64, 48), dt, &Monitor::default()).expect("done");
        let (u, v, m) = centroid(&moved);
        assert!((u - u0 - dt * 1.37).abs() < 0.005, "{u}");
        assert!((v - v0 + dt * 0.61).abs() < 0.005, "{v}");
        assert!((m / mass - 1.0).abs() < 1e-3);
    }
}

#[test]
fn a_layer_that_fills_the_frame_keeps_filling_it() {
    let mut layer = Layer::new("wall", (40, 30), (3.0, -2.5), 4.5);
    layer.sheet.fill(|_, _| 0.25);
    for k in 0..10 {
        let picture = draw_layers(std::slice::from_ref(&layer), (40, 30), f64::from(k) - 4.5, &Monitor::default());
        assert!(picture.expect("done").data().iter().all(|x| (x - 0.25).abs() < 1e-6));
    }
}

#[test]
fn near_layers_hide_far_ones_and_their_landmarks() {
    let mut far = Layer::new("far", (60, 40), (0.0, 0.0), 2.0);
    far.sheet.fill(|_, _| 0.1);
    far.landmark(15.0, 20.0, 4.0, 0.9, true);
    far.landmark(45.0, 20.0, 4.0, 0.9, true);
    let mut near = Layer::new("near", (60, 40), (2.0, 0.0), 2.0);
    near.sheet.disc(34.0, 20.0, 4.0, 0.0);
    let layers = [far, near];
    let picture = draw_layers(&layers, (60, 40), 0.0, &Monitor::default()).expect("done");
    assert!(picture.at(34, 20) < 1e-6 && (picture.at(5, 5) - 0.1).abs() < 1e-6);
    let seen = visible_landmarks(&layers, (60, 40), &even_within(2.0));
    assert_eq!(seen.len(), 1, "the near disc moves over the right landmark");
    assert_eq!(seen[0].u, 15.0);
}

