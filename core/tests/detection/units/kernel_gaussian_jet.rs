//! Tests of `kernel::gaussian_jet`.
#![allow(unused_imports)]

use multiversion::multiversion;
use burstscope_core::plane::Plane;
use proptest::prelude::*;

fn by_definition(plane: &Plane, mean: f32, (x, y): (f64, f64), variance: f64) -> f64 {
    let weight = |d: f64| (-0.5 * d * d / variance).exp() / (2.0 * std::f64::consts::PI * variance).sqrt();
    let (width, height) = plane.size();
    let mut sum = 0.0;
    for v in -30..height as i64 + 30 {
        for u in -30..width as i64 + 30 {
            let pixel = plane.at(u.clamp(0, width as i64 - 1) as usize, v.clamp(0, height as i64 - 1) as usize);
            sum += f64::from(pixel - mean) * weight(u as f64 - x) * weight(v as f64 - y);
        }
    }
    sum
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    #[test]
    fn a_jet_is_the_sum_and_its_derivatives(
        x in 2.0f64..38.0, y in 2.0f64..28.0, variance in 1.0f64..9.0, ratio in 1.1f64..2.0, mean in 0.0f32..1.0,
    ) {
        let plane = Plane::from_fn(40, 30, |u, v| ((u * 31 + v * 17 + u * v) % 29) as f32 / 29.0);
        let mut pixels = JetPixels::default();
        pixels.read(&PixelView::of(&plane), (x.round() as i64, y.round() as i64), 24, mean);
        let variances = [variance, ratio * variance];
        let jets = pixels.jets((x, y), variances);
        for (jet, variance) in jets.into_iter().zip(variances) {
            let at = |dx: f64, dy: f64| by_definition(&plane, mean, (x + dx, y + dy), variance);
            prop_assert!((jet[0][0] - at(0.0, 0.0)).abs() < 1e-4, "{} {}", jet[0][0], at(0.0, 0.0));
            let e = 1e-3;
            prop_assert!((jet[1][0] - (at(e, 0.0) - at(-e, 0.0)) / (2.0 * e)).abs() < 1e-4);
            prop_assert!((jet[0][1] - (at(0.0, e) - at(0.0, -e)) / (2.0 * e)).abs() < 1e-4);
            let e = 0.05;
            let second = |f: &dyn Fn(f64) -> f64| (f(e) - 2.0 * f(0.0) + f(-e)) / (e * e);
            prop_assert!((jet[2][0] - second(&|d| at(d, 0.0))).abs() < 2e-3);
            prop_assert!((jet[0][2] - second(&|d| at(0.0, d))).abs() < 2e-3);
            prop_assert!((jet[2][2] - second(&|d| second(&|f| at(d, f)))).abs() < 5e-3);
            let fourth = (at(0.4, 0.0) - 4.0 * at(0.2, 0.0) + 6.0 * at(0.0, 0.0) - 4.0 * at(-0.2, 0.0) + at(-0.4, 0.0)) / 0.2f64.powi(4);
            prop_assert!((jet[4][0] - fourth).abs() < 0.03 * (1.0 + fourth.abs()), "{} {fourth}", jet[4][0]);
        }
    }
}

#[test]
fn narrow_jets_of_smooth_pixels_are_those_of_the_scene() {
    // A blob of variance s² that is blurred by a Gaussian is one of the sum of their variances.
    let own = 1.7f64 * 1.7;
    for (x, y) in [(20.0, 15.0), (20.5, 15.5), (20.3, 14.6)] {
        let plane = Plane::from_fn(40, 30, |u, v| {
            (-((u as f64 - x).powi(2) + (v as f64 - y).powi(2)) / (2.0 * own)).exp() as f32
        });
        let mut pixels = JetPixels::default();
        pixels.read(&PixelView::of(&plane), (20, 15), 9, 0.0);
        for variance in [0.3, 0.5, 0.8, 1.1, 1.3] {
            let [jet, _] = pixels.jets((x, y), [variance, 2.0]);
            let all = own + variance;
            let peak = own / all;
            for ((p, q), expected, error) in [
                ((0, 0), peak, 1e-3),
                ((1, 0), 0.0, 2e-3),
                ((2, 0), -peak / all, 5e-3),
                ((0, 2), -peak / all, 5e-3),
                ((2, 2), peak / (all * all), 2e-2),
                ((4, 0), 3.0 * peak / (all * all), 3e-2),
            ] {
                let found = jet[p][q];
                assert!((found - expected).abs() < error, "{p} {q} of {variance} at {x} {y}: {found} {expected}");
            }
        }
    }
}

