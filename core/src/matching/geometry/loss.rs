//! Cost and weight of a residual, marginalised over the unknown noise.
//!
//! Plain RANSAC counts residuals below a threshold, so its result depends on that threshold. MAGSAC++ (Barath, Noskova,
//! Ivashechkin and Matas, "MAGSAC++, a Fast, Reliable and Accurate Robust Estimator", CVPR 2020) instead takes the
//! noise's scale σ as uniformly distributed between 0 and σ_max and integrates it out: a residual's weight falls
//! smoothly from zero error to the largest one, k·σ_max, and its cost rises from 0 to a constant. Residuals follow a χ
//! distribution of four degrees of freedom, and k = 3.64 is its quantile of 99 %, as in the paper. Costs here are
//! scaled to reach 1 at the threshold.
//!
//! For four degrees of freedom the incomplete gamma functions of the paper are elementary: with x = r²/(2σ²_max),
//! Γ(3/2, x) = ½√π·erfc(√x) + √x·e⁻ˣ and γ(5/2, x) = ¾√π·erf(√x) − (x^½·3/2 + x^3/2)·e⁻ˣ. They are tabulated once over
//! the squared residual.

use std::sync::LazyLock;

/// The largest residual in units of σ_max: the 99 % quantile of χ with four degrees of freedom.
const K: f64 = 3.64;
/// Number of steps of the table over the squared residual, 0 … threshold². Linear interpolation between them is exact
/// to about 10⁻⁵ of the cost.
const STEPS: usize = 2048;

/// Cost and weight at the steps of the squared residual.
struct Table {
    cost: [f64; STEPS + 1],
    weight: [f64; STEPS + 1],
}

static TABLE: LazyLock<Box<Table>> = LazyLock::new(|| {
    let mut table = Box::new(Table { cost: [0.0; STEPS + 1], weight: [0.0; STEPS + 1] });
    let (full_cost, full_weight) = (raw_cost(1.0), raw_weight(0.0));
    for step in 0..=STEPS {
        let fraction = step as f64 / STEPS as f64;
        table.cost[step] = raw_cost(fraction) / full_cost;
        table.weight[step] = raw_weight(fraction) / full_weight;
    }
    table
});

/// Γ(3/2, x).
fn upper_gamma_3_2(x: f64) -> f64 {
    0.5 * std::f64::consts::PI.sqrt() * libm::erfc(x.sqrt()) + x.sqrt() * libm::exp(-x)
}

/// γ(5/2, x).
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

/// Loss of residuals, constant above a threshold.
#[derive(Clone, Copy)]
pub(super) struct Loss {
    table: &'static Table,
    steps_per_squared_error: f64,
}

impl Loss {
    /// Creates the loss; `threshold` is the largest residual of an inlier, in the residuals' unit.
    pub(super) fn new(threshold: f64) -> Self {
        Self { table: &TABLE, steps_per_squared_error: STEPS as f64 / (threshold * threshold) }
    }

    /// Whether a squared residual is within the threshold.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ f over `from..to` by Simpson's rule.
    fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
        let n = 20_000;
        let h = (to - from) / f64::from(n);
        let inner: f64 = (1..n).map(|i| f(from + f64::from(i) * h) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
        (f(from) + f(to) + inner) * h / 3.0
    }

    #[test]
    fn the_gammas_are_the_integrals_they_stand_for() {
        for x in [0.01, 0.5, 2.0, 6.6] {
            let upper = integral(|t| t.sqrt() * (-t).exp(), x, 60.0);
            assert!((upper_gamma_3_2(x) - upper).abs() < 1e-7, "{x}: {upper}");
            let lower = integral(|t| t * t.sqrt() * (-t).exp(), 0.0, x);
            assert!((lower_gamma_5_2(x) - lower).abs() < 1e-7, "{x}: {lower}");
        }
    }

    #[test]
    fn the_cost_is_the_integral_of_the_weight_times_the_residual() {
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
}
