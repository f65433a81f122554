//! The rule by which a feature finds a disc: features of a chart against its truth, and the curve over the threshold.
//!
//! A feature that [`finds`] no disc, or one that is found already, is false. The orientations of one keypoint
//! count as one feature. Each threshold on a [`Ranking`] gives one point of the curve.

use crate::detector::Feature;
use crate::synth::{FeatureTruth, Truth};
use serde::Serialize;

/// Share of a disc's radius within which a feature must lie.
pub const REACH_IN_RADII: f64 = 0.5;
/// Added to that distance, pixels.
pub const REACH_PIXELS: f64 = 1.5;
/// Largest ratio, either way, of a feature's scale to the disc's.
pub const SCALE_FACTOR: f64 = 2.0;

/// Quantity by which features are ranked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, strum::IntoStaticStr)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Ranking {
    /// Strength, the detector's own order.
    #[default]
    Strength,
    /// Magnitude of the response, |response|.
    Response,
    /// Signal-to-noise ratio. In a burst without noise it is infinite for all, and no threshold tells them apart.
    Snr,
}

impl Ranking {
    /// The value compared with a threshold.
    pub fn worth(self, feature: &Feature) -> f32 {
        match self {
            Self::Strength => feature.strength(),
            Self::Response => feature.response.abs(),
            Self::Snr => feature.snr,
        }
    }
}

/// Whether `feature` finds `disc`: at mid-burst it lies within half the disc's radius plus 1.5 px of the disc's centre,
/// and its scale σ is within a factor of 2 of r/√2.
pub fn finds(feature: &Feature, disc: &FeatureTruth) -> bool {
    is_of_disc([feature.u, feature.v], feature.sigma, disc)
}

pub(super) fn is_of_disc([u, v]: [f32; 2], sigma: f32, disc: &FeatureTruth) -> bool {
    let distance = (f64::from(u) - disc.u).hypot(f64::from(v) - disc.v);
    let ratio = f64::from(sigma) / disc.sigma;
    distance <= REACH_IN_RADII * disc.radius + REACH_PIXELS && (1.0 / SCALE_FACTOR..=SCALE_FACTOR).contains(&ratio)
}

/// Judgement of a feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scored {
    /// Index among the given features.
    pub feature: usize,
    /// Value compared with a threshold.
    pub worth: f32,
    /// Index of the disc in the truth that this feature is the first to find; `None` for a false feature.
    pub disc: Option<usize>,
}

/// Judges `features` against `truth`, strongest first by `ranking` (equal ones in their given order).
pub fn judge(features: &[Feature], truth: &Truth, ranking: Ranking) -> Vec<Scored> {
    judge_by_discs(features, &truth.features, ranking)
}

/// Judges `features` against `discs`, strongest first by `ranking` (equal ones in their given order).
pub fn judge_by_discs(features: &[Feature], discs: &[FeatureTruth], ranking: Ranking) -> Vec<Scored> {
    let mut order: Vec<(usize, f32)> = features.iter().map(|f| ranking.worth(f)).enumerate().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    // Features of one keypoint differ only in their orientation.
    let keypoint = |index: usize| {
        let f = &features[index];
        [f.u, f.v, f.sigma, f.slope.u, f.slope.v, f.response].map(f32::to_bits)
    };
    let mut seen = std::collections::HashSet::with_capacity(features.len());
    order.retain(|&(index, _)| seen.insert(keypoint(index)));
    let mut free = vec![true; discs.len()];
    let distance = |f: &Feature, d: &FeatureTruth| (f64::from(f.u) - d.u).hypot(f64::from(f.v) - d.v);
    order
        .into_iter()
        .map(|(index, worth)| {
            let feature = &features[index];
            let disc = (0..free.len())
                .filter(|&i| free[i] && finds(feature, &discs[i]))
                .min_by(|&a, &b| distance(feature, &discs[a]).total_cmp(&distance(feature, &discs[b])));
            if let Some(disc) = disc {
                free[disc] = false;
            }
            Scored { feature: index, worth, disc }
        })
        .collect()
}

/// Counts at one threshold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurvePoint {
    /// Features of at least this value are kept; infinite (null in JSON) for the first point, which keeps none.
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
    pub fn of(judged: &[Scored]) -> Self {
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

    /// The point with the most discs, then the fewest false features, of those with at most a `fraction` (0 … 1) false.
    pub fn at_false_fraction(&self, fraction: f64) -> CurvePoint {
        let within = |p: &&CurvePoint| {
            // A margin for rounding: 10 of 100 are a tenth.
            p.false_features as f64 <= fraction * (p.false_features + p.true_positives) as f64 + 1e-9
        };
        let worth = |p: &&CurvePoint| (p.true_positives, std::cmp::Reverse(p.false_features));
        *self.points.iter().filter(within).max_by_key(worth).unwrap_or(&self.points[0])
    }

    /// The maximum number of discs found with at most `count` false features.
    pub fn true_positives_at(&self, count: usize) -> usize {
        let beyond = self.points.partition_point(|p| p.false_features <= count);
        self.points[beyond - 1].true_positives
    }

    /// The counts of several charts together, over thresholds that all of them have.
    pub fn pooled(curves: &[&Self]) -> Self {
        let mut thresholds: Vec<f32> = curves.iter().flat_map(|curve| &curve.points).map(|p| p.threshold).collect();
        thresholds.sort_by(|a, b| b.total_cmp(a));
        thresholds.dedup();
        let at = |threshold: f32| {
            let none = CurvePoint { threshold, false_features: 0, true_positives: 0 };
            curves.iter().fold(none, |sum, curve| {
                let kept = curve.points.partition_point(|p| p.threshold >= threshold);
                let point = curve.points[kept - 1];
                let false_features = sum.false_features + point.false_features;
                let true_positives = sum.true_positives + point.true_positives;
                CurvePoint { threshold, false_features, true_positives }
            })
        };
        Self { points: thresholds.into_iter().map(at).collect() }
    }

    /// The point that keeps all features.
    pub fn end(&self) -> CurvePoint {
        self.points[self.points.len() - 1]
    }
}

/// The mean over `curves` of the discs found with at most 0, 1, … `most_false` false features. NaN without a curve.
pub fn mean_curve(curves: &[&Curve], most_false: usize) -> Vec<f64> {
    (0..=most_false)
        .map(|count| curves.iter().map(|c| c.true_positives_at(count) as f64).sum::<f64>() / curves.len() as f64)
        .collect()
}
