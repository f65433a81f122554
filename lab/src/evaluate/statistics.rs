//! Means with their standard errors, and statistics of a set of errors.

use serde::Serialize;

/// A mean and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mean {
    /// Mean; NaN (null in JSON) of no samples.
    pub mean: f64,
    /// Standard error, from the spread of the samples; absent when there are fewer than two.
    pub standard_error: Option<f64>,
}

impl Mean {
    /// The mean of `samples`.
    pub fn of(samples: &[f64]) -> Self {
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let standard_error = (samples.len() > 1).then(|| {
            // n − 1, because the mean comes from the same samples.
            let variance = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
            (variance / n).sqrt()
        });
        Self { mean, standard_error }
    }

    /// Ends of one standard error below and above the mean; `None` without a standard error.
    pub fn within_error(&self) -> Option<[f64; 2]> {
        self.standard_error.map(|error| [self.mean - error, self.mean + error])
    }
}

impl std::fmt::Display for Mean {
    /// Writes `mean ± standard error`, right-aligned to the width, with the given precision (default: one decimal).
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let precision = f.precision().unwrap_or(1);
        let text = match self.standard_error {
            _ if self.mean.is_nan() => "–".to_owned(),
            Some(error) => format!("{:.precision$} ± {error:.precision$}", self.mean),
            None => format!("{:.precision$}", self.mean),
        };
        write!(f, "{text:>width$}", width = f.width().unwrap_or(0))
    }
}

/// Statistics of a set of signed errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Number of errors.
    pub count: usize,
    /// Mean of the signed errors: the bias.
    pub signed: Mean,
    /// Median of the magnitudes; NaN (null in JSON) of none.
    pub median_magnitude: f64,
    /// Magnitude that 95 % of the errors do not exceed.
    pub magnitude_95: f64,
}

impl Errors {
    /// The statistics of `signed` errors.
    pub fn of(signed: &[f64]) -> Self {
        let [median_magnitude, magnitude_95] = quantiles(signed.iter().map(|x| x.abs()), [0.5, 0.95]);
        Self { count: signed.len(), signed: Mean::of(signed), median_magnitude, magnitude_95 }
    }
}

/// The quantiles `of` the values, which come in any order.
pub(crate) fn quantiles<const N: usize>(values: impl Iterator<Item = f64>, of: [f64; N]) -> [f64; N] {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    of.map(|q| quantile(&sorted, q))
}

/// The `q`-quantile of sorted values, linear between neighbours; NaN of none.
fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = q.clamp(0.0, 1.0) * last as f64;
    let below = at.floor() as usize;
    let part = at - below as f64;
    sorted[below] + part * (sorted[(below + 1).min(last)] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_standard_error_are_the_textbook_ones() {
        let mean = Mean::of(&[1.0, 2.0, 3.0, 6.0]);
        assert_eq!(mean.mean, 3.0);
        // Variance (4 + 1 + 0 + 9)/3, over 4.
        assert!((mean.standard_error.expect("several") - (14.0f64 / 12.0).sqrt()).abs() < 1e-12);
        assert_eq!(Mean::of(&[5.0]), Mean { mean: 5.0, standard_error: None });
        assert!(Mean::of(&[]).mean.is_nan());
        assert_eq!(format!("{:.2}|{:>14}", mean, mean), "3.00 ± 1.08|     3.0 ± 1.1");
    }

    #[test]
    fn quantiles_and_errors() {
        let errors = Errors::of(&[-4.0, 1.0, 2.0, -3.0, 0.0]);
        assert_eq!((errors.count, errors.median_magnitude), (5, 2.0));
        assert!((errors.magnitude_95 - 3.8).abs() < 1e-12);
        assert_eq!(errors.signed.mean, -0.8);
        assert_eq!(quantile(&[7.0], 0.95), 7.0);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
