//! Robust estimation: the model that most of the matches agree on, despite outliers.
//!
//! RANSAC (Fischler and Bolles, 1981) with later improvements. Samples come by quality at first ([`super::sampling`]);
//! a model's quality is a smooth cost that does not depend on one threshold ([`super::loss`]); each model that is the
//! best so far is improved at once by iteratively reweighted least squares over all its inliers (local optimisation:
//! Chum, Matas and Kittler, "Locally Optimized RANSAC", 2003; reweighting as in MAGSAC++); scoring stops as soon as a
//! model cannot become the best; sampling stops once a better model would have been found with the requested
//! confidence; and a model that explains only a degenerate part of the scene may be repaired ([`Problem::repair`]).
//!
//! Everything happens in a fixed order on one thread: the same matches, parameters and seed give the same bits.

use super::loss::Loss;
use super::sampling::Sampler;
use crate::monitor::{Cancelled, Monitor};

/// A model to be estimated from matches.
pub(super) trait Problem {
    /// Type of the model.
    type Model: Clone;

    /// Number of matches that determine a model, up to a few solutions.
    const SAMPLE_SIZE: usize;

    /// Number of matches.
    fn count(&self) -> usize;

    /// Appends all models that fit the sample exactly; none for a degenerate sample.
    fn solve(&self, sample: &[usize], models: &mut Vec<Self::Model>);

    /// Squared error of a match under a model; infinite where it is undefined.
    fn squared_error(&self, model: &Self::Model, index: usize) -> f64;

    /// Whether a step of [`Self::refit`] may be too long and is shortened by damping.
    const IS_DAMPED: bool = false;

    /// The model near `model` with the minimum weighted sum of squared errors, or one closer to it; `None` where the
    /// weights leave it undetermined. `damping`, above 0, shortens the steps of damped problems: near 0 the step is
    /// full, above 1 it is a small step downhill.
    fn refit(&self, model: &Self::Model, weights: &[f64], damping: f64) -> Option<Self::Model>;

    /// A model that may be better than `model`, which may explain only a degenerate part of the scene, such as a plane.
    fn repair(&self, _model: &Self::Model, _loss: &Loss, _sampler: &mut Sampler) -> Option<Self::Model> {
        None
    }
}

/// Parameters of the estimate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    /// Max error of an inlier, in the problem's unit.
    pub max_error: f64,
    /// Probability that no better model was missed, at which sampling stops.
    pub confidence: f64,
    /// Maximum number of samples.
    pub max_iterations: usize,
    /// Seed of the samples.
    pub seed: u64,
}

/// The best model found, if any, and the number of samples drawn.
pub(super) struct Consensus<M> {
    pub model: Option<M>,
    pub iterations: usize,
}

/// Minimum number of samples: a model found by luck should not end the search at once.
const MIN_ITERATIONS: usize = 50;
/// Maximum number of steps of a local optimisation; most end after three to five.
const POLISH_STEPS: usize = 50;
/// Decrease of the cost, in matches, below which a step is the last.
const POLISH_TOLERANCE: f64 = 1e-3;
/// Damping of the first step, its factor after a success, its factor after a failure, and the value beyond which a
/// local optimisation ends.
const DAMPING: (f64, f64, f64, f64) = (1e-6, 0.1, 100.0, 100.0);

/// The model with the minimum cost. `order` are the indices of all matches, the most promising first.
pub(super) fn estimate<P: Problem>(
    problem: &P,
    order: Vec<usize>,
    settings: &Settings,
    monitor: &Monitor,
) -> Result<Consensus<P::Model>, Cancelled> {
    monitor.check()?;
    let count = problem.count();
    debug_assert_eq!(count, order.len(), "each match has its place in the order");
    if count < P::SAMPLE_SIZE {
        return Ok(Consensus { model: None, iterations: 0 });
    }
    let loss = Loss::new(settings.max_error);
    let mut sampler = Sampler::new(order, P::SAMPLE_SIZE, settings.seed);
    let mut sample = vec![0; P::SAMPLE_SIZE];
    let mut models = Vec::new();
    let mut best: Option<(P::Model, f64)> = None;
    let mut min_raw = f64::INFINITY;
    let (mut iterations, mut needed) = (0, settings.max_iterations);
    while iterations < needed {
        if iterations % 64 == 0 {
            monitor.check()?;
        }
        iterations += 1;
        sampler.draw(&mut sample);
        models.clear();
        problem.solve(&sample, &mut models);
        for model in &models {
            // A sample's exact model is compared with other such models, not with optimised ones: it may lead to a
            // better optimum.
            let Some(raw) = cost_below(problem, model, &loss, min_raw) else { continue };
            min_raw = raw;
            let candidate = polish(problem, model.clone(), raw, &loss);
            if best.as_ref().is_some_and(|(_, cost)| candidate.1 >= *cost) {
                continue;
            }
            let inliers = inlier_count(problem, &candidate.0, &loss);
            best = Some(candidate);
            needed = iterations_needed(inliers, count, P::SAMPLE_SIZE, settings.confidence)
                .max(MIN_ITERATIONS)
                .min(settings.max_iterations);
        }
    }
    monitor.check()?;
    let best = best.map(|best| finished(problem, best, settings, &loss, &mut sampler));
    Ok(Consensus { model: best.map(|(model, _)| model), iterations })
}

/// The best model after two more attempts to improve it: by descent on a smoother cost, and by repair of a degenerate
/// model.
fn finished<P: Problem>(
    problem: &P,
    mut best: (P::Model, f64),
    settings: &Settings,
    loss: &Loss,
    sampler: &mut Sampler,
) -> (P::Model, f64) {
    let attempt = |best: &mut (P::Model, f64), start: P::Model| {
        if let Some(cost) = cost_below(problem, &start, loss, f64::INFINITY) {
            let other = polish(problem, start, cost, loss);
            if other.1 < best.1 {
                *best = other;
            }
        }
    };
    // A cost twice as wide has fewer local minima in which a descent ends.
    let wide = Loss::new(2.0 * settings.max_error);
    if let Some(cost) = cost_below(problem, &best.0, &wide, f64::INFINITY) {
        let (start, _) = polish(problem, best.0.clone(), cost, &wide);
        attempt(&mut best, start);
    }
    if let Some(start) = problem.repair(&best.0, loss, sampler) {
        attempt(&mut best, start);
    }
    best
}

/// The sum of the costs of all matches, or `None` as soon as it reaches `limit`.
fn cost_below<P: Problem>(problem: &P, model: &P::Model, loss: &Loss, limit: f64) -> Option<f64> {
    let mut sum = 0.0;
    for index in 0..problem.count() {
        sum += loss.cost(problem.squared_error(model, index));
        if sum >= limit {
            return None;
        }
    }
    Some(sum)
}

/// Descends from a model to the nearest local minimum of the cost, by reweighted least squares. Never returns a worse
/// one.
fn polish<P: Problem>(problem: &P, model: P::Model, cost: f64, loss: &Loss) -> (P::Model, f64) {
    let mut best = (model, cost);
    let mut weights = vec![0.0; problem.count()];
    let (mut damping, after_success, after_failure, max) = DAMPING;
    for _ in 0..POLISH_STEPS {
        for (index, weight) in weights.iter_mut().enumerate() {
            *weight = loss.weight(problem.squared_error(&best.0, index));
        }
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

fn inlier_count<P: Problem>(problem: &P, model: &P::Model, loss: &Loss) -> usize {
    (0..problem.count()).filter(|&index| loss.is_inlier(problem.squared_error(model, index))).count()
}

/// Number of samples after which at least one consists of inliers alone, with the probability `confidence`.
fn iterations_needed(inliers: usize, count: usize, sample_size: usize, confidence: f64) -> usize {
    // Without replacement, as samples are drawn.
    let good = (0..sample_size).fold(1.0, |p, i| p * inliers.saturating_sub(i) as f64 / (count - i) as f64);
    if good <= 0.0 {
        return usize::MAX;
    }
    if good >= 1.0 {
        return 1;
    }
    // Beyond usize the conversion saturates.
    (libm::log(1.0 - confidence) / libm::log1p(-good)).ceil() as usize
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

    /// The mean of numbers: a problem as simple as possible.
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

    #[test]
    fn outliers_do_not_move_the_mean() {
        let numbers = [1.0, 1.2, 0.9, 1.1, 0.8, 40.0, 50.0, 60.0, 70.0, -30.0, -99.0].to_vec();
        let settings = Settings { max_error: 1.0, confidence: 0.99, max_iterations: 1000, seed: 1 };
        let found = estimate(&Mean(numbers), (0..11).collect(), &settings, &Monitor::default()).expect("not cancelled");
        assert!((found.model.expect("a mean") - 1.0).abs() < 0.01);
        assert_eq!(found.iterations, MIN_ITERATIONS);
    }

    #[test]
    fn too_few_have_no_model_and_cancelling_ends_it() {
        let settings = Settings { max_error: 1.0, confidence: 0.99, max_iterations: 1000, seed: 1 };
        let none = estimate(&Mean(Vec::new()), Vec::new(), &settings, &Monitor::default()).expect("not cancelled");
        assert!(none.model.is_none() && none.iterations == 0);
        let monitor = Monitor::default();
        monitor.cancel();
        assert!(estimate(&Mean(vec![1.0]), vec![0], &settings, &monitor).is_err());
    }
}
