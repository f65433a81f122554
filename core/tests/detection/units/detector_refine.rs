//! Tests of `detector::refine`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::feature::*;
use burstscope_core::detector::scale_space::*;

/// Tile whose D is a Gaussian bump of the given centre and spread along u, v and level.
fn bump(centre: [f64; 3], spread: [f64; 3], amplitude: f64) -> DogTile {
    let levels = (0..5)
        .map(|s| {
            let mut rows = Tile::default();
            rows.reset(&Region { columns: 0..40, rows: 0..40 }, 40);
            for v in 0..40 {
                for u in 0..40 {
                    let at = [u as f64, v as f64, s as f64];
                    let d2: f64 = (0..3).map(|i| ((at[i] - centre[i]) / spread[i]).powi(2)).sum();
                    rows.row_mut(v)[u] = (amplitude * (-0.5 * d2).exp()) as f32;
                }
            }
            rows
        })
        .collect();
    DogTile { levels }
}

const ROUND: [f64; 3] = [4.0, 4.0, 1.5];


#[test]
fn a_bump_is_found_between_samples_even_from_two_pixels_off() {
    let fit = refined(&bump([20.3, 18.8, 2.2], ROUND, -0.5), (20, 19)).expect("a clean bump");
    let (x, y) = fit.place();
    assert!((x - 20.3).abs() < 0.02 && (y - 18.8).abs() < 0.02 && (fit.level_refined - 2.2).abs() < 0.03);
    assert!((fit.value + 0.5).abs() < 0.01);
    let moved = refined(&bump([22.0, 20.0, 2.0], ROUND, 0.5), (20, 20)).expect("it moves");
    assert_eq!((moved.x, moved.y), (22, 20));
}

#[test]
fn weak_bumps_and_ridges_are_rejected_by_name() {
    for (spread, amplitude, test) in [
        (ROUND, 0.15, Test::InterpolatedContrast),
        (ROUND, 0.05, Test::NoiseGate),
        ([2.0, 30.0, 1.0], 1.0, Test::Edge),
    ] {
        assert_eq!(refined(&bump([20.0, 20.0, 2.0], spread, amplitude), (20, 20)), Err(test));
    }
}


