//! Tests of `inspect::texture`.

use burstscope_core::inspect::texture::*;
use burstscope_core::plane::*;
use burstscope_core::synth::random::Stream;

#[test]
fn a_grating_has_its_period_in_its_direction_and_noise_has_none() {
    let mut noise = Stream::new(8, 0);
    for period in [5.0f32, 8.3, 13.0] {
        let plane = Plane::from_fn(160, 120, |u, _| {
            0.3 + 0.05 * (std::f32::consts::TAU * u as f32 / period).sin() + 0.01 * noise.normal() as f32
        });
        let found = period_along(&plane, [80.0, 60.0], [1.0, 0.0], 40).expect("it repeats itself");
        assert!((found.px / period - 1.0).abs() < 0.02 && found.correlation > 0.8, "{period}: {found:?}");
        assert_eq!(period_along(&plane, [80.0, 60.0], [0.0, 1.0], 40), None);
    }
    for _ in 0..20 {
        let plane = Plane::from_fn(160, 120, |_, _| noise.normal() as f32);
        assert_eq!(period_along(&plane, [80.0, 60.0], [1.0, 0.0], 40), None);
    }
    let blob = Plane::from_fn(160, 120, |u, v| (-((u as f32 - 80.0).powi(2) + (v as f32 - 60.0).powi(2)) / 50.0).exp());
    assert_eq!(period_along(&blob, [80.0, 60.0], [1.0, 0.0], 40), None);
    // Outside the plane there is no texture.
    assert_eq!(period_along(&blob, [-90.0, 60.0], [1.0, 0.0], 40), None);
}

#[test]
fn the_kernel_is_one_at_whole_periods_and_small_between() {
    assert!((dirichlet(10, 8.0, 0.0) - 1.0).abs() < 1e-12 && (dirichlet(10, 8.0, 16.0) - 1.0).abs() < 1e-9);
    // The first zero lies p/N from the peak.
    assert!(dirichlet(10, 8.0, 0.8) < 1e-9);
    // The first side lobe of a mean of ten is about 0.22 high.
    let lobe = (81..160).map(|i| dirichlet(10, 8.0, f64::from(i) * 0.01)).fold(0.0, f64::max);
    assert!((lobe - 0.22).abs() < 0.01, "{lobe}");
}
