//! The share of things found over their strength, as a logistic curve fitted by maximum likelihood.
//!
//! The curve is 1/(1 + exp(−b·(x − m))), where x is the natural logarithm of the strength. Its middle m has a wide
//! prior around the noise gate's prediction, its steepness b a prior around the value that noise of 1 σ on a gate of
//! k σ gives. A fit so exists even where all or none are found, and is reported as beyond the measured range.

use serde::Serialize;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Natural logarithm of the strength.
    pub ln_strength: f64,
    pub is_found: bool,
    /// Weight, 0 … 1.
    pub weight: f64,
}

/// Prior of the curve: mean and standard deviation of its middle, and its steepness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    pub middle: f64,
    pub middle_deviation: f64,
    pub steepness: f64,
    /// Standard deviation of ln b; 0 keeps the steepness.
    pub steepness_deviation: f64,
}

impl Prior {
    /// Prior for a gate of `factor` k: a normal step of deviation 1/k is nearest to a logistic step of steepness 1.7 k.
    pub fn of_gate(factor: f64, middle: f64) -> Self {
        Self { middle, middle_deviation: 2.0, steepness: 1.7 * factor.max(1.0), steepness_deviation: 0.7 }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FittedCurve {
    /// Middle m: logarithm of the strength at which half are found.
    pub middle: f64,
    pub middle_error: f64,
    pub steepness: f64,
}

impl FittedCurve {
    pub fn share(&self, strength: f64) -> f64 {
        logistic(self.steepness * (strength.ln() - self.middle))
    }

    /// Strength at which `share` (between 0 and 1) is found.
    pub fn strength_at(&self, share: f64) -> f64 {
        (self.middle + (share / (1.0 - share)).ln() / self.steepness).exp()
    }
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// Number of steps of the fit; it converges in fewer.
const STEPS: usize = 60;

/// Fits the curve to `outcomes` by Fisher scoring of the posterior; the same outcomes give the same bits.
pub fn fitted(outcomes: &[Outcome], prior: &Prior) -> FittedCurve {
    let q0 = prior.steepness.ln();
    let (mut m, mut q) = (prior.middle, q0);
    let is_free = prior.steepness_deviation > 0.0;
    let (pm, pq) = (prior.middle_deviation.powi(-2), if is_free { prior.steepness_deviation.powi(-2) } else { 1.0 });
    // Information about (m, m), (m, q), (q, q), and the gradient, of the posterior.
    let sums = |m: f64, q: f64| {
        let b = q.exp();
        let mut info = [pm, 0.0, pq];
        let mut gradient = [-(m - prior.middle) * pm, -(q - q0) * pq];
        for one in outcomes {
            let eta = b * (one.ln_strength - m);
            let p = logistic(eta);
            let rest = one.weight * (f64::from(u8::from(one.is_found)) - p);
            let spread = one.weight * p * (1.0 - p);
            gradient[0] -= rest * b;
            gradient[1] += rest * eta;
            info[0] += spread * b * b;
            info[1] -= spread * b * eta;
            info[2] += spread * eta * eta;
        }
        // A kept steepness drops out: no gradient of its own, and no coupling to the middle.
        if !is_free {
            (info[1], gradient[1]) = (0.0, 0.0);
        }
        (info, gradient)
    };
    for _ in 0..STEPS {
        let ([mm, mq, qq], [gm, gq]) = sums(m, q);
        let determinant = mm * qq - mq * mq;
        // Steps are bounded, because far from the solution the curve is flat.
        let step = [(qq * gm - mq * gq) / determinant, (mm * gq - mq * gm) / determinant];
        // Numbers beyond what a double holds, as those of an absurd gate, leave the curve where it is.
        if !(determinant > 0.0 && step.iter().all(|x| x.is_finite())) {
            break;
        }
        m += step[0].clamp(-0.3, 0.3);
        q = (q + step[1].clamp(-0.5, 0.5)).clamp(q0 - 3.0, q0 + 3.0);
    }
    let ([mm, mq, qq], _) = sums(m, q);
    let determinant = (mm * qq - mq * mq).max(f64::MIN_POSITIVE);
    let middle_error = (qq / determinant).sqrt();
    // An absurd gate overflows to NaN, after which nothing is known about the middle.
    let middle_error = if middle_error.is_nan() { f64::INFINITY } else { middle_error };
    FittedCurve { middle: m, middle_error, steepness: q.exp() }
}

/// Ends of the 68 % interval of the share `found` of `count` (Wilson's), 0 … 1.
pub fn share_interval(found: usize, count: usize) -> [f64; 2] {
    let (n, z) = (count.max(1) as f64, 1.0);
    let p = found as f64 / n;
    let middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::random::Stream;

    fn drawn(middle: f64, steepness: f64, count: usize, seed: u64) -> Vec<Outcome> {
        let mut stream = Stream::new(seed, 0);
        let one = |_| {
            let ln_strength = stream.within(middle - 0.8, middle + 0.8);
            let is_found = stream.uniform() < logistic(steepness * (ln_strength - middle));
            Outcome { ln_strength, is_found, weight: 1.0 }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn the_middle_of_drawn_outcomes_is_found_within_its_error() {
        let prior = Prior::of_gate(5.0, 0.3);
        let mut within = 0;
        for seed in 0..40 {
            let fit = fitted(&drawn(-0.4, 8.0, 200, seed), &prior);
            within += usize::from((fit.middle + 0.4).abs() < 2.0 * fit.middle_error);
            assert!((4.0..16.0).contains(&fit.steepness), "{fit:?}");
            assert!((fit.share(fit.strength_at(0.9)) - 0.9).abs() < 1e-9);
        }
        assert!(within >= 34, "{within} of 40 within two standard errors");
    }

    #[test]
    fn more_outcomes_have_a_smaller_error_and_none_found_lies_above_all() {
        let prior = Prior::of_gate(5.0, 0.0);
        let few = fitted(&drawn(0.1, 8.0, 60, 1), &prior);
        let many = fitted(&drawn(0.1, 8.0, 600, 1), &prior);
        assert!((0.2..0.5).contains(&(many.middle_error / few.middle_error)), "{few:?} {many:?}");
        let none: Vec<Outcome> = drawn(0.0, 8.0, 50, 2).iter().map(|o| Outcome { is_found: false, ..*o }).collect();
        let fit = fitted(&none, &prior);
        assert!(fit.middle > none.iter().map(|o| o.ln_strength).fold(f64::MIN, f64::max), "{fit:?}");
    }

    #[test]
    fn absurd_gates_and_strengths_give_a_curve_all_the_same() {
        let outcomes = drawn(0.1, 8.0, 60, 1);
        for factor in [1e20, 1e200, f64::MAX] {
            let fit = fitted(&outcomes, &Prior::of_gate(factor, factor.ln()));
            assert!(fit.middle.is_finite() && !fit.steepness.is_nan() && !fit.middle_error.is_nan(), "{fit:?}");
        }
        let endless = [Outcome { ln_strength: f64::INFINITY, is_found: true, weight: 1.0 }];
        let fit = fitted(&endless, &Prior::of_gate(5.0, 0.0));
        assert!(fit.middle.is_finite() && fit.steepness.is_finite(), "{fit:?}");
    }

    #[test]
    fn intervals_hold_the_share_and_stay_inside() {
        for (found, count) in [(0, 5), (5, 5), (3, 9), (0, 0)] {
            let [low, high] = share_interval(found, count);
            assert!((0.0..=1.0).contains(&low) && low <= high && high <= 1.0);
            assert!(count == 0 || (low - 1e-9..=high + 1e-9).contains(&(found as f64 / count as f64)));
        }
    }
}
