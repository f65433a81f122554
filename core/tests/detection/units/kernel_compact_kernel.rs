//! Tests of `kernel::compact_kernel`.
#![allow(unused_imports)]

use burstscope_core::plane::*;
use multiversion::multiversion;
use proptest::prelude::*;

fn texture() -> Plane {
    Plane::from_fn(60, 50, |u, v| ((u * 31 + v * 17 + u * v) % 29) as f32 / 29.0)
}

fn polynomial(c: &[f32; 4], q: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, &c| sum * q + f64::from(c))
}

fn h(kernel: &CompactKernel, q: f64) -> f64 {
    (1.0 - q).powi(3) * polynomial(&kernel.value, q)
}

/// ∫f dq from 0 to 1.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    (0..20_000).map(|i| f((f64::from(i) + 0.5) / 20_000.0)).sum::<f64>() / 20_000.0
}

fn by_definition(kernel: &CompactKernel, plane: &Plane, radius: f64, (x, y): (f64, f64), local_mean: f32) -> f64 {
    let mut sum = 0.0;
    for v in -30..90i64 {
        for u in -30..90i64 {
            let q = ((u as f64 - x).powi(2) + (v as f64 - y).powi(2)) / (radius * radius);
            if q < 1.0 {
                let pixel = plane.at(u.clamp(0, 59) as usize, v.clamp(0, 49) as usize) - local_mean;
                sum += h(kernel, q) * f64::from(pixel);
            }
        }
    }
    sum
}

proptest! {
    #[test]
    fn the_answer_is_the_sum_and_its_derivatives_are_differences(
        x in -3.0f64..62.0, y in -3.0f64..52.0, radius in 3.5f64..21.0, local_mean in 0.0f32..1.0, soft in any::<bool>(),
    ) {
        let (plane, kernel) = (texture(), if soft { SOFT } else { RIM });
        let answer = PixelView::of(&plane).kernel_response(&kernel, radius, (x, y), local_mean);
        let expected = |dx: f64, dy: f64| by_definition(&kernel, &plane, radius, (x + dx, y + dy), local_mean);
        prop_assert!((answer.value - expected(0.0, 0.0)).abs() < 2e-4 * radius, "{}", answer.value);
        let e = 1e-3;
        let steps = [[(e, 0.0), (-e, 0.0)], [(0.0, e), (0.0, -e)]];
        for (axis, [plus, minus]) in steps.into_iter().enumerate() {
            let difference = (expected(plus.0, plus.1) - expected(minus.0, minus.1)) / (2.0 * e);
            prop_assert!((answer.gradient[axis] - difference).abs() < 1e-3, "{answer:?} {difference}");
            let gradient = |(dx, dy)| PixelView::of(&plane).kernel_response(&kernel, radius, (x + dx, y + dy), local_mean).gradient;
            let second = |of: usize| (gradient(plus)[of] - gradient(minus)[of]) / (2.0 * e);
            prop_assert!((answer.hessian[axis] - second(axis)).abs() < 2e-2, "{answer:?} {}", second(axis));
            prop_assert!((answer.hessian[2] - second(1 - axis)).abs() < 2e-2, "{answer:?} {}", second(1 - axis));
        }
    }
}

#[test]
fn a_part_of_an_image_answers_like_the_whole() {
    let plane = texture();
    let part = Plane::from_fn(30, 30, |u, v| plane.at(u + 12, v + 9));
    let (whole, part) = (PixelView::of(&plane), PixelView { left: 12, top: 9, ..PixelView::of(&part) });
    assert_eq!(whole.local_mean(8.0, (25.3, 22.8)), part.local_mean(8.0, (25.3, 22.8)));
    let response = |pixels: PixelView<'_>| pixels.kernel_response(&RIM, 8.0, (25.3, 22.8), 0.5);
    assert_eq!(response(whole), response(part));
}

#[test]
fn flat_and_sloping_ground_answer_nothing() {
    let ramp = Plane::from_fn(60, 50, |u, v| 0.2 + 0.01 * u as f32 - 0.02 * v as f32);
    for at in [(30.0, 25.0), (30.4, 25.2), (29.5, 24.5)] {
        let disc = |u: usize, v: usize| (u as f64 - at.0).hypot(v as f64 - at.1) < 12.0 * RIM.zero_at;
        let blob = Plane::from_fn(60, 50, |u, v| f32::from(disc(u, v)));
        let blob = PixelView::of(&blob).kernel_response(&RIM, 12.0, at, 0.0);
        let ramp = PixelView::of(&ramp);
        let answer = ramp.kernel_response(&RIM, 12.0, at, ramp.local_mean(12.0, at));
        assert!(answer.value.abs() < 1e-3 * blob.value, "{answer:?} {blob:?}");
        assert!(answer.gradient.iter().all(|g| g.abs() < 2e-3 * blob.value), "{answer:?}");
    }
}

#[test]
fn a_hat_is_what_its_numbers_say() {
    for kernel in [RIM, SOFT] {
        assert!(polynomial(&kernel.value, kernel.zero_at.powi(2)).abs() < 1e-4, "{kernel:?}");
        assert!(integral(|q| h(&kernel, q)).abs() < 1e-6, "its mean is 0: {kernel:?}");
        let first = |q: f64| (1.0 - q).powi(2) * polynomial(&kernel.first, q);
        let noise = (2.0 * std::f64::consts::PI * integral(|q| q * first(q).powi(2))).sqrt();
        assert!((noise / kernel.gradient_noise - 1.0).abs() < 1e-3, "{noise} {kernel:?}");
    }
}

#[test]
fn a_peak_is_as_sharp_as_its_smaller_curvature() {
    let answer = |value: f64, hessian| KernelResponse { value, gradient: [0.0; 2], hessian };
    assert!((answer(2.0, [-3.0, -1.0, 0.0]).sharpness() - 1.0).abs() < 1e-12);
    assert!((answer(-2.0, [2.0, 2.0, 1.0]).sharpness() - 1.0).abs() < 1e-12);
    assert!(answer(2.0, [-3.0, 0.5, 0.0]).sharpness() < 0.0, "a saddle");
}

