//! Tests of `plane::blur`.

use burstscope_core::monitor::*;
use burstscope_core::plane::blur::*;
use burstscope_core::plane::*;

#[test]
fn kernels_sum_to_one_and_reach_four_sigma() {
    for sigma in [0.3, 1.0, 1.6, 3.09] {
        let kernel = GaussianKernel::new(sigma);
        let sum = kernel.half()[0] + 2.0 * kernel.half()[1..].iter().sum::<f32>();
        assert!((sum - 1.0).abs() < 1e-6);
        assert_eq!(kernel.radius(), (4.0 * sigma).ceil() as usize);
    }
    assert_eq!(GaussianKernel::new(0.0).half(), &[1.0]);
}

#[test]
fn smoothing_for_looking_at_is_the_blur_and_leaves_out_nan() {
    let noise = |u: usize, v: usize| ((u * 7919 + v * 104_729) % 1000) as f32 / 1000.0;
    let plane = Plane::from_fn(53, 31, noise);
    let monitor = Monitor::default();
    let smoothed = |plane: &Plane, sigma| smoothed(plane, sigma, &monitor).expect("nobody cancels");
    let (fast, plain) = (smoothed(&plane, 1.7), gaussian_blur(&plane, &GaussianKernel::with_cut(1.7, 3.0)));
    assert!(fast.data().iter().zip(plain.data()).all(|(a, b)| (a - b).abs() < 1e-6));
    assert_eq!(smoothed(&plane, 0.0), plane);
    let hole = |u: usize, v: usize| if (20..24).contains(&u) && v == 10 { f32::NAN } else { 0.25 };
    let flat = smoothed(&Plane::from_fn(53, 31, hole), 2.0);
    for v in 0..31 {
        for u in 0..53 {
            let x = flat.at(u, v);
            assert!(if hole(u, v).is_nan() { x.is_nan() } else { (x - 0.25).abs() < 1e-6 }, "({u}, {v}): {x}");
        }
    }
    monitor.cancel();
    assert_eq!(burstscope_core::plane::blur::smoothed(&plane, 1.7, &monitor), Err(Cancelled));
}
