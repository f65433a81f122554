//! Real roots of polynomials, for the solvers of seven points (a cubic) and five. Double roots may be missed.

use polycool::PolyDyn;

/// The real roots of Σ `coefficients[k]`·xᵏ, ascending. Empty for a constant, and where a coefficient is not finite.
pub(super) fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    let largest = coefficients.iter().fold(0.0, |max: f64, c| max.max(c.abs()));
    if !(largest.is_finite() && largest > 0.0) || coefficients.iter().any(|c| c.is_nan()) {
        return Vec::new();
    }
    // A negligible leading coefficient would put a root near infinity.
    let degree = coefficients.iter().rposition(|c| c.abs() > 1e-14 * largest).unwrap_or(0);
    let (lower, leading) = (&coefficients[..degree], coefficients[degree]);
    // Cauchy's bound on the magnitude of the roots.
    let bound = 1.0 + lower.iter().fold(0.0, |max: f64, c| max.max((c / leading).abs()));
    // The roots of a cubic come from a division by the first one, which costs digits; a fourth degree's do not.
    let padding = (degree == 3).then_some(0.0);
    let scaled = coefficients[..=degree].iter().map(|c| c / largest);
    PolyDyn::new(scaled.chain(padding)).roots_between(-bound, bound, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
        let cases: [(&[f64], &[f64]); 8] = [
            (&[], &[]),
            (&[3.0], &[]),
            (&[0.0, 0.0], &[]),
            (&[f64::NAN, 1.0], &[]),
            (&[6.0, -2.0], &[3.0]),
            (&[1.0, 0.0, 1.0], &[]),
            (&[-4.0, 0.0, 1.0, 0.0, 0.0], &[-2.0, 2.0]),
            (&[0.0, 0.0, 0.0, 1.0], &[0.0]),
        ];
        for (coefficients, roots) in cases {
            assert_eq!(real_roots(coefficients), roots);
        }
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
