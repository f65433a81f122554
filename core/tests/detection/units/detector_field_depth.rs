//! Tests of `detector::field::depth`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::field::*;
use burstscope_core::detector::params::*;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use burstscope_core::synth::random::Stream;

/// Places, inverse depths and motions.
type Scene = (Vec<[f64; 2]>, Vec<f64>, Vec<(Slope, f32)>);

/// What a camera shows that moves by (`e`, `e_z`), with `sigma` px/frame of noise.
fn scene(velocity: [f64; 3], sigma: f64, on_a_line: bool) -> Scene {
    let mut random = Stream::new(3, 1);
    let (mut places, mut depths, mut motions) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..400 {
        let place = [random.within(0.0, 640.0), random.within(0.0, 480.0)];
        let depth = random.within(0.2, 1.0);
        let [x, y] = [(place[0] - 320.0) / 500.0, (place[1] - 240.0) / 500.0];
        let mut motion = [velocity[0] - velocity[2] * x, velocity[1] - velocity[2] * y]
            .map(|m| 4.0 * depth * m + sigma * random.normal());
        if on_a_line {
            motion[1] = 0.0;
        }
        let slope = Slope::new(motion[0] as f32, motion[1] as f32);
        let is_known = i % 10 != 0;
        let motion_sigma = if is_known { sigma.max(0.01) as f32 } else { f32::INFINITY };
        places.push(place);
        depths.push(depth);
        motions.push((slope, motion_sigma));
    }
    (places, depths, motions)
}

fn median_error(found: &[Option<InverseDepth>], truth: &[f64]) -> f64 {
    let ratio = |(found, truth): (&Option<InverseDepth>, &f64)| found.map(|depth| depth.value / truth);
    let mut ratios: Vec<f64> = found.iter().zip(truth).filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let middle = ratios[ratios.len() / 2];
    let mut errors: Vec<f64> = ratios.iter().map(|ratio| (ratio / middle - 1.0).abs()).collect();
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}

#[test]
fn inverse_depths_are_proportional_to_the_true_ones_however_the_camera_moves() {
    for (velocity, on_a_line) in
        [([1.0, 0.0, 0.0], true), ([-0.6, 0.8, 0.0], false), ([0.0, 0.0, 1.0], false), ([0.5, -0.2, -0.8], false)]
    {
        let (places, depths, motions) = scene(velocity, 0.03, on_a_line);
        let found = inverse_depths(&places, &motions);
        let known = found.iter().flatten().count();
        assert!(known > 320 && found[0].is_none(), "{velocity:?}: {known}");
        let error = median_error(&found, &depths);
        assert!(error < 0.03, "{velocity:?}: {error}");
    }
}

#[test]
fn what_moves_otherwise_has_none_and_does_not_move_the_focus() {
    let (places, depths, mut motions) = scene([0.3, 0.1, 1.0], 0.03, false);
    for moving in motions.iter_mut().take(60) {
        moving.0 = Slope::new(3.0, -3.0);
    }
    let found = inverse_depths(&places, &motions);
    let left = found[..60].iter().flatten().count();
    assert!(left < 6, "{left} movers have a depth");
    let error = median_error(&found[60..], &depths[60..]);
    assert!(error < 0.03, "{error}");
}

#[test]
fn too_little_tells_nothing() {
    let (places, _, mut motions) = scene([1.0, 0.0, 0.0], 0.03, false);
    assert!(inverse_depths(&[], &[]).is_empty());
    assert!(inverse_depths(&[[3.0, 4.0]; 20], &motions[..20]).iter().all(Option::is_none));
    motions.iter_mut().for_each(|moving| moving.1 = f32::INFINITY);
    assert!(inverse_depths(&places, &motions).iter().all(Option::is_none));
    motions.fill((Slope::new(0.0, 0.0), 0.05));
    assert!(inverse_depths(&places, &motions).iter().flatten().all(|depth| depth.value.is_finite()));
}

