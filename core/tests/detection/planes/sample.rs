//! Values between pixels, and the noise of parts of a plane.

use crate::prelude::*;
use burstscope_core::plane::{sample::*, statistics::Region};

fn ramp() -> Plane {
    Plane::from_fn(9, 6, |u, v| 2.0 * u as f32 - 0.5 * v as f32 + 1.0)
}

#[test]
fn differences_are_of_the_same_places_and_a_profile_has_every_value_of_a_ramp() {
    let (fine, coarse) = (ramp(), Plane::from_fn(5, 3, |u, v| 4.0 * u as f32 - v as f32 + 1.0));
    assert!(difference(&fine, &fine, 1.0).data().iter().all(|x| *x == 0.0));
    // The coarse plane is the same ramp on every other pixel.
    assert!(difference(&coarse, &fine, 2.0).data().iter().all(|x| x.abs() < 1e-5));
    assert!(difference(&fine, &coarse, 0.5).at(3, 2).abs() < 1e-5);
    let beside = difference(&fine, &Plane::zeros(4, 4), 1.0);
    assert!(beside.at(8, 5).is_nan() && !beside.at(3, 3).is_nan());
    let ramp = Plane::from_fn(20, 10, |u, v| u as f32 + 100.0 * v as f32);
    let samples = profile(&ramp, [2.0, 3.0], [12.0, 3.0], 1.0);
    assert_eq!(samples.len(), 11);
    for (i, s) in samples.iter().enumerate() {
        assert_eq!((s.distance_px, s.u, s.v, s.value), (i as f32, 2.0 + i as f32, 3.0, 302.0 + i as f32));
    }
    // The same place of an image on every other pixel.
    let half = Plane::from_fn(10, 5, |u, v| 2.0 * u as f32 + 200.0 * v as f32);
    let coarse = profile(&half, [2.0, 4.0], [12.0, 4.0], 2.0);
    assert_eq!((coarse.len(), coarse[5].value), (6, 412.0));
    assert!(profile(&ramp, [15.0, 5.0], [30.0, 5.0], 1.0).last().is_some_and(|s| s.value.is_nan()));
    assert!(profile(&ramp, [f32::NAN, 0.0], [1.0, 1.0], 1.0).is_empty());
}

#[test]
fn pixels_are_exact_and_edges_are_held_and_a_patch_at_whole_pixels_is_a_crop() {
    let plane = ramp();
    assert_eq!(bilinear(&plane, 3.0, 2.0), Some(plane.at(3, 2)));
    assert_eq!(bilinear(&plane, -0.5, -0.5), Some(plane.at(0, 0)));
    assert_eq!(bilinear(&plane, 8.5, 5.5), Some(plane.at(8, 5)));
    for (u, v) in [(-0.51, 0.0), (0.0, 5.51), (f32::NAN, 0.0), (f32::INFINITY, 0.0)] {
        assert_eq!(bilinear(&plane, u, v), None);
    }
    assert_eq!(bilinear(&Plane::zeros(0, 3), 0.0, 0.0), None);
    // A NaN beside an exact position does not spread.
    let mut holed = ramp();
    holed.row_mut(2)[4] = f32::NAN;
    assert_eq!(bilinear(&holed, 3.0, 2.0), Some(plane.at(3, 2)));
    assert!(bilinear(&holed, 3.5, 2.0).unwrap().is_nan());
    let plane = ramp();
    let patch = sample_patch(&plane, (4.0, 3.0), 1.5, 0.0, 3);
    for j in 0..3 {
        (0..3).for_each(|i| assert!((patch.at(i, j) - plane.at(3 + i, 2 + j)).abs() < 1e-5));
    }
    assert!(sample_patch(&plane, (0.0, 0.0), 3.0, 0.0, 5).at(0, 0).is_nan());
    // The right of a patch after a quarter turn is the plane's down.
    let turned = sample_patch(&plane, (4.0, 3.0), 1.5, std::f32::consts::FRAC_PI_2, 3);
    assert!((turned.at(2, 1) - plane.at(4, 4)).abs() < 1e-5);
}

proptest! {
    #[test]
    fn a_linear_picture_is_sampled_exactly(u in 0f32..8.0, v in 0f32..5.0) {
        prop_assert!((bilinear(&ramp(), u, v).unwrap() - (2.0 * u - 0.5 * v + 1.0)).abs() < 1e-4);
    }
}

#[test]
fn the_noise_of_a_region_is_that_of_the_noise_and_not_of_what_lies_under_it() {
    let mut random = burstscope_core::synth::random::Stream::new(5, 0);
    let plane = Plane::from_fn(120, 90, |u, v| {
        let step = if u > 60 { 0.5 } else { 0.0 };
        0.003 * u as f32 + 0.002 * v as f32 + step + 0.02 * random.normal() as f32
    });
    let found = region_statistics(&plane, &Region { columns: 10..110, rows: 10..80 }).unwrap();
    assert_eq!(found.count, 100 * 70);
    assert!((found.noise.unwrap() / 0.02 - 1.0).abs() < 0.04, "{found:?}");
    assert!(found.deviation > 0.2 && f64::from(found.min) < found.mean && found.mean < f64::from(found.max));
    let narrow = region_statistics(&plane, &Region { columns: 3..5, rows: 3..9 }).unwrap();
    assert_eq!((narrow.count, narrow.noise), (12, None));
    assert_eq!(region_statistics(&plane, &Region { columns: 500..600, rows: 0..3 }), None);
}
