//! Geometric verification: finds the putative matches that agree on one geometry of the two views.
//!
//! The data flow of [`verify`]: matched points → `points` (normalised coordinates) → samples that are solved exactly
//! (`linear`, `essential`) and scored against all matches (`consensus`) → a [`TwoViewModel`] in pixels and the inliers.
//!
//! No library is used: none of the maintained estimators for Rust has the improvements made since RANSAC (local
//! optimisation, marginal cost, degenerate samples), and bindings to C++ would need its toolchain.

mod consensus;
mod essential;
mod linear;
mod model;
mod parallax;
mod points;

pub use essential::RelativePose;
pub use model::TwoViewModel;
pub(super) use parallax::Parallax;

use super::params::{Geometry, MatchParams};
use crate::error::Result;
use crate::monitor::{Cancelled, Monitor};
use consensus::estimate;
use linear::Homography;
use nalgebra::Matrix3;
use points::{Normalisation, RayPair};

/// Geometry that most of the matches agree on.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// The geometry; `None` where fewer than [`MatchParams::min_inliers`] matches agree on any.
    pub model: Option<TwoViewModel>,
    /// For each match whether its error is at most [`MatchParams::max_error_px`]; all false without a model.
    pub inlier: Vec<bool>,
    /// For each match its [`TwoViewModel::error_px`]; infinite without a model.
    pub error_px: Vec<f32>,
    /// Number of samples drawn.
    pub iterations: usize,
}

impl Verification {
    /// Withdraws the geometry: no match is an inlier then.
    pub(super) fn refuse(&mut self) {
        self.model = None;
        self.inlier.fill(false);
        self.error_px.fill(f32::INFINITY);
    }

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

/// Finds the geometry on which most of `pairs` agree; `None` for [`Geometry::None`]. `known` is the model of which the
/// pairs were inliers before their places moved; `None` where there was none.
pub fn verify(
    pairs: &[PointPair],
    known: Option<&TwoViewModel>,
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<Option<Verification>> {
    params.validate()?;
    let points: Vec<RayPair> = pairs.iter().map(|p| RayPair { a: p.a, b: p.b }).collect();
    let mut order: Vec<usize> = (0..pairs.len()).collect();
    order.sort_by(|&i, &j| pairs[i].rank.total_cmp(&pairs[j].rank));
    if params.geometry == Geometry::None {
        return Ok(None);
    }
    let (model, iterations) = best_model(&points, order, known.map(TwoViewModel::matrix), params, monitor)?;
    Ok(Some(judge(pairs, model, iterations, params)))
}

fn judge(pairs: &[PointPair], model: Option<TwoViewModel>, iterations: usize, params: &MatchParams) -> Verification {
    let error_px = |p: &PointPair| model.as_ref().map_or(f32::INFINITY, |model| model.error_px(p.a, p.b) as f32);
    let error_px: Vec<f32> = pairs.iter().map(error_px).collect();
    let inlier = error_px.iter().map(|&error| error <= params.max_error_px).collect();
    let mut found = Verification { model, inlier, error_px, iterations };
    if found.model.is_none() || found.inlier_count() < params.min_inliers {
        found.refuse();
    }
    found
}

/// The model on which most of `points` agree, perhaps near one with the matrix `known`, and the number of samples.
fn best_model(
    points: &[RayPair],
    order: Vec<usize>,
    known: Option<&Matrix3<f64>>,
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<(Option<TwoViewModel>, usize), Cancelled> {
    let max_error = f64::from(params.max_error_px);
    let (matrix, iterations) = if let (Geometry::Essential, Some([a, b])) = (params.geometry, params.cameras()) {
        let directions: Vec<RayPair> =
            points.iter().map(|p| RayPair { a: a.direction_of(p.a), b: b.direction_of(p.b) }).collect();
        let focal_px = [a.focal_px(), b.focal_px()];
        let problem = essential::EssentialProblem { pairs: &directions, focal_px };
        estimate(&problem, order, known.copied(), max_error, params, monitor)?
    } else {
        let (Normalisation { scale, to: [to_a, to_b], back: [back_a, back_b] }, pairs) = Normalisation::of(points);
        // One scale for both images, so that an error in pixels is one in normalised coordinates.
        let max_error = max_error * scale;
        if params.geometry == Geometry::Homography {
            let problem = linear::HomographyProblem { pairs: &pairs };
            let known = known.and_then(|h| Homography::oriented(&(to_b * h * back_a), pairs.iter()));
            let (found, iterations) = estimate(&problem, order, known, max_error, params, monitor)?;
            (found.map(|h| back_b * h.forward * to_a), iterations)
        } else {
            let problem = linear::FundamentalProblem { pairs: &pairs };
            let known = known.map(|f| (back_b.transpose() * f * back_a).normalize());
            let (found, iterations) = estimate(&problem, order, known, max_error, params, monitor)?;
            (found.map(|f| (to_b.transpose() * f * to_a).normalize()), iterations)
        }
    };
    Ok((matrix.and_then(|matrix| TwoViewModel::of(matrix, params)), iterations))
}

#[cfg(test)]
pub(in crate::matching) mod tests {
    use super::*;
    use crate::matching::Camera;
    use crate::synth::random::Stream;
    use nalgebra::{Rotation3, Vector3};

    struct Scene {
        pairs: Vec<PointPair>,
        is_true: Vec<bool>,
        camera: Camera,
    }

    const SIZE: (usize, usize) = (640, 480);

    fn pose() -> RelativePose {
        let rotation = Rotation3::from_euler_angles(0.05, -0.12, 0.03).into_inner();
        RelativePose { rotation, translation: Vector3::new(0.9, 0.1, -0.3).normalize() }
    }

    /// `inliers` points seen by a camera that moves by [`pose`], with `sigma` pixels of noise in both images, and
    /// `outliers` pairs of random places. `depth` gives the depth of a point from its direction.
    fn scene(
        random: &mut Stream,
        camera: Camera,
        (inliers, outliers): (usize, usize),
        sigma: f64,
        mut depth: impl FnMut(&mut Stream, [f64; 2]) -> f64,
    ) -> Scene {
        let (pose, mut pairs) = (pose(), Vec::new());
        let inside = |p: [f64; 2]| p[0] > 0.0 && p[1] > 0.0 && p[0] < SIZE.0 as f64 - 1.0 && p[1] < SIZE.1 as f64 - 1.0;
        while pairs.len() < inliers {
            let a = [random.within(0.0, 639.0), random.within(0.0, 479.0)];
            let [x, y] = camera.direction_of(a);
            let there = pose.rotation * (Vector3::new(x, y, 1.0) * depth(random, [x, y])) + pose.translation;
            let b = camera.pixel_of([there.x / there.z, there.y / there.z]);
            if there.z > 0.1 && inside(b) {
                let mut moved = |p: [f64; 2]| p.map(|x| x + sigma * random.normal());
                pairs.push(PointPair { a: moved(a), b: moved(b), rank: 0.0 });
            }
        }
        for _ in 0..outliers {
            let mut place = || [random.within(0.0, 639.0), random.within(0.0, 479.0)];
            pairs.push(PointPair { a: place(), b: place(), rank: 0.0 });
        }
        // Shuffled, so that no order helps.
        let mut is_true: Vec<bool> = (0..pairs.len()).map(|i| i < inliers).collect();
        for i in (1..pairs.len()).rev() {
            let j = random.within(0.0, (i + 1) as f64) as usize;
            pairs.swap(i, j);
            is_true.swap(i, j);
        }
        Scene { pairs, is_true, camera }
    }

    pub(in crate::matching) fn camera() -> Camera {
        Camera::centred(640, 480, 600.0)
    }

    fn in_space(random: &mut Stream, counts: (usize, usize), sigma: f64) -> Scene {
        scene(random, camera(), counts, sigma, |random, _| random.within(3.0, 9.0))
    }

    /// Places and inverse depths in both images of `count` points of a scene in space, without noise.
    pub(in crate::matching) fn places_in_space(random: &mut Stream, count: usize) -> Vec<[([f64; 2], f64); 2]> {
        let pairs = in_space(random, (count, 0), 0.0).pairs;
        let seen = |pair: &PointPair| {
            let directions = RayPair { a: camera().direction_of(pair.a), b: camera().direction_of(pair.b) };
            let (in_a, in_b) = pose().depths(&directions).expect("not parallel");
            [(pair.a, 1.0 / in_a), (pair.b, 1.0 / in_b)]
        };
        pairs.iter().map(seen).collect()
    }

    fn camera_bending() -> Camera {
        "OPENCV 640 480 600 610 322 241 -0.3 0.1 0.001 -0.0005".parse().expect("a camera")
    }

    fn on_a_plane(random: &mut Stream, counts: (usize, usize), sigma: f64) -> Scene {
        let depth = |_: &mut Stream, [x, y]: [f64; 2]| 4.0 / (1.0 + 0.3 * x - 0.2 * y);
        scene(random, camera(), counts, sigma, depth)
    }

    fn params(geometry: Geometry, camera: &Camera) -> MatchParams {
        let camera = (geometry == Geometry::Essential).then(|| camera.clone());
        MatchParams { geometry, max_error_px: 3.0, max_iterations: 100_000, camera, ..MatchParams::default() }
    }

    fn found(scene: &Scene, geometry: Geometry, known: Option<&TwoViewModel>) -> Verification {
        let found = verify(&scene.pairs, known, &params(geometry, &scene.camera), &Monitor::default());
        found.expect("not cancelled").expect("asked for")
    }

    /// (true matches among the inliers, wrong ones among the inliers).
    fn judged(scene: &Scene, found: &Verification) -> (usize, usize) {
        let called = |truth: bool| scene.is_true.iter().zip(&found.inlier).filter(|(t, i)| **t == truth && **i).count();
        (called(true), called(false))
    }

    /// Distance of a place from its possible matches, a line or one place, pixels.
    fn from_locus(place: [f64; 2], locus: &[[f64; 2]]) -> f64 {
        let from_segment = |ends: &[[f64; 2]]| {
            let [p, q, r] = [place, ends[0], ends[1]].map(nalgebra::Vector2::from);
            let (along, to) = (r - q, p - q);
            (to - along * (to.dot(&along) / along.norm_squared()).clamp(0.0, 1.0)).norm()
        };
        let from_first = (place[0] - locus[0][0]).hypot(place[1] - locus[0][1]);
        locus.windows(2).map(from_segment).fold(from_first, f64::min)
    }

    #[test]
    fn exact_scenes_are_recovered_exactly_and_lines_and_places_go_through_the_match() {
        for seed in 0..5 {
            let mut random = Stream::new(0, seed);
            let depth = |random: &mut Stream, _: [f64; 2]| random.within(3.0, 9.0);
            for (scene, geometries, (max_error_px, max_off_px)) in [
                (in_space(&mut random, (60, 0), 0.0), &[Geometry::Fundamental, Geometry::Essential][..], (1e-4, 1e-3)),
                (on_a_plane(&mut random, (60, 0), 0.0), &[Geometry::Essential, Geometry::Homography][..], (1e-4, 1e-3)),
                (scene(&mut random, camera_bending(), (60, 0), 0.0, depth), &[Geometry::Essential][..], (1e-3, 0.1)),
            ] {
                for &geometry in geometries {
                    let found = found(&scene, geometry, None);
                    assert_eq!(judged(&scene, &found), (60, 0), "{geometry:?}");
                    let worst = found.error_px.iter().copied().fold(0.0, f32::max);
                    assert!(worst < max_error_px, "{geometry:?}: {worst} px");
                    let model = found.model.expect("a model");
                    assert!(geometry != Geometry::Homography || model.locus(1, [1e7, 1e7], SIZE).is_empty());
                    for pair in scene.pairs.iter().take(20) {
                        let loci = [model.locus(1, pair.a, SIZE), model.locus(0, pair.b, SIZE)];
                        let off = from_locus(pair.b, &loci[0]).max(from_locus(pair.a, &loci[1]));
                        assert!(off < max_off_px, "{geometry:?}: {pair:?} is {off} px off");
                        // The ends of a line are on the image's border.
                        let is_end =
                            |[u, v]: &[f64; 2]| [u + 0.5, v + 0.5, u - 639.5, v - 479.5].iter().any(|x| x.abs() < 1e-6);
                        let is_line = |locus: &Vec<[f64; 2]>| locus.len() == 2 && locus.iter().all(is_end);
                        assert!(geometry != Geometry::Fundamental || loci.iter().all(is_line), "{loci:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn seventy_of_a_hundred_outliers_are_told_apart() {
        for seed in 0..4 {
            let mut random = Stream::new(0, 100 + seed);
            for geometry in [Geometry::Fundamental, Geometry::Essential, Geometry::Homography] {
                let scene = match geometry {
                    Geometry::Homography => on_a_plane(&mut random, (150, 350), 0.5),
                    _ => in_space(&mut random, (150, 350), 0.5),
                };
                let found = found(&scene, geometry, None);
                let (right, wrong) = judged(&scene, &found);
                // From its own model, less is left to find.
                let again = self::found(&scene, geometry, found.model.as_ref());
                assert!(judged(&scene, &again).0 >= right.min(149) && again.iterations <= found.iterations);
                // By chance a random pair is within 3 px of its epipolar line about once in a hundred.
                let by_chance = if geometry == Geometry::Homography { 1 } else { 14 };
                assert!(right >= 147 && wrong <= by_chance, "{geometry:?}, seed {seed}: {right} right, {wrong} wrong");
            }
        }
    }

    #[test]
    fn half_outliers_leave_the_pose_exact() {
        for seed in 0..5 {
            let mut random = Stream::new(0, 200 + seed);
            let scene = in_space(&mut random, (200, 200), 0.5);
            let found = found(&scene, Geometry::Essential, None);
            let inliers = scene.pairs.iter().zip(&found.inlier).filter(|(_, i)| **i);
            let inliers: Vec<_> = inliers.map(|(p, _)| (p.a, p.b)).collect();
            let (pose, in_front) = found.model.and_then(|m| m.relative_pose(&inliers)).expect("a pose");
            // All true inliers, and of the wrong ones about half.
            assert!(in_front >= 196, "{in_front} of {}", inliers.len());
            let truth = self::pose();
            let turn = pose.rotation.transpose() * truth.rotation;
            let turn_deg = Rotation3::from_matrix_unchecked(turn).angle().to_degrees();
            let shift_deg = pose.translation.angle(&truth.translation).to_degrees();
            assert!(turn_deg < 0.15 && shift_deg < 0.7, "seed {seed}: {turn_deg}°, {shift_deg}°");
        }
    }

    #[test]
    fn planes_fit_an_essential_matrix_as_well_as_the_true_one() {
        // A plane seen twice leaves two poses and a flat valley around each, so only the fit can be compared.
        for seed in 0..5 {
            let mut random = Stream::new(0, 250 + seed);
            let scene = on_a_plane(&mut random, (200, 200), 0.5);
            let params = params(Geometry::Essential, &scene.camera);
            let truth = TwoViewModel::of(pose().essential(), &params).expect("a camera");
            let loss = super::consensus::Loss::new(3.0);
            let cost = |model: &TwoViewModel| -> f64 {
                scene.pairs.iter().map(|p| loss.cost(model.error_px(p.a, p.b).powi(2))).sum()
            };
            let model = found(&scene, Geometry::Essential, None).model.expect("a model");
            assert!(cost(&model) < cost(&truth) + 4.0, "seed {seed}: {} against {}", cost(&model), cost(&truth));
        }
    }

    #[test]
    fn a_dominant_plane_does_not_hide_what_lies_off_it() {
        // Nine of ten true points on one plane: a matrix that fits only the plane would lose the tenth.
        for seed in 0..10 {
            let mut random = Stream::new(0, 300 + seed);
            let depth = |random: &mut Stream, [x, y]: [f64; 2]| {
                if random.within(0.0, 1.0) < 0.9 { 6.0 / (1.0 + 0.3 * x - 0.2 * y) } else { random.within(2.5, 5.0) }
            };
            let scene = scene(&mut random, camera(), (200, 100), 0.3, depth);
            let (right, wrong) = judged(&scene, &found(&scene, Geometry::Fundamental, None));
            assert!(right >= 197 && wrong <= 6, "seed {seed}: {right} right, {wrong} wrong");
        }
    }

    #[test]
    fn errors_are_pixels() {
        // Moving a point across its epipolar line by d moves the pair by d/√2 at least, as both points may give way.
        let mut random = Stream::new(0, 9);
        let scene = in_space(&mut random, (50, 0), 0.0);
        for geometry in [Geometry::Fundamental, Geometry::Essential] {
            let model = found(&scene, geometry, None).model.expect("a model");
            for pair in &scene.pairs {
                let line = model.locus(1, pair.a, SIZE);
                let along = [line[1][0] - line[0][0], line[1][1] - line[0][1]];
                let length = along[0].hypot(along[1]);
                let off = [pair.b[0] - 2.0 * along[1] / length, pair.b[1] + 2.0 * along[0] / length];
                let error = model.error_px(pair.a, off);
                assert!((1.0..2.001).contains(&error), "{geometry:?}: {error}");
            }
        }
        let scene = on_a_plane(&mut random, (50, 0), 0.0);
        let model = found(&scene, Geometry::Homography, None).model.expect("a model");
        let pair = scene.pairs[0];
        let error = model.error_px(pair.a, [pair.b[0] + 2.0, pair.b[1]]);
        assert!((error - 2.0).abs() < 0.4, "{error}: nearly the same distance in both images");
    }
}
