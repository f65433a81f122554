//! Errors of an estimate that is aligned with the truth.
//!
//! Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", IROS 2012. The **absolute trajectory error**
//! of a pose is the distance of its centre from the true one, and the angle between their directions. The **relative
//! pose error** compares motions: from each pose to the one `step` poses later, true and estimated; the motion from one
//! to the other is small, and its length and angle are the error. It does not accumulate along the trajectory, as the
//! absolute one may.

use crate::evaluate::statistics::quantile;
use nalgebra::Isometry3;
use serde::Serialize;

/// Statistics of a set of errors, all in the unit of the errors. Each is NaN (null in JSON) for an empty set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorSummary {
    /// Root mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// Maximum.
    pub max: f64,
}

impl ErrorSummary {
    /// Statistics of magnitudes, given in any order.
    pub fn of(magnitudes: &[f64]) -> Self {
        let n = magnitudes.len() as f64;
        let mut sorted = magnitudes.to_vec();
        sorted.sort_by(f64::total_cmp);
        Self {
            rmse: (magnitudes.iter().map(|x| x * x).sum::<f64>() / n).sqrt(),
            mean: magnitudes.iter().sum::<f64>() / n,
            median: quantile(&sorted, 0.5),
            max: sorted.last().copied().unwrap_or(f64::NAN),
        }
    }
}

/// Errors of poses or motions, in translation and rotation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PoseErrors {
    /// Number of poses or motions.
    pub count: usize,
    /// Distances, in the truth's unit of length.
    pub translation: ErrorSummary,
    /// Angles, degrees.
    pub rotation_deg: ErrorSummary,
}

impl PoseErrors {
    /// Errors from the residual motions.
    pub fn of(left_over: &[Isometry3<f64>]) -> Self {
        let (translations, angles): (Vec<f64>, Vec<f64>) = left_over.iter().map(magnitudes).unzip();
        Self {
            count: left_over.len(),
            translation: ErrorSummary::of(&translations),
            rotation_deg: ErrorSummary::of(&angles),
        }
    }
}

/// Length and angle (degrees, 0 … 180) of a motion.
pub fn magnitudes(motion: &Isometry3<f64>) -> (f64, f64) {
    (motion.translation.vector.norm(), motion.rotation.angle().to_degrees())
}

/// The residual motion of each aligned pose: the true camera seen from the estimated one.
pub fn absolute(aligned: &[Isometry3<f64>], truth: &[Isometry3<f64>]) -> Vec<Isometry3<f64>> {
    aligned.iter().zip(truth).map(|(a, t)| a.inv_mul(t)).collect()
}

/// The residual of each aligned motion over `step` poses; empty where there are not more than `step` poses.
pub fn relative(aligned: &[Isometry3<f64>], truth: &[Isometry3<f64>], step: usize) -> Vec<Isometry3<f64>> {
    let motions = |poses: &[Isometry3<f64>]| -> Vec<Isometry3<f64>> {
        poses.iter().zip(poses.iter().skip(step)).map(|(from, to)| from.inv_mul(to)).collect()
    };
    motions(aligned).iter().zip(motions(truth)).map(|(a, t)| a.inv_mul(&t)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

    fn pose(centre: [f64; 3], about_z: f64) -> Isometry3<f64> {
        Isometry3::new(Vector3::from(centre), Vector3::z() * about_z)
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn summaries_by_hand() {
        let summary = ErrorSummary::of(&[3.0, 1.0, 2.0, 6.0]);
        assert!(near(summary.rmse, 12.5f64.sqrt()) && near(summary.mean, 3.0));
        assert_eq!((summary.median, summary.max), (2.5, 6.0));
        let none = ErrorSummary::of(&[]);
        assert!(none.rmse.is_nan() && none.mean.is_nan() && none.median.is_nan() && none.max.is_nan());
    }

    #[test]
    fn absolute_errors_are_distances_and_angles() {
        let truth = [pose([0.0, 0.0, 0.0], 0.0), pose([1.0, 0.0, 0.0], 0.0)];
        let aligned = [pose([3.0, 4.0, 0.0], 0.0), pose([1.0, 0.0, 0.0], -FRAC_PI_6)];
        let errors = PoseErrors::of(&absolute(&aligned, &truth));
        assert!(near(errors.translation.max, 5.0) && near(errors.translation.rmse, 12.5f64.sqrt()));
        assert!(near(errors.rotation_deg.max, 30.0) && near(errors.rotation_deg.mean, 15.0));
    }

    #[test]
    fn one_false_turn_spoils_one_motion_and_all_places_after_it() {
        // The truth goes one unit along x each time. The estimate turns left once and goes on along y.
        let truth = [0.0, 1.0, 2.0, 3.0].map(|x| pose([x, 0.0, 0.0], 0.0));
        let estimate = [
            pose([0.0, 0.0, 0.0], 0.0),
            pose([1.0, 0.0, 0.0], FRAC_PI_2),
            pose([1.0, 1.0, 0.0], FRAC_PI_2),
            pose([1.0, 2.0, 0.0], FRAC_PI_2),
        ];
        let steps = PoseErrors::of(&relative(&estimate, &truth, 1));
        assert_eq!(steps.count, 3);
        assert!(near(steps.rotation_deg.max, 90.0) && near(steps.rotation_deg.mean, 30.0));
        assert!(near(steps.translation.max, 0.0));
        // Over two poses the first motion ends at (1, 1) in place of (2, 0), the second is a straight one.
        let steps = PoseErrors::of(&relative(&estimate, &truth, 2));
        assert!(steps.count == 2 && near(steps.translation.max, 2.0f64.sqrt()) && near(steps.rotation_deg.mean, 45.0));
        assert!(relative(&estimate, &truth, 4).is_empty());
        let places = PoseErrors::of(&absolute(&estimate, &truth));
        assert!(near(places.translation.max, 8.0f64.sqrt()));
    }
}
