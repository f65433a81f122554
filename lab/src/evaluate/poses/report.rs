//! The comparison of an estimated trajectory with the true one, and its report: the errors of the aligned estimate.
//!
//! Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", IROS 2012. The **absolute trajectory error**
//! of a pose is the distance of its centre from the true one, and the angle between their directions. The **relative
//! pose error** is the length and angle by which the motion from a pose to the one `step` poses later differs from the
//! true motion; unlike the absolute error it does not accumulate along the trajectory.

use super::{Alignment, Association, ModelSummary, Pose, Similarity, Trajectory, align, associate};
use crate::evaluate::statistics::quantiles;
use burstscope_core::error::{Error, Result};
#[cfg(feature = "cli")]
use burstscope_core::synth::options::words;
use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

/// Parameters of a comparison of an estimate with the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct PoseStudy {
    /// Rule that pairs two poses: name, time or order [default: names if both sides have them, else times if all fit,
    /// else order].
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "RULE", value_parser = words::<Association>(&["name", "time", "order"]))
    )]
    pub associate: Option<Association>,
    /// Max difference of the times of a pair, in the files' unit.
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", default_value_t = Self::default().max_time_difference))]
    pub max_time_difference: f64,
    /// Poses between the start and the end of each motion of the relative pose error.
    #[cfg_attr(feature = "cli", arg(long, value_name = "POSES", default_value_t = Self::default().step))]
    pub step: usize,
    /// Number of images that the reconstruction began with [default: the number of true poses].
    #[cfg_attr(feature = "cli", arg(long, value_name = "N"))]
    pub images: Option<usize>,
}

impl Default for PoseStudy {
    fn default() -> Self {
        Self { associate: None, max_time_difference: 0.02, step: 1, images: None }
    }
}

/// A pair of poses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairReport {
    /// Index of the pose in the estimate.
    #[serde(skip)]
    pub estimate: usize,
    /// Index of the pose in the truth.
    #[serde(skip)]
    pub truth: usize,
    /// Label of the pose in the estimate: the image's name or the time.
    pub label: String,
    /// Centre of the true camera, in the truth's unit.
    pub true_centre: [f64; 3],
    /// Centre of the estimated camera after the alignment.
    pub aligned_centre: [f64; 3],
    /// Distance of the two, in the truth's unit.
    pub translation_error: f64,
    /// Angle between the two cameras' directions, degrees.
    pub rotation_error_deg: f64,
}

/// Result of a comparison of trajectories.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct PoseReport {
    /// Number of images to be registered.
    pub images: usize,
    pub registered: usize,
    /// Number of right cameras: within 3 % of the way's extent and 3° of the truth, after the alignment, by two of the
    /// cameras or by all, that makes most of them right. One far off shifts that by all, after which the errors are.
    pub right: usize,
    pub associated: Association,
    /// Scale from the estimate's world to the truth's.
    pub scale: f64,
    /// Similarity from the estimate's world to the truth's.
    #[serde(skip)]
    pub truth_from_estimate: Similarity,
    /// Whether the cameras lie on a straight line, see [`super::align()`].
    pub straight: bool,
    pub absolute: PoseErrors,
    /// Angle by which all cameras are turned alike, each in its own axes, degrees: by a wrong principal point, for one.
    pub common_rotation_deg: f64,
    /// Number of poses from start to end of a motion.
    pub step: usize,
    pub relative: PoseErrors,
    /// Summary of the sparse model; absent if the estimate is none.
    pub model: Option<ModelSummary>,
    pub pairs: Vec<PairReport>,
}

impl PoseReport {
    /// The share of images that were registered, percent.
    pub fn images_pass_percent(&self) -> f64 {
        100.0 * self.registered as f64 / self.images as f64
    }
}

/// Compares `estimate` with `truth`.
///
/// # Errors
/// The study makes no sense, or poses cannot be paired or aligned.
pub fn evaluate_poses(estimate: &Trajectory, truth: &Trajectory, study: &PoseStudy) -> Result<PoseReport> {
    let param = |parameter, problem: String, remedy| Err(Error::param(parameter, problem, remedy));
    if study.step == 0 {
        return param("step", "0 poses".to_owned(), "give 1 or more");
    }
    if !(study.max_time_difference >= 0.0 && study.max_time_difference.is_finite()) {
        return param("max-time-difference", study.max_time_difference.to_string(), "give 0 or more");
    }
    // More poses than images would pass more than 100 %.
    if let Some(images) = study.images.filter(|&images| images < estimate.poses.len()) {
        let problem = format!("{images}, but {} images have a pose", estimate.poses.len());
        return param("images", problem, "give the number of images that the reconstruction began with");
    }
    let pairing = associate(&estimate.poses, &truth.poses, study.associate, study.max_time_difference)?;
    let (estimated, truths): (Vec<Isometry3<f64>>, Vec<Isometry3<f64>>) = pairing
        .pairs
        .iter()
        .map(|&(e, t)| (estimate.poses[e].world_from_camera, truth.poses[t].world_from_camera))
        .unzip();
    let alignment = align(&estimated, &truths)?;
    let Similarity { scale, .. } = alignment.truth_from_estimate;
    // Relative errors need the aligned poses too: only these are in the truth's unit of length.
    let aligned: Vec<Isometry3<f64>> = estimated.iter().map(|e| alignment.truth_from_estimate.apply(e)).collect();
    let left_over = absolute(&aligned, &truths);
    let turns: Vector3<f64> = left_over.iter().map(|error| error.rotation.scaled_axis()).sum();
    let pair = |k: usize| {
        let (translation_error, rotation_error_deg) = magnitudes(&left_over[k]);
        PairReport {
            estimate: pairing.pairs[k].0,
            truth: pairing.pairs[k].1,
            label: estimate.poses[pairing.pairs[k].0].label.clone(),
            true_centre: truths[k].translation.vector.into(),
            aligned_centre: aligned[k].translation.vector.into(),
            translation_error,
            rotation_error_deg,
        }
    };
    Ok(PoseReport {
        images: study.images.unwrap_or(truth.poses.len()),
        registered: estimate.poses.len(),
        right: right_cameras(&estimated, &truths, &truth.poses, alignment),
        associated: pairing.by,
        scale,
        truth_from_estimate: alignment.truth_from_estimate,
        straight: alignment.straight,
        absolute: PoseErrors::of(&left_over),
        common_rotation_deg: (turns / left_over.len() as f64).norm().to_degrees(),
        step: study.step,
        relative: PoseErrors::of(&relative(&aligned, &truths, study.step)),
        model: estimate.model.as_ref().map(|m| m.summary()),
        pairs: (0..pairing.pairs.len()).map(pair).collect(),
    })
}

/// Limits of a right camera: distance from the true one in parts of the way's extent, and angle, degrees.
const RIGHT: (f64, f64) = (0.03, 3.0);
/// Maximum number of cameras, spread evenly, of which any two are tried as the two that align all.
const TRIED: usize = 48;

fn right_cameras(estimated: &[Isometry3<f64>], truths: &[Isometry3<f64>], way: &[Pose], by_all: Alignment) -> usize {
    let centre = |pose: &Pose| pose.world_from_camera.translation.vector;
    let from = |a: &Pose| way.iter().map(|b| (centre(a) - centre(b)).norm()).fold(0.0, f64::max);
    let extent = way.iter().map(from).fold(0.0, f64::max);
    let count = |by: Alignment| {
        let off = estimated.iter().zip(truths);
        let off = off.map(|(e, t)| magnitudes(&by.truth_from_estimate.apply(e).inv_mul(t)));
        off.filter(|(distance, angle)| *distance <= RIGHT.0 * extent && *angle <= RIGHT.1).count()
    };
    let some: Vec<usize> = (0..truths.len()).step_by(truths.len().div_ceil(TRIED).max(1)).collect();
    let pairs = some.iter().enumerate().flat_map(|(k, &i)| some[k + 1..].iter().map(move |&j| [i, j]));
    let by_two = pairs.filter_map(|two| align(&two.map(|k| estimated[k]), &two.map(|k| truths[k])).ok());
    by_two.chain([by_all]).map(count).max().unwrap_or(0)
}

/// Statistics of a set of errors, all in the unit of the errors. Each is NaN (null in JSON) for an empty set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs)] // the names say it
pub struct ErrorSummary {
    pub rmse: f64,
    pub mean: f64,
    pub median: f64,
    pub max: f64,
}

impl ErrorSummary {
    /// Statistics of magnitudes, given in any order.
    pub fn of(magnitudes: &[f64]) -> Self {
        let n = magnitudes.len() as f64;
        let all = || magnitudes.iter().copied();
        Self {
            rmse: (all().map(|x| x * x).sum::<f64>() / n).sqrt(),
            mean: all().sum::<f64>() / n,
            median: quantiles(all(), [0.5])[0],
            max: all().max_by(f64::total_cmp).unwrap_or(f64::NAN),
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
        let [translation, rotation_deg] = [translations, angles].map(|errors| ErrorSummary::of(&errors));
        Self { count: left_over.len(), translation, rotation_deg }
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
