//! Tests of `synth::random`.

use burstscope_core::synth::random::*;

fn moments(samples: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = samples.collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64)
}

#[test]
fn the_first_numbers_of_a_seed_are_fixed_for_ever() {
    let mut stream = Stream::new(7, 3);
    let first: Vec<u64> = (0..3).map(|_| (stream.uniform() * (1u64 << 53) as f64) as u64).collect();
    assert_eq!(first, FIRST_OF_SEED_7_STREAM_3);
    assert_ne!(Stream::new(7, 4).uniform(), Stream::new(7, 3).uniform());
}
const FIRST_OF_SEED_7_STREAM_3: [u64; 3] = [1_635_183_741_686_038, 836_447_931_249_957, 8_818_092_840_256_605];

#[test]
fn poisson_has_its_mean_and_variance_on_both_sides_of_the_switch() {
    const COUNT: usize = 200_000;
    for mean in [0.3, 4.0, 23.9, 24.1, 150.0, 20_000.0] {
        let mut stream = Stream::new(11, 0);
        let (m, v) = moments((0..COUNT).map(|_| stream.poisson(mean)));
        // Five standard errors of the mean, and of the variance (fourth central moment of Poisson: λ(1 + 3λ)).
        let n = COUNT as f64;
        assert!((m - mean).abs() < 5.0 * (mean / n).sqrt(), "mean of Poisson({mean}): {m}");
        let error = ((mean * (1.0 + 3.0 * mean) - mean * mean) / n).sqrt();
        assert!((v - mean).abs() < 5.0 * error, "variance of Poisson({mean}): {v}");
    }
    assert_eq!(Stream::new(1, 0).poisson(0.0), 0.0);
}

#[test]
fn normal_has_its_moments_and_tails() {
    const COUNT: usize = 400_000;
    let mut stream = Stream::new(5, 1);
    let values: Vec<f64> = (0..COUNT).map(|_| stream.normal()).collect();
    let (m, v) = moments(values.iter().copied());
    assert!(m.abs() < 5.0 / (COUNT as f64).sqrt(), "{m}");
    assert!((v - 1.0).abs() < 5.0 * (2.0 / COUNT as f64).sqrt(), "{v}");
    // Shares beyond 1, 2, 3 and (in the tail, past the last block) 3.5 standard deviations; five standard errors.
    for (limit, share) in [(1.0, 0.317_311), (2.0, 0.045_500), (3.0, 0.002_700), (3.5, 0.000_465)] {
        let got = values.iter().filter(|x| x.abs() > limit).count() as f64 / COUNT as f64;
        assert!((got - share).abs() < 5.0 * (share / COUNT as f64).sqrt(), "beyond {limit}: {got} for {share}");
    }
}

#[test]
fn lattice_values_are_spread_evenly() {
    let (mean, variance) = moments((0..20_000).map(|k| f64::from(lattice(3, k % 200, k / 200))));
    assert!((mean - 0.5).abs() < 0.01 && (variance - 1.0 / 12.0).abs() < 0.003, "{mean} {variance}");
}
