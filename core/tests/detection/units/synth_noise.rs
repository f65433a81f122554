//! Tests of `synth::noise`.

use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use burstscope_core::synth::noise::*;
use burstscope_core::synth::random::*;

fn expose(camera: &Camera, signal: &Plane, seed: u64) -> Plane {
    camera.capture(signal, &mut Stream::new(seed, 1), &Monitor::default()).expect("not cancelled")
}

fn statistics(plane: &Plane) -> (f64, f64) {
    let n = plane.data().len() as f64;
    let mean = plane.data().iter().map(|&x| f64::from(x)).sum::<f64>() / n;
    (mean, plane.data().iter().map(|&x| (f64::from(x) - mean).powi(2)).sum::<f64>() / n)
}

#[test]
fn mean_and_variance_follow_the_model() {
    const SIDE: usize = 500;
    for (electrons, signal, bits) in [(60.0, 0.05, 12), (300.0, 0.2, 8), (15_000.0, 0.3, 12), (40.0, 0.1, 10)] {
        let (full_scale_electrons, bits) = (electrons, Some(bits));
        let camera = Camera { full_scale_electrons, read_noise_electrons: 3.0, black_level: 0.45, bits };
        let frame = expose(&camera, &Plane::from_fn(SIDE, SIDE, |_, _| signal as f32), 2);
        let (mean, variance) = statistics(&frame);
        let n = (SIDE * SIDE) as f64;
        let sigma = camera.sigma(signal);
        assert!((mean - 0.45 - signal).abs() < 5.0 * sigma / n.sqrt(), "{electrons}: mean {mean}");
        // The variance of a variance is 2σ⁴/n for Gaussian noise; Poisson's tails make it a little larger.
        let error = (2.2 / n).sqrt() * sigma * sigma;
        assert!((variance - sigma * sigma).abs() < 5.0 * error, "{electrons}: {variance} for {}", sigma * sigma);
    }
}

#[test]
fn the_snr_asked_for_is_the_snr_of_the_model() {
    for snr in [0.05, 0.2, 0.35, 1.0, 5.0, 20.0] {
        for read_noise in [0.0, 3.0] {
            let camera = Camera::for_snr(snr, 0.1, 0.12, read_noise, 0.02, 12).expect("within reach");
            let got = 0.02 / camera.sigma(0.11);
            assert!((got - snr).abs() < 1e-9 * snr, "{snr}: {got}");
        }
    }
    assert!(Camera::for_snr(f64::INFINITY, 0.1, 0.12, 3.0, 0.0, 12).expect("noiseless").is_noiseless());
    for bad in [0.0, -1.0, f64::NAN, 1e9] {
        let error = Camera::for_snr(bad, 0.1, 0.12, 3.0, 0.0, 12).expect_err("nonsense").to_string();
        assert!(error.starts_with("snr: "), "{error}");
    }
}

#[test]
fn rounding_keeps_to_the_levels_of_the_converter() {
    assert_eq!(quantised_word(0.0, 12), 0);
    assert_eq!(quantised_word(-1.0, 12), 0);
    assert_eq!(quantised_word(2.0, 12), 65520);
    assert_eq!(quantised_word(1.0, 16), 65535);
    assert_eq!(quantised_word(quantisation_step(12) * 7.4, 12), 7 * 16);
    let words: Vec<u16> = (0..4096u16).map(|d| quantised_word(f64::from(d * 16) / 65535.0, 12)).collect();
    assert!(words.iter().enumerate().all(|(d, &w)| usize::from(w) == d * 16));
}
