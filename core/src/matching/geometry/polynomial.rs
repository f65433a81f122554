//! The real roots of polynomials in one unknown, for the minimal solvers: the cubic of seven points, the tenth degree
//! of five.
//!
//! Between two neighbouring extrema a polynomial crosses zero at most once. So the roots of the derivative, found in
//! the same way, separate those of the polynomial, and each is then found by Newton's method, with bisection where that
//! fails. This needs no complex arithmetic, finds roots to the last digits that the coefficients allow, and always
//! ends. A double root may be found or missed, depending on rounding.

/// Maximum number of steps for one root: bisection alone needs about 64 for the digits of an `f64`.
const MAX_STEPS: usize = 100;

/// The value at `x` of the polynomial with these coefficients, the constant first.
fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// The real roots of the polynomial Σ `coefficients[k]`·xᵏ, in ascending order. Empty for a constant, and where a
/// coefficient is not finite.
pub(super) fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    let largest = coefficients.iter().fold(0.0, |max: f64, c| max.max(c.abs()));
    if !(largest.is_finite() && largest > 0.0) || coefficients.iter().any(|c| c.is_nan()) {
        return Vec::new();
    }
    // A negligible leading coefficient would put a root near infinity.
    let degree = coefficients.iter().rposition(|c| c.abs() > 1e-14 * largest).unwrap_or(0);
    let coefficients = &coefficients[..=degree];
    match degree {
        0 => return Vec::new(),
        1 => return vec![-coefficients[0] / coefficients[1]],
        _ => {}
    }
    let derivative: Vec<f64> = coefficients.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect();
    // Cauchy's bound on the magnitude of the roots.
    let bound = 1.0 + coefficients[..degree].iter().fold(0.0, |max: f64, c| max.max((c / coefficients[degree]).abs()));
    let mut borders = vec![-bound];
    borders.extend(real_roots(&derivative).into_iter().filter(|x| x.abs() < bound));
    borders.push(bound);
    borders.windows(2).filter_map(|pair| root_between(coefficients, &derivative, pair[0], pair[1])).collect()
}

/// The root in (`low`, `high`], an interval on which the polynomial is monotonic; `None` without a change of sign.
fn root_between(coefficients: &[f64], derivative: &[f64], mut low: f64, mut high: f64) -> Option<f64> {
    let (at_low, at_high) = (value(coefficients, low), value(coefficients, high));
    if at_high == 0.0 {
        return Some(high);
    }
    if at_low == 0.0 || (at_low < 0.0) == (at_high < 0.0) {
        return None;
    }
    let rising = at_low < 0.0;
    let mut x = 0.5 * (low + high);
    for _ in 0..MAX_STEPS {
        let y = value(coefficients, x);
        if y == 0.0 {
            return Some(x);
        }
        if (y < 0.0) == rising {
            low = x;
        } else {
            high = x;
        }
        let newton = x - y / value(derivative, x);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 2.0 * f64::EPSILON * x.abs() {
            return Some(next);
        }
        x = next;
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Coefficients of Π (x − r).
    fn with_roots(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |c, r| {
            let mut product = vec![0.0; c.len() + 1];
            for (k, c) in c.iter().enumerate() {
                product[k + 1] += c;
                product[k] -= r * c;
            }
            product
        })
    }

    #[test]
    fn simple_cases() {
        const NONE: [f64; 0] = [];
        assert_eq!(real_roots(&[]), NONE);
        assert_eq!(real_roots(&[3.0]), NONE);
        assert_eq!(real_roots(&[0.0, 0.0]), NONE);
        assert_eq!(real_roots(&[f64::NAN, 1.0]), NONE);
        assert_eq!(real_roots(&[6.0, -2.0]), [3.0]);
        assert_eq!(real_roots(&[1.0, 0.0, 1.0]), NONE);
        assert_eq!(real_roots(&[-4.0, 0.0, 1.0]), [-2.0, 2.0]);
        assert_eq!(real_roots(&[-4.0, 0.0, 1.0, 0.0, 0.0]), [-2.0, 2.0]);
        assert_eq!(real_roots(&[0.0, 0.0, 0.0, 1.0]), [0.0]);
    }

    proptest! {
        #[test]
        fn roots_that_are_apart_are_found(steps in prop::collection::vec(0.2f64..1.0, 1..10), start in -3.0f64..0.0, scale in 1e-6f64..1e6) {
            let roots: Vec<f64> = steps.iter().scan(start, |x, step| { *x += step; Some(*x) }).collect();
            let coefficients: Vec<f64> = with_roots(&roots).iter().map(|c| c * scale).collect();
            let found = real_roots(&coefficients);
            prop_assert_eq!(found.len(), roots.len(), "{:?} of {:?}", found, roots);
            for (x, root) in found.iter().zip(&roots) {
                prop_assert!((x - root).abs() < 1e-3, "{:?} of {:?}", found, roots);
            }
        }

        #[test]
        fn any_numbers_end(coefficients in prop::collection::vec(any::<f64>(), 0..12)) {
            prop_assert!(real_roots(&coefficients).len() <= 11);
        }
    }
}
