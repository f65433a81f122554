//! Robust estimation: the model that most of the matches agree on, despite outliers.
//!
//! RANSAC (Fischler and Bolles, 1981) with a smooth cost instead of a count, each best model so far improved at once by
//! reweighted least squares over all its inliers (local optimisation: Chum, Matas and Kittler, "Locally Optimized
//! RANSAC", 2003), early ends of scoring and sampling, and repair of degenerate models ([`Problem::repair`]).
//!
//! Samples. PROSAC (Chum and Matas, "Matching with PROSAC", CVPR 2005) draws from the best few matches at first and
//! from all alike after [`UNIFORM_AFTER`] samples: nothing is lost where the order by quality is of no use.
//!
//! Cost. MAGSAC++ (Barath, Noskova, Ivashechkin and Matas, "MAGSAC++, a Fast, Reliable and Accurate Robust Estimator",
//! CVPR 2020) takes the noise's scale σ as uniformly distributed between 0 and σ_max and integrates it out. Residuals
//! follow a χ distribution of four degrees of freedom, for which the paper's incomplete gamma functions are elementary:
//! with x = r²/(2σ²_max), Γ(3/2, x) = ½√π·erfc(√x) + √x·e⁻ˣ and γ(5/2, x) = ¾√π·erf(√x) − (x^½·3/2 + x^3/2)·e⁻ˣ.
//!
//! A model that an earlier search found is improved first, and only a sample that is better than it was counts.
//!
//! The order is fixed, on one thread, and the random numbers are ChaCha's: the same input and seed give the same bits.

use crate::matching::params::MatchParams;
use crate::monitor::{Cancelled, Monitor};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use std::sync::LazyLock;

pub(super) trait Problem {
    type Model: Clone;

    /// Number of matches that determine a model, up to a few solutions.
    const SAMPLE_SIZE: usize;

    /// Appends the models that fit the sample exactly; none for a degenerate sample.
    fn solve(&self, sample: &[usize], models: &mut Vec<Self::Model>);

    /// Squared error of each match under a model; infinite where it is undefined.
    fn squared_errors(&self, model: &Self::Model) -> impl Iterator<Item = f64>;

    /// Whether a step of [`Self::refit`] may be too long and is shortened by damping.
    const IS_DAMPED: bool = false;

    /// The model near `model` of the least weighted squared errors, or one closer to it; `None` where the weights leave
    /// it undetermined. `damping`, above 0, shortens the steps of damped problems.
    fn refit(&self, model: &Self::Model, weights: &[f64], damping: f64) -> Option<Self::Model>;

    /// A model that may be better than `model`, which may explain only a degenerate part of the scene, such as a plane.
    fn repair(&self, _model: &Self::Model, _loss: &Loss, _sampler: &mut Sampler) -> Option<Self::Model> {
        None
    }
}

/// Minimum number of samples where no model is known: one found by luck should not end the search at once.
const MIN_ITERATIONS: usize = 50;
/// Maximum number of steps of a local optimisation; most end after three to five.
const POLISH_STEPS: usize = 50;
const POLISH_TOLERANCE: f64 = 1e-3;
/// Damping: of the first step, its factors after a success and a failure, and its largest value.
const DAMPING: (f64, f64, f64, f64) = (1e-6, 0.1, 100.0, 100.0);

/// The model of least cost for inliers with errors up to `max_error`, and the number of samples; `order`: best first.
/// `known` is the model of an earlier search of which these matches are the inliers: less is left to find.
pub(super) fn estimate<P: Problem>(
    problem: &P,
    order: Vec<usize>,
    known: Option<P::Model>,
    max_error: f64,
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<(Option<P::Model>, usize), Cancelled> {
    monitor.check()?;
    let count = order.len();
    if count < P::SAMPLE_SIZE {
        return Ok((None, 0));
    }
    let loss = Loss::new(max_error);
    let mut sampler = Sampler::new(order, P::SAMPLE_SIZE, params.seed);
    let (mut sample, mut models) = (vec![0; P::SAMPLE_SIZE], Vec::new());
    let least = if known.is_some() { 1 } else { MIN_ITERATIONS };
    // The more inliers, the fewer samples until one of inliers alone is as good as certain.
    let samples = |model: &P::Model| {
        let inliers = problem.squared_errors(model).filter(|error| loss.is_inlier(*error)).count();
        let needed = iterations_needed(inliers, count, P::SAMPLE_SIZE, f64::from(params.confidence));
        needed.max(least).min(params.max_iterations)
    };
    let mut min_raw = known.as_ref().map_or(f64::INFINITY, |model| cost(problem, model, &loss));
    let mut best = known.map(|model| polish(problem, model, min_raw, &loss));
    let (mut iterations, mut needed) = (0, best.as_ref().map_or(params.max_iterations, |best| samples(&best.0)));
    while iterations < needed {
        if iterations % 64 == 0 {
            monitor.check()?;
        }
        iterations += 1;
        sampler.draw(&mut sample);
        models.clear();
        problem.solve(&sample, &mut models);
        for model in &models {
            // Compared with other exact models of samples, not with optimised ones: it may lead to a better optimum.
            let Some(raw) = cost_below(problem, model, &loss, min_raw) else { continue };
            min_raw = raw;
            let candidate = polish(problem, model.clone(), raw, &loss);
            if best.as_ref().is_none_or(|(_, cost)| candidate.1 < *cost) {
                (needed, best) = (samples(&candidate.0), Some(candidate));
            }
        }
    }
    monitor.check()?;
    let best = best.map(|best| finished(problem, best, max_error, &loss, &mut sampler));
    Ok((best.map(|(model, _)| model), iterations))
}

fn finished<P: Problem>(
    problem: &P,
    mut best: (P::Model, f64),
    max_error: f64,
    loss: &Loss,
    sampler: &mut Sampler,
) -> (P::Model, f64) {
    let attempt = |best: &mut (P::Model, f64), start: P::Model| {
        let raw = cost(problem, &start, loss);
        let other = polish(problem, start, raw, loss);
        if other.1 < best.1 {
            *best = other;
        }
    };
    // A cost twice as wide has fewer local minima in which a descent ends.
    let wide = Loss::new(2.0 * max_error);
    let (start, _) = polish(problem, best.0.clone(), cost(problem, &best.0, &wide), &wide);
    attempt(&mut best, start);
    if let Some(start) = problem.repair(&best.0, loss, sampler) {
        attempt(&mut best, start);
    }
    best
}

fn cost<P: Problem>(problem: &P, model: &P::Model, loss: &Loss) -> f64 {
    problem.squared_errors(model).map(|squared_error| loss.cost(squared_error)).sum()
}

fn cost_below<P: Problem>(problem: &P, model: &P::Model, loss: &Loss, limit: f64) -> Option<f64> {
    let add = |sum: f64, squared_error| Some(sum + loss.cost(squared_error)).filter(|sum| *sum < limit);
    problem.squared_errors(model).try_fold(0.0, add)
}

/// Descends to the nearest local minimum of the cost, by reweighted least squares; never to a worse model.
fn polish<P: Problem>(problem: &P, model: P::Model, cost: f64, loss: &Loss) -> (P::Model, f64) {
    let mut best = (model, cost);
    let mut weights = Vec::new();
    let (mut damping, after_success, after_failure, max) = DAMPING;
    for _ in 0..POLISH_STEPS {
        // Weights of the last model: each step solves a quadratic problem.
        weights.clear();
        weights.extend(problem.squared_errors(&best.0).map(|error| loss.weight(error)));
        // A damped step without gain is tried again, shorter; an undamped one ends the descent.
        let step = loop {
            let Some(model) = problem.refit(&best.0, &weights, damping) else { break None };
            if let Some(cost) = cost_below(problem, &model, loss, best.1) {
                break Some((model, cost));
            }
            damping *= after_failure;
            if !P::IS_DAMPED || damping > max {
                break None;
            }
        };
        let Some(step) = step else { break };
        damping *= after_success;
        let gain = best.1 - step.1;
        best = step;
        if gain < POLISH_TOLERANCE {
            break;
        }
    }
    best
}

/// Number of samples after which at least one consists of inliers alone, with the probability `confidence`.
fn iterations_needed(inliers: usize, count: usize, sample_size: usize, confidence: f64) -> usize {
    // Without replacement, as samples are drawn.
    let good = (0..sample_size).fold(1.0, |p, i| p * inliers.saturating_sub(i) as f64 / (count - i) as f64);
    // Infinite where none is good: beyond usize the conversion saturates.
    (libm::log(1.0 - confidence) / libm::log1p(-good)).ceil().max(1.0) as usize
}

/// The largest residual in units of σ_max: the 99 % quantile of χ with four degrees of freedom.
const K: f64 = 3.64;
/// Steps of the table over the squared residual; interpolation between them is exact to about 10⁻⁵ of the cost.
const STEPS: usize = 2048;

struct Table {
    cost: [f64; STEPS + 1],
    weight: [f64; STEPS + 1],
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let of = |raw: fn(f64) -> f64, full: f64| std::array::from_fn(|step| raw(step as f64 / STEPS as f64) / full);
    Table { cost: of(raw_cost, raw_cost(1.0)), weight: of(raw_weight, raw_weight(0.0)) }
});

fn upper_gamma_3_2(x: f64) -> f64 {
    0.5 * std::f64::consts::PI.sqrt() * libm::erfc(x.sqrt()) + x.sqrt() * libm::exp(-x)
}

fn lower_gamma_5_2(x: f64) -> f64 {
    0.75 * std::f64::consts::PI.sqrt() * libm::erf(x.sqrt()) - x.sqrt() * (1.5 + x) * libm::exp(-x)
}

/// The weight, up to a factor, at r² = `fraction`·(k·σ_max)².
fn raw_weight(fraction: f64) -> f64 {
    let max = 0.5 * K * K;
    upper_gamma_3_2(fraction * max) - upper_gamma_3_2(max)
}

/// The cost, up to a factor, at r² = `fraction`·(k·σ_max)²: the integral of r·weight.
fn raw_cost(fraction: f64) -> f64 {
    let max = 0.5 * K * K;
    let x = fraction * max;
    0.5 * lower_gamma_5_2(x) + 0.5 * x * (upper_gamma_3_2(x) - upper_gamma_3_2(max))
}

#[derive(Clone, Copy)]
pub(super) struct Loss {
    table: &'static Table,
    steps_per_squared_error: f64,
}

impl Loss {
    /// `threshold` is the largest residual of an inlier.
    pub(super) fn new(threshold: f64) -> Self {
        Self { table: &TABLE, steps_per_squared_error: STEPS as f64 / (threshold * threshold) }
    }

    pub(super) fn is_inlier(&self, squared_error: f64) -> bool {
        squared_error * self.steps_per_squared_error <= STEPS as f64
    }

    /// Cost of a squared residual: 0 at 0, 1 from the threshold on (and for NaN).
    pub(super) fn cost(&self, squared_error: f64) -> f64 {
        self.interpolated(&self.table.cost, squared_error).unwrap_or(1.0)
    }

    /// Weight of a squared residual: 1 at 0, 0 from the threshold on.
    pub(super) fn weight(&self, squared_error: f64) -> f64 {
        self.interpolated(&self.table.weight, squared_error).unwrap_or(0.0)
    }

    fn interpolated(&self, table: &[f64; STEPS + 1], squared_error: f64) -> Option<f64> {
        let at = squared_error * self.steps_per_squared_error;
        if at >= STEPS as f64 || at.is_nan() {
            return None;
        }
        let step = at as usize;
        let part = at - step as f64;
        Some(table[step] + part * (table[step + 1] - table[step]))
    }
}

/// Number of samples after which all matches are drawn from; the paper takes ten times as many.
const UNIFORM_AFTER: f64 = 20_000.0;

pub(super) struct Sampler {
    random: ChaCha8Rng,
    /// Match indices, the most promising first, and the number of them that are drawn from.
    order: Vec<usize>,
    open: usize,
    drawn: f64,
    /// The paper's T_n and T'_n: samples that plain RANSAC would have drawn from the open set; and when the set grows.
    expected: f64,
    grows_after: f64,
    size: usize,
}

impl Sampler {
    /// `order` has at least `size` matches.
    pub(super) fn new(order: Vec<usize>, size: usize, seed: u64) -> Self {
        // The samples among the first `size` that UNIFORM_AFTER uniform samples of all matches would hold.
        let expected = (0..size).fold(UNIFORM_AFTER, |t, i| t * (size - i) as f64 / (order.len() - i) as f64);
        let random = ChaCha8Rng::seed_from_u64(seed);
        Self { random, order, open: size, drawn: 0.0, expected, grows_after: 1.0, size }
    }

    pub(super) fn draw(&mut self, sample: &mut [usize]) {
        self.drawn += 1.0;
        let count = self.order.len();
        while self.drawn > self.grows_after && self.open < count {
            // T_(n+1) = T_n·(n + 1)/(n + 1 − m), as in the paper.
            let next = self.expected * (self.open + 1) as f64 / (self.open + 1 - self.size) as f64;
            self.grows_after += (next - self.expected).ceil().max(1.0);
            self.expected = next;
            self.open += 1;
        }
        let size = self.size;
        if self.drawn <= self.grows_after && self.open < count {
            // The newest of the open set and others before it: all other samples of the open set were drawn earlier.
            self.distinct(&mut sample[..size - 1], self.open - 1);
            sample[size - 1] = self.open - 1;
        } else {
            self.distinct(&mut sample[..size], self.open);
        }
        for place in sample.iter_mut() {
            *place = self.order[*place];
        }
    }

    fn distinct(&mut self, places: &mut [usize], below: usize) {
        for i in 0..places.len() {
            places[i] = loop {
                let number = self.below(below);
                if !places[..i].contains(&number) {
                    break number;
                }
            };
        }
    }

    /// A number below `below`, with equal probabilities up to one part in 2³².
    pub(super) fn below(&mut self, below: usize) -> usize {
        ((u128::from(self.random.next_u64()) * below as u128) >> 64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

        fn solve(&self, sample: &[usize], models: &mut Vec<f64>) {
            models.push(self.0[sample[0]]);
        }

        fn squared_errors(&self, model: &f64) -> impl Iterator<Item = f64> {
            self.0.iter().map(move |x| (x - model).powi(2))
        }

        fn refit(&self, _: &f64, weights: &[f64], _: f64) -> Option<f64> {
            let sum: f64 = weights.iter().sum();
            (sum > 0.0).then(|| self.0.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>() / sum)
        }
    }

    fn found(numbers: Vec<f64>, known: Option<f64>, monitor: &Monitor) -> Result<(Option<f64>, usize), Cancelled> {
        let order = (0..numbers.len()).collect();
        estimate(&Mean(numbers), order, known, 1.0, &MatchParams { seed: 1, ..MatchParams::default() }, monitor)
    }

    #[test]
    fn outliers_do_not_move_the_mean_too_few_have_none_and_cancelling_ends_it() {
        let numbers = [1.0, 1.2, 0.9, 1.1, 0.8, 40.0, 50.0, 60.0, 70.0, -30.0, -99.0].to_vec();
        let (mean, iterations) = found(numbers.clone(), None, &Monitor::default()).expect("not cancelled");
        assert!((mean.expect("a mean") - 1.0).abs() < 0.01);
        assert_eq!(iterations, MIN_ITERATIONS);
        // A known mean needs the samples that five of eleven do; of a wrong one, samples find the right one.
        for (known, samples) in [(1.3, 12), (55.3, 12)] {
            let again = found(numbers.clone(), Some(known), &Monitor::default()).expect("not cancelled");
            assert!((again.0.expect("a mean") - 1.0).abs() < 0.01 && again.1 == samples, "{again:?}");
        }
        assert_eq!(found(Vec::new(), None, &Monitor::default()), Ok((None, 0)));
        assert!(found(vec![1.0], None, &Monitor::cancelled()).is_err());
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
}
