//! True against false features over all thresholds.

use super::Judged;
use serde::Serialize;

/// Counts at one threshold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurvePoint {
    /// Threshold: features of at least this value are kept. Infinite (null in JSON) for the first point, which keeps
    /// none.
    pub threshold: f32,
    /// Number of false features.
    pub false_features: usize,
    /// Number of discs found.
    pub true_positives: usize,
}

/// True against false features over all thresholds: the ROC curve of a chart, with counts on both axes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Points from the highest threshold to the lowest; both counts never fall. The first point is (0, 0).
    pub points: Vec<CurvePoint>,
}

impl Curve {
    /// The curve of judged features, strongest first. Features of equal value are kept or dropped together.
    pub fn of(judged: &[Judged]) -> Self {
        let mut point = CurvePoint { threshold: f32::INFINITY, false_features: 0, true_positives: 0 };
        let mut points = vec![point];
        for (i, one) in judged.iter().enumerate() {
            if one.disc.is_some() {
                point.true_positives += 1;
            } else {
                point.false_features += 1;
            }
            if judged.get(i + 1).is_none_or(|next| next.worth != one.worth) {
                point.threshold = one.worth;
                points.push(point);
            }
        }
        Self { points }
    }

    /// The point with the most discs found among those where at most `fraction` (0 … 1) of the detections are false; of
    /// several, the one with the fewest false. The first point, with no detection, always qualifies.
    pub fn at_false_fraction(&self, fraction: f64) -> CurvePoint {
        let within = |p: &&CurvePoint| {
            // A margin for rounding: 10 of 100 are a tenth.
            p.false_features as f64 <= fraction * (p.false_features + p.true_positives) as f64 + 1e-9
        };
        let best = self
            .points
            .iter()
            .filter(within)
            .max_by(|a, b| a.true_positives.cmp(&b.true_positives).then(b.false_features.cmp(&a.false_features)));
        *best.unwrap_or(&self.points[0])
    }

    /// The maximum number of discs found with at most `count` false features.
    pub fn true_positives_at(&self, count: usize) -> usize {
        let beyond = self.points.partition_point(|p| p.false_features <= count);
        self.points[beyond - 1].true_positives
    }

    /// The point that keeps all features.
    pub fn end(&self) -> CurvePoint {
        self.points[self.points.len() - 1]
    }
}

/// The mean over `curves` of the discs found with at most 0, 1, … `most_false` false features. A curve that ends
/// earlier (its detector finds no more) keeps its last value. NaN where there is no curve.
pub fn mean_curve(curves: &[&Curve], most_false: usize) -> Vec<f64> {
    (0..=most_false)
        .map(|count| curves.iter().map(|c| c.true_positives_at(count) as f64).sum::<f64>() / curves.len() as f64)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn features_of_equal_worth_come_together() {
        let judged = [(1.0, Some(0)), (0.5, None), (0.5, Some(1)), (0.5, None)].map(|(worth, disc)| Judged {
            feature: 0,
            worth,
            disc,
        });
        let counts: Vec<_> = Curve::of(&judged).points.iter().map(|p| (p.false_features, p.true_positives)).collect();
        assert_eq!(counts, [(0, 0), (0, 1), (2, 2)]);
    }

    #[test]
    fn a_tenth_false_includes_exactly_a_tenth() {
        let ranked = |pattern: &str| -> Curve {
            let judged: Vec<Judged> = pattern
                .chars()
                .enumerate()
                .map(|(i, c)| Judged { feature: i, worth: -(i as f32), disc: (c == 't').then_some(i) })
                .collect();
            Curve::of(&judged)
        };
        // 9 true of 10: exactly a tenth false; the next false one is too many, even though a true one follows.
        let curve = ranked("tttttftttfttft");
        assert_eq!(curve.at_false_fraction(0.10).true_positives, 5);
        let curve = ranked("tttttfttttftt");
        let point = curve.at_false_fraction(0.10);
        assert_eq!((point.true_positives, point.false_features), (9, 1));
        assert_eq!(curve.true_positives_at(0), 5);
        assert_eq!(curve.true_positives_at(1), 9);
        assert_eq!(curve.true_positives_at(99), 11);
        // A bad start is compensated later.
        let late = ranked("ftttttttttttttttttttt");
        assert_eq!(late.at_false_fraction(0.10).true_positives, 20);
        assert_eq!(Curve::of(&[]).at_false_fraction(0.1).true_positives, 0);
        assert_eq!(mean_curve(&[&curve, &late], 1), [2.5, 14.5]);
    }

    proptest! {
        #[test]
        fn curves_rise_and_end_at_everything(found in proptest::collection::vec((0u8..20, any::<bool>()), 0..60)) {
            let mut judged: Vec<Judged> = found
                .iter()
                .enumerate()
                .map(|(i, &(worth, hit))| Judged { feature: i, worth: f32::from(worth), disc: hit.then_some(i) })
                .collect();
            judged.sort_by(|a, b| b.worth.total_cmp(&a.worth));
            let curve = Curve::of(&judged);
            for pair in curve.points.windows(2) {
                prop_assert!(pair[0].threshold > pair[1].threshold);
                prop_assert!(pair[0].false_features <= pair[1].false_features);
                prop_assert!(pair[0].true_positives <= pair[1].true_positives);
            }
            let hits = found.iter().filter(|(_, hit)| *hit).count();
            prop_assert_eq!(curve.end().true_positives, hits);
            prop_assert_eq!(curve.end().false_features, found.len() - hits);
            let mean = mean_curve(&[&curve], 70);
            prop_assert!(mean.windows(2).all(|w| w[0] <= w[1]));
            prop_assert_eq!(mean[70], hits as f64);
            for fraction in [0.0, 0.1, 0.5, 1.0] {
                let point = curve.at_false_fraction(fraction);
                let all = point.false_features + point.true_positives;
                prop_assert!(point.false_features as f64 <= fraction * all as f64 + 1e-9);
                // No threshold that qualifies finds more.
                for other in &curve.points {
                    let all = other.false_features + other.true_positives;
                    if other.false_features as f64 <= fraction * all as f64 {
                        prop_assert!(other.true_positives <= point.true_positives);
                    }
                }
            }
        }
    }
}
