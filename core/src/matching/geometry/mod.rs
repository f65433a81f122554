//! Geometric verification: finds the putative matches that agree on one geometry of the two views.
//!
//! The data flow: matched points → `points` (normalised coordinates) → samples that are solved exactly (`fundamental`,
//! `essential`, `homography`) and scored against all matches (`consensus`, `loss`, `sampling`) → a [`TwoViewModel`] in
//! pixels, each match's error under it, and the inliers. [`verify`] is the composition. [`pose`] turns an essential
//! matrix into the relative pose of the cameras.
//!
//! No library is used: none of the maintained estimators for Rust has the improvements made since RANSAC (local
//! optimisation, marginal cost, degenerate samples), and bindings to C++ would need its toolchain.

mod consensus;
mod essential;
mod fundamental;
mod homography;
mod linear;
mod loss;
mod model;
mod points;
mod polynomial;
pub mod pose;
mod sampling;
#[cfg(test)]
mod tests;

pub use model::TwoViewModel;
pub use pose::RelativePose;

use super::MatchError;
use super::camera::Camera;
use super::params::{Geometry, MatchParams};
use crate::monitor::{Cancelled, Monitor};
use consensus::{Consensus, Settings, estimate};
use points::{Normalisation, RayPair};

/// Geometry that most of the matches agree on.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// The geometry; `None` where fewer than [`MatchParams::min_inliers`] matches agree on any.
    pub model: Option<TwoViewModel>,
    /// For each match whether it is an inlier: its error is at most [`MatchParams::max_error_px`]. All are false
    /// without a model.
    pub inlier: Vec<bool>,
    /// For each match its error in pixels, see [`TwoViewModel::error_px`]; infinite where that is undefined, and
    /// without a model.
    pub error_px: Vec<f32>,
    /// Number of samples drawn.
    pub iterations: usize,
}

impl Verification {
    /// Number of inliers.
    pub fn inlier_count(&self) -> usize {
        self.inlier.iter().filter(|inlier| **inlier).count()
    }
}

/// Matched pair of points, the input of [`verify`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointPair {
    /// (u, v) in image A, pixels.
    pub a: [f64; 2],
    /// (u, v) in image B, pixels.
    pub b: [f64; 2],
    /// Rank of the match; small ranks are tried first. [`super::Match::ratio`] is a good choice.
    pub rank: f32,
}

/// Finds the geometry that most of `pairs` agree on; `None` where [`MatchParams::geometry`] is none. Both images are
/// from [`MatchParams::camera`].
///
/// # Errors
/// [`MatchError::Param`] for parameters that make no sense, [`MatchError::Cancelled`] once `monitor` was cancelled.
pub fn verify(
    pairs: &[PointPair],
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<Option<Verification>, MatchError> {
    params.validate()?;
    let points: Vec<RayPair> = pairs.iter().map(|p| RayPair { a: p.a, b: p.b }).collect();
    let mut order: Vec<usize> = (0..pairs.len()).collect();
    order.sort_by(|&i, &j| pairs[i].rank.total_cmp(&pairs[j].rank));
    let (model, iterations) = match (params.geometry, &params.camera) {
        (Geometry::None, _) => return Ok(None),
        (Geometry::Fundamental, _) => fundamental_of(&points, order, params, monitor)?,
        (Geometry::Homography, _) => homography_of(&points, order, params, monitor)?,
        (Geometry::Essential, Some(camera)) => essential_of(&points, order, camera, params, monitor)?,
        (Geometry::Essential, None) => unreachable!("validation asks for the camera"),
    };
    Ok(Some(judge(pairs, model, iterations, params)))
}

/// Counts the inliers of a model, and drops the model if they are too few.
fn judge(pairs: &[PointPair], model: Option<TwoViewModel>, iterations: usize, params: &MatchParams) -> Verification {
    let none = || Verification {
        model: None,
        inlier: vec![false; pairs.len()],
        error_px: vec![f32::INFINITY; pairs.len()],
        iterations,
    };
    let Some(model) = model else { return none() };
    let error_px: Vec<f32> = pairs.iter().map(|pair| model.error_px(pair.a, pair.b) as f32).collect();
    let inlier: Vec<bool> = error_px.iter().map(|&error| error <= params.max_error_px).collect();
    let found = Verification { model: Some(model), inlier, error_px, iterations };
    if found.inlier_count() >= params.min_inliers { found } else { none() }
}

fn settings(params: &MatchParams, units_per_pixel: f64) -> Settings {
    Settings {
        max_error: f64::from(params.max_error_px) * units_per_pixel,
        confidence: f64::from(params.confidence),
        max_iterations: params.max_iterations,
        seed: params.seed,
    }
}

type ModelFound = Result<(Option<TwoViewModel>, usize), Cancelled>;

fn fundamental_of(points: &[RayPair], order: Vec<usize>, params: &MatchParams, monitor: &Monitor) -> ModelFound {
    let normalisation = Normalisation::of(points);
    let normalised: Vec<RayPair> = points.iter().map(|pair| normalisation.apply(pair)).collect();
    let problem = fundamental::FundamentalProblem { pairs: &normalised };
    let Consensus { model, iterations } = estimate(&problem, order, &settings(params, normalisation.scale), monitor)?;
    let in_pixels = |f| TwoViewModel::Fundamental { fundamental: normalisation.fundamental_in_pixels(&f).normalize() };
    Ok((model.map(in_pixels), iterations))
}

fn homography_of(points: &[RayPair], order: Vec<usize>, params: &MatchParams, monitor: &Monitor) -> ModelFound {
    let normalisation = Normalisation::of(points);
    let normalised: Vec<RayPair> = points.iter().map(|pair| normalisation.apply(pair)).collect();
    let problem = homography::HomographyProblem { pairs: &normalised };
    let Consensus { model, iterations } = estimate(&problem, order, &settings(params, normalisation.scale), monitor)?;
    let in_pixels =
        |h: homography::Homography| TwoViewModel::homography(&normalisation.homography_in_pixels(&h.forward));
    Ok((model.and_then(in_pixels), iterations))
}

fn essential_of(
    points: &[RayPair],
    order: Vec<usize>,
    camera: &Camera,
    params: &MatchParams,
    monitor: &Monitor,
) -> ModelFound {
    let directions: Vec<RayPair> =
        points.iter().map(|p| RayPair { a: camera.direction_of(p.a), b: camera.direction_of(p.b) }).collect();
    let focal = camera.focal_px();
    let problem = essential::EssentialProblem { pairs: &directions, focal_a: focal, focal_b: focal };
    let Consensus { model, iterations } = estimate(&problem, order, &settings(params, 1.0), monitor)?;
    let with_camera = |essential| TwoViewModel::Essential { essential, camera: camera.clone() };
    Ok((model.map(with_camera), iterations))
}
