//! Tests of `matching::geometry::consensus`.
#![allow(unused_imports)]

use burstscope_core::matching::*;
use burstscope_core::matching::geometry::*;
use burstscope_core::matching::params::*;
use burstscope_core::monitor::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use std::sync::LazyLock;

#[test]
fn the_number_of_samples_follows_the_inliers() {
    assert_eq!(iterations_needed(10, 10, 4, 0.99), 1);
    assert_eq!(iterations_needed(3, 10, 4, 0.99), usize::MAX);
    // Half inliers of many, four at a time: ln 0.01 / ln(1 − 1/16) = 71.4.
    assert_eq!(iterations_needed(500_000, 1_000_000, 4, 0.99), 72);
    assert!(iterations_needed(30, 100, 7, 0.999) > 30_000);
}

struct Mean(Vec<f64>);

impl Problem for Mean {
    type Model = f64;
    const SAMPLE_SIZE: usize = 1;

    fn count(&self) -> usize {
        self.0.len()
    }

    fn solve(&self, sample: &[usize], models: &mut Vec<f64>) {
        models.push(self.0[sample[0]]);
    }

    fn squared_error(&self, model: &f64, index: usize) -> f64 {
        (self.0[index] - model).powi(2)
    }

    fn refit(&self, _: &f64, weights: &[f64], _: f64) -> Option<f64> {
        let sum: f64 = weights.iter().sum();
        (sum > 0.0).then(|| self.0.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>() / sum)
    }
}

fn found(numbers: Vec<f64>, monitor: &Monitor) -> Result<(Option<f64>, usize), Cancelled> {
    let order = (0..numbers.len()).collect();
    estimate(&Mean(numbers), order, 1.0, &MatchParams { seed: 1, ..MatchParams::default() }, monitor)
}

#[test]
fn outliers_do_not_move_the_mean_too_few_have_none_and_cancelling_ends_it() {
    let numbers = [1.0, 1.2, 0.9, 1.1, 0.8, 40.0, 50.0, 60.0, 70.0, -30.0, -99.0].to_vec();
    let (mean, iterations) = found(numbers, &Monitor::default()).expect("not cancelled");
    assert!((mean.expect("a mean") - 1.0).abs() < 0.01);
    assert_eq!(iterations, MIN_ITERATIONS);
    assert_eq!(found(Vec::new(), &Monitor::default()), Ok((None, 0)));
    assert!(found(vec![1.0], &Monitor::cancelled()).is_err());
}

/// ∫ f over `from..to` by Simpson's rule.
fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let n = 20_000;
    let h = (to - from) / f64::from(n);
    let inner: f64 = (1..n).map(|i| f(from + f64::from(i) * h) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
    (f(from) + f(to) + inner) * h / 3.0
}

#[test]
fn the_gammas_are_integrals_and_the_cost_is_that_of_the_weight_times_the_residual() {
    for x in [0.01, 0.5, 2.0, 6.6] {
        let upper = integral(|t| t.sqrt() * (-t).exp(), x, 60.0);
        assert!((upper_gamma_3_2(x) - upper).abs() < 1e-7, "{x}: {upper}");
        let lower = integral(|t| t * t.sqrt() * (-t).exp(), 0.0, x);
        assert!((lower_gamma_5_2(x) - lower).abs() < 1e-7, "{x}: {lower}");
    }
    // So that reweighted least squares descends on the cost.
    for r in [0.1f64, 0.4, 0.8] {
        let whole = integral(|t| t * raw_weight(t * t), 0.0, 1.0);
        let part = integral(|t| t * raw_weight(t * t), 0.0, r);
        assert!((raw_cost(r * r) / raw_cost(1.0) - part / whole).abs() < 1e-6, "{r}");
    }
}

#[test]
fn it_rises_to_one_at_the_threshold_and_stays() {
    let loss = Loss::new(3.0);
    assert_eq!((loss.cost(0.0), loss.weight(0.0)), (0.0, 1.0));
    let costs: Vec<f64> = (0..=300).map(|i| loss.cost(f64::from(i) * 0.03)).collect();
    assert!(costs.windows(2).all(|w| w[0] <= w[1]));
    assert!((costs[299] - 1.0).abs() < 1e-3);
    for beyond in [9.0, 9.1, 1e300, f64::INFINITY, f64::NAN] {
        assert_eq!((loss.cost(beyond), loss.weight(beyond)), (1.0, 0.0));
    }
    assert!(loss.is_inlier(9.0) && !loss.is_inlier(9.0001) && !loss.is_inlier(f64::NAN));
}

#[test]
fn samples_are_of_different_matches_and_begin_with_the_best() {
    let order: Vec<usize> = (0..50).rev().collect();
    let mut sampler = Sampler::new(order, 7, 3);
    let mut sample = [0; 7];
    let mut seen = [0usize; 50];
    for drawn in 0..30_000 {
        sampler.draw(&mut sample);
        let mut sorted = sample;
        sorted.sort_unstable();
        assert!(sorted.windows(2).all(|w| w[0] < w[1]) && sorted[6] < 50, "{sample:?}");
        if drawn == 0 {
            assert_eq!(sorted, [43, 44, 45, 46, 47, 48, 49], "the seven most promising");
        }
        sample.iter().for_each(|&i| seen[i] += 1);
    }
    assert!(seen.iter().all(|&n| n > 1000) && seen[49] > 2 * seen[0], "{seen:?}");
}

#[test]
fn a_set_of_just_one_sample_works_and_a_seed_fixes_all() {
    let drawn = |count: usize, seed: u64| {
        let mut sample = [0; 4];
        Sampler::new((0..count).collect(), 4, seed).draw(&mut sample);
        sample.sort_unstable();
        sample
    };
    assert_eq!(drawn(4, 0), [0, 1, 2, 3]);
    let below = |seed: u64| {
        let mut sampler = Sampler::new(vec![0; 9], 4, seed);
        [(); 200].map(|()| sampler.below(99))
    };
    assert_eq!(below(5), below(5));
    assert_ne!(below(5), below(6));
}

