//! Matching between the bursts of a dataset: the columns of the paper's Table 1 that need no reconstruction.
//!
//! Every method finds the features of every burst, with the same parameters and a noise gate of the same rate of false
//! features; the features of chosen pairs of bursts are matched, verified and aligned as usual. As in the paper, an
//! image's matches with all others are added up: each counts for both of its images, and ratios may exceed 1.
//!
//! # The gold standard
//! Where sharp images of the same views are given, SIFT on them is a row of its own, and all rows get a further column:
//! putative matches, at the places where they were found, on the geometry of the *sharp* images' matches. Inliers are
//! counted against a geometry found with the same matches, which favours a method with few matches, because some
//! always agree on some geometry. The further column does not.
//!
//! # The truth
//! Where the [poses are known](TrueViews), inliers are right or wrong, and counted by the angle between the two cameras
//! as seen from the scene: the median over the points that both see of the angle between the two viewing rays.

use super::methods::{BurstMethod, Searches};
use super::poses::{Pose, PoseStudy, Trajectory, associate};
use super::statistics::quantiles;
use burstscope_core::burst::Burst;
use burstscope_core::dataset::{BurstCameras, BurstSide, MatchedPair, PairSource, match_pairs};
use burstscope_core::detect::{Searched, search};
use burstscope_core::detector::{DetectorParams, SearchParams, SlopeGrid};
use burstscope_core::error::{Error, Result};
use burstscope_core::matching::{
    Camera, Geometry, ImageCounts, Match, MatchCounts, MatchParams, MatchResult, PairSelection, TwoViewModel,
};
use burstscope_core::monitor::{Monitor, Stage};
use burstscope_core::plane::Plane;
use nalgebra::{Isometry3, Point3, Vector3};
use serde::Serialize;
use std::collections::BTreeMap;

/// Kind of pictures of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shot {
    /// Burst whose features are compared.
    Burst,
    /// Sharp image; of several the middle one is used.
    Gold,
}

/// Methods to be compared, with the parameters of search and matching.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct MatchStudy {
    /// The rows, each at most once.
    pub methods: Vec<BurstMethod>,
    pub has_gold: bool,
    pub searches: Searches,
    pub matching: MatchParams,
    pub pairs: PairSelection,
    /// Known cameras of single bursts, before that of `matching`.
    pub cameras: BurstCameras,
    /// Truth by which matches are judged.
    pub truth: Option<TrueViews>,
}

/// Features of a burst by one method, with the parameters of their search and the slopes found.
struct FoundInBurst {
    side: BurstSide,
    params: DetectorParams,
    slopes: Option<SlopeGrid>,
}

/// A method's features, and its bursts, opened again where their pictures are needed.
struct Source<'a, F> {
    study: &'a MatchStudy,
    names: &'a [String],
    method: BurstMethod,
    found: &'a [FoundInBurst],
    open: &'a mut F,
    monitor: &'a Monitor,
}

impl<E: From<Error>, F: FnMut(usize, Shot) -> Result<Burst, E>> PairSource<E> for Source<'_, F> {
    fn features(&mut self, index: usize) -> Result<Option<BurstSide>, E> {
        Ok(Some(self.found[index].side.clone()))
    }

    fn burst(&mut self, index: usize) -> Result<(Burst, DetectorParams), E> {
        let (burst, _) = self.study.input(self.method, index, self.open, self.monitor)?;
        Ok((burst, self.found[index].params.clone()))
    }

    fn matching(&self, (a, b): (usize, usize), params: &MatchParams) -> MatchParams {
        let known = |k: usize| self.study.cameras.of_burst(&self.names[k]).known().or(params.camera.as_ref());
        params.with_cameras(known(a), known(b))
    }
}

impl MatchStudy {
    fn check(&self, bursts: usize) -> Result<()> {
        self.matching.validate()?;
        if self.methods.is_empty() {
            let remedy = "give one or more, such as sift-merge,buff-1d";
            return Err(Error::param("methods", "none is given", remedy));
        }
        if self.methods.contains(&BurstMethod::Gold) && !self.has_gold {
            let remedy = "give --gold, or --snr to make noisy bursts of sharp ones; or leave it out";
            return Err(Error::param("methods", "the gold standard needs sharp images", remedy));
        }
        if self.matching.geometry == Geometry::None {
            let remedy = "give fundamental, essential or homography";
            return Err(Error::param("geometry", "inliers are those of a geometry", remedy));
        }
        if matches!(self.pairs, PairSelection::Near(_)) {
            let problem = format!("{} is chosen by features, and each method has its own", self.pairs);
            return Err(Error::param("pairs", problem, "give all or sequential:K"));
        }
        if bursts < 2 {
            let remedy = "name a folder of bursts, or cut a long sequence with --burst-length";
            return Err(Error::param("pairs", format!("{bursts} bursts make no pair"), remedy));
        }
        Ok(())
    }

    /// Finds the features of every burst by every method, matches the pairs, and counts. `open` opens the pictures of
    /// burst k; sharp ones are requested only if there are any. One burst is held in memory at a time.
    ///
    /// # Errors
    /// A parameter that makes no sense, an error of `open`, or cancellation.
    pub fn run<E: From<Error>>(
        &self,
        names: &[String],
        mut open: impl FnMut(usize, Shot) -> Result<Burst, E>,
        monitor: &Monitor,
    ) -> Result<MatchReport, E> {
        self.check(names.len())?;
        let pairs = self.pairs.pairs(names.len());
        // Sharp images come first, even without a row of their own: their geometry judges all rows.
        let others = self.methods.iter().copied().filter(|method| *method != BurstMethod::Gold);
        let methods: Vec<BurstMethod> = self.has_gold.then_some(BurstMethod::Gold).into_iter().chain(others).collect();
        let steps = (names.len() + 1) * methods.len();
        let mut done = 0;
        let mut step = || {
            done += 1;
            monitor.report(Stage::Evaluate, done as f32 / steps as f32);
        };
        let silent = monitor.silent();
        let first = open(0, Shot::Burst)?;
        let (frames, size) = (first.len(), first.size());
        // Filled by the row of the sharp images, which comes first.
        let mut judges: Vec<Option<TwoViewModel>> = vec![None; pairs.len()];
        let mut rows: Vec<MatchRow> = Vec::with_capacity(methods.len());
        let mut judged: Vec<_> = pairs.iter().map(|&pair| self.truth.as_ref()?.of_pair(pair)).collect();
        for &method in &methods {
            let mut found = Vec::with_capacity(names.len());
            // One burst is open at a time.
            for k in 0..names.len() {
                let (burst, params) = self.input(method, k, &mut open, &silent)?;
                let Searched { detection, params, finding, .. } = search(&burst, &params, &silent)?;
                let (side, slopes) = (BurstSide::from(&detection), finding.map(|finding| finding.grid));
                found.push(FoundInBurst { side, params, slopes });
                step();
            }
            let mut counted = vec![None; pairs.len()];
            let mut models = Vec::new();
            let mut on = |pair: MatchedPair<'_>| {
                let result = pair.aligned(&silent)?;
                let index = pairs.binary_search(&pair.indices).expect("it is one of the pairs, which are in order");
                let model = result.verification.as_ref().and_then(|verified| verified.model.clone());
                let judge = if method == BurstMethod::Gold { model.as_ref() } else { judges[index].as_ref() };
                let on_gold_geometry = judge.map(|judge| self.agreeing(&result, pair.sides, judge));
                let right = judged[index].as_mut().map(|truth: &mut TruePair| truth.right(&result, pair.sides));
                counted[index] = Some(PairCounts { counts: result.counts, on_gold_geometry, right });
                models.push((index, model));
                Ok(())
            };
            let mut source = Source { study: self, names, method, found: &found, open: &mut open, monitor: &silent };
            match_pairs(&pairs, &self.matching, &mut source, &mut on, &silent)?;
            if method == BurstMethod::Gold {
                models.into_iter().for_each(|(index, model)| judges[index] = model);
            }
            step();
            let keypoints: Vec<usize> = found.iter().map(|found| found.side.places.len()).collect();
            let by_pair = counted.into_iter().flatten().collect();
            rows.push(row(method, &keypoints, found.into_iter().map(|found| found.slopes).collect(), &pairs, by_pair));
        }
        // Sharp images that only served as judges leave the table; the other rows take the requested order.
        let place = |row: &MatchRow| self.methods.iter().position(|method| *method == row.method);
        rows.retain(|row| place(row).is_some());
        rows.sort_by_key(place);
        let (bursts, searches, matching) = (names.to_vec(), self.searches.clone(), self.matching.clone());
        let truth = self.truth.as_ref().map(|truth| TruthReport::of(truth.right_px, &judged, &rows));
        Ok(MatchReport { methods: rows, bursts, frames, size, pairs, searches, matching, truth })
    }

    /// The burst that `method` searches of the view `k`, and the parameters with which it is searched.
    fn input<E: From<Error>>(
        &self,
        method: BurstMethod,
        k: usize,
        open: &mut impl FnMut(usize, Shot) -> Result<Burst, E>,
        monitor: &Monitor,
    ) -> Result<(Burst, SearchParams), E> {
        let burst = open(k, Shot::Burst)?;
        if method != BurstMethod::Gold {
            return Ok(self.searches.input(method, &burst, monitor)?);
        }
        let (sharp, mut params) = (open(k, Shot::Gold)?, self.searches.params(method));
        if sharp.len() != burst.len() {
            // The requested frames are those of bursts; a sharp image may be the only one.
            params.frames = None;
        }
        Ok((sharp, params))
    }

    /// The number of putative matches within the error limit of `judge`, as they were found.
    fn agreeing(&self, result: &MatchResult, [a, b]: [&BurstSide; 2], judge: &TwoViewModel) -> usize {
        let max = f64::from(self.matching.max_error_px);
        let agrees = |m: &&Match| judge.error_px(a.places[m.a], b.places[m.b]) <= max;
        result.matches.iter().filter(agrees).count()
    }
}

/// Report of a study of matches.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct MatchReport {
    pub bursts: Vec<String>,
    /// Number of frames of the first burst.
    pub frames: usize,
    /// (columns, rows) of its frames.
    pub size: (usize, usize),
    /// Matched pairs, as indices of bursts.
    pub pairs: Vec<(usize, usize)>,
    #[serde(flatten)]
    pub searches: Searches,
    pub matching: MatchParams,
    pub methods: Vec<MatchRow>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<TruthReport>,
}

/// Results of one method. Numbers per image are means; an image's matches are those with all images paired with it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MatchRow {
    /// The method.
    pub method: BurstMethod,
    /// Statistics, as in the paper's table.
    #[serde(flatten)]
    pub counts: ImageCounts,
    /// Putative matches of an image on the geometry of the sharp images; `None` without these.
    pub on_gold_geometry_per_image: Option<f64>,
    /// Slopes found and searched in each burst, where the method finds them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slopes_found: Option<Vec<SlopeGrid>>,
    /// Counts of each pair, in the report's order.
    pub by_pair: Vec<PairCounts>,
}

/// Counts of one pair by one method.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PairCounts {
    /// Counts of the match.
    #[serde(flatten)]
    pub counts: MatchCounts,
    /// Number of putative matches on the geometry of the sharp images; `None` where there is none.
    pub on_gold_geometry: Option<usize>,
    /// Number of right inliers; `None` where no truth is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub right: Option<usize>,
}

/// Angles between the bins of a table by angle, degrees.
const BINS_DEG: [f64; 6] = [6.0, 12.0, 20.0, 30.0, 45.0, 70.0];
/// Distance between the pixels of a map of depths that are points of the scene.
const POINT_STEP: usize = 8;
/// Relative difference of two inverse depths from which one hides the other.
const HIDDEN: f64 = 0.05;

/// True cameras of the bursts, and the points of the scene that each sees.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueViews {
    /// View of each burst; `None` where no pose is known.
    views: Vec<Option<TrueView>>,
    /// Place in the world of each point, and the bursts that see it.
    points: Vec<(Point3<f64>, Vec<usize>)>,
    right_px: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct TrueView {
    camera: Camera,
    world_from_camera: Isometry3<f64>,
    inverse_depth: Option<Plane>,
}

impl TrueViews {
    /// The views of the bursts of these names, from the poses of `truth`. Points are those of its sparse model, or with
    /// `inverse_depths` (at each pixel of each burst, in the unit of the poses) those of these maps. Right is a match
    /// within `right_px` of where the depth puts it, or without depths of its epipolar line.
    ///
    /// # Errors
    /// No pose belongs to a burst, a camera is unknown or its images have another size than a map of depths.
    pub fn of(
        names: &[String],
        cameras: &BurstCameras,
        truth: &Trajectory,
        inverse_depths: &[Plane],
        right_px: f64,
    ) -> Result<Self> {
        let burst = |(k, name): (usize, &String)| {
            let (label, order, world_from_camera) = (name.clone(), k as u32, Isometry3::identity());
            Pose { label, order, time: None, world_from_camera }
        };
        let bursts: Vec<Pose> = names.iter().enumerate().map(burst).collect();
        let pairing = associate(&bursts, &truth.poses, None, PoseStudy::default().max_time_difference)?;
        let mut views = vec![None; names.len()];
        for &(k, pose) in &pairing.pairs {
            let camera = cameras.of_burst(&names[k]).known().cloned().ok_or_else(|| {
                let problem =
                    format!("viewing rays need the camera of each burst, and that of {} is unknown", names[k]);
                Error::param("camera", problem, "give it, or a file camera.toml beside the frames")
            })?;
            let inverse_depth = inverse_depths.get(k).cloned();
            if let Some(size) = inverse_depth.as_ref().map(Plane::size).filter(|s| *s != (camera.width, camera.height))
            {
                let problem = format!("{}×{} for a camera of {}×{}", size.0, size.1, camera.width, camera.height);
                return Err(Error::param("inverse-depth", problem, "give a depth for each pixel of a burst"));
            }
            views[k] = Some(TrueView { camera, world_from_camera: truth.poses[pose].world_from_camera, inverse_depth });
        }
        let burst_of: BTreeMap<usize, usize> = pairing.pairs.iter().map(|&(k, pose)| (pose, k)).collect();
        let points = match &truth.model {
            Some(model) if inverse_depths.is_empty() => {
                let seen_by = |p| model.seen_by(p).filter_map(|(image, _)| burst_of.get(&image).copied()).collect();
                model.points.iter().map(|point| (point.position.into(), seen_by(point))).collect()
            }
            _ => {
                let points = views.iter().flatten().flat_map(TrueView::points);
                let sees =
                    |k: &usize, point: &Point3<f64>| views[*k].as_ref().is_some_and(|view: &TrueView| view.sees(point));
                points.map(|point| (point, (0..views.len()).filter(|k| sees(k, &point)).collect())).collect()
            }
        };
        Ok(Self { views, points, right_px })
    }

    fn of_pair(&self, (a, b): (usize, usize)) -> Option<TruePair> {
        let views = [self.views[a].clone()?, self.views[b].clone()?];
        let mut either = 0;
        let mut angles_deg = Vec::new();
        for (point, seen_by) in &self.points {
            let seen = [a, b].map(|k| seen_by.contains(&k));
            either += usize::from(seen.contains(&true));
            if seen == [true; 2] {
                let [a, b] =
                    views.each_ref().map(|view| point - Point3::from(view.world_from_camera.translation.vector));
                angles_deg.push(a.angle(&b).to_degrees());
            }
        }
        let seen_by_both = (either > 0).then(|| angles_deg.len() as f64 / either as f64);
        let [of_a, of_b] = views.each_ref().map(|view| view.world_from_camera);
        let b_from_a = of_b.inv_mul(&of_a);
        let essential =
            b_from_a.translation.vector.cross_matrix() * b_from_a.rotation.to_rotation_matrix().into_inner();
        let geometry = TwoViewModel::Essential { essential, cameras: views.each_ref().map(|view| view.camera.clone()) };
        Some(TruePair { views, geometry, b_from_a, right_px: self.right_px, angles_deg, seen_by_both })
    }
}

impl TrueView {
    /// The ray through a pixel, z being 1, in the camera.
    fn ray(&self, pixel: [f64; 2]) -> Vector3<f64> {
        let [x, y] = self.camera.direction_of(pixel);
        Vector3::new(x, y, 1.0)
    }

    /// The pixel at which a point in the camera is seen; `None` behind it.
    fn pixel(&self, point: Vector3<f64>) -> Option<[f64; 2]> {
        (point.z > 0.0).then(|| self.camera.pixel_of([point.x / point.z, point.y / point.z]))
    }

    /// Inverse depth at the pixel nearest to a place, where it is known.
    fn inverse_depth_at(&self, place: [f64; 2]) -> Option<f64> {
        let (map, [u, v]) = (self.inverse_depth.as_ref()?, place.map(f64::round));
        let is_inside = u >= 0.0 && v >= 0.0 && u < map.width() as f64 && v < map.height() as f64;
        is_inside.then(|| f64::from(map.at(u as usize, v as usize))).filter(|depth| *depth >= 0.0)
    }

    /// Points of the scene at the pixels of a grid.
    fn points(&self) -> impl Iterator<Item = Point3<f64>> {
        let along = |length: usize| (POINT_STEP / 2..length).step_by(POINT_STEP).map(|x| x as f64);
        let pixels = along(self.camera.height).flat_map(move |v| along(self.camera.width).map(move |u| [u, v]));
        let known =
            pixels.filter_map(|pixel| Some((pixel, self.inverse_depth_at(pixel).filter(|depth| *depth > 0.0)?)));
        known.map(|(pixel, depth)| self.world_from_camera * Point3::from(self.ray(pixel) / depth))
    }

    fn sees(&self, point: &Point3<f64>) -> bool {
        let point = self.world_from_camera.inverse_transform_point(point).coords;
        let depth = self.pixel(point).and_then(|pixel| self.inverse_depth_at(pixel));
        depth.is_some_and(|depth| (depth * point.z - 1.0).abs() < HIDDEN)
    }
}

/// The truth about a pair.
struct TruePair {
    views: [TrueView; 2],
    geometry: TwoViewModel,
    b_from_a: Isometry3<f64>,
    right_px: f64,
    /// Angle between the two rays of each point that both see; of each right match where no points are known.
    angles_deg: Vec<f64>,
    seen_by_both: Option<f64>,
}

impl TruePair {
    /// Number of right inliers, at their aligned places.
    fn right(&mut self, result: &MatchResult, [a, b]: [&BurstSide; 2]) -> usize {
        let Some(verified) = &result.verification else { return 0 };
        let places = result.alignment.as_ref().map_or([&a.places, &b.places], |aligned| aligned.places.each_ref());
        let inliers = result.matches.iter().zip(&verified.inlier).filter(|(_, inlier)| **inlier);
        let inliers = inliers.map(|(m, _)| [places[0][m.a], places[1][m.b]]);
        let right: Vec<_> = inliers.filter(|&[a, b]| self.error_px(a, b) <= self.right_px).collect();
        if self.seen_by_both.is_none() {
            let angle =
                |[a, b]: &[[f64; 2]; 2]| (self.b_from_a.rotation * self.views[0].ray(*a)).angle(&self.views[1].ray(*b));
            let angles: Vec<f64> = right.iter().map(|places| angle(places).to_degrees()).collect();
            self.angles_deg.extend(angles);
        }
        right.len()
    }

    /// Distance of `b` from where the depth at `a` puts it; without depths the pair's distance from epipolar geometry.
    fn error_px(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        let [of_a, of_b] = &self.views;
        let Some(inverse_depth) = of_a.inverse_depth_at(a) else { return self.geometry.error_px(a, b) };
        let there = self.b_from_a.rotation * of_a.ray(a) + self.b_from_a.translation.vector * inverse_depth;
        of_b.pixel(there).map_or(f64::INFINITY, |[u, v]| (u - b[0]).hypot(v - b[1]))
    }
}

/// What the truth says of the matches.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TruthReport {
    /// Largest error of a right match, pixels.
    pub right_px: f64,
    /// Median angle between the rays of each pair, degrees, and the share of the points seen by either that both see.
    pub pairs: Vec<(Option<f64>, Option<f64>)>,
    /// Of each method the matches of the pairs in each bin of angles that has any.
    pub by_angle: Vec<AngleRow>,
}

/// Inliers of one method in the pairs of a bin of angles.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct AngleRow {
    pub method: BurstMethod,
    pub from_deg: f64,
    /// End of the bin; `None` of the last.
    pub to_deg: Option<f64>,
    pub pairs: usize,
    /// Mean share of the points seen by either that both see; `None` where the truth has no points.
    pub seen_by_both: Option<f64>,
    pub matches: usize,
    pub right: usize,
    /// Right matches over matches; `None` without matches.
    pub precision: Option<f64>,
}

impl TruthReport {
    fn of(right_px: f64, judged: &[Option<TruePair>], rows: &[MatchRow]) -> Self {
        let median =
            |pair: &TruePair| Some(quantiles(pair.angles_deg.iter().copied(), [0.5])[0]).filter(|x| !x.is_nan());
        let of_pair =
            |pair: &Option<TruePair>| pair.as_ref().map_or((None, None), |pair| (median(pair), pair.seen_by_both));
        let pairs: Vec<_> = judged.iter().map(of_pair).collect();
        let starts = [0.0].into_iter().chain(BINS_DEG);
        let bins: Vec<(f64, Option<f64>)> = starts.zip(BINS_DEG.map(Some).into_iter().chain([None])).collect();
        let row = |method: &MatchRow, (from_deg, to_deg): (f64, Option<f64>)| {
            let is_in = |angle: f64| angle >= from_deg && to_deg.is_none_or(|to| angle < to);
            let within: Vec<usize> = (0..pairs.len()).filter(|k| pairs[*k].0.is_some_and(is_in)).collect();
            let sum = |count: &dyn Fn(&PairCounts) -> Option<usize>| -> usize {
                within.iter().filter_map(|k| count(&method.by_pair[*k])).sum()
            };
            let (matches, right) = (sum(&|pair| pair.counts.inliers), sum(&|pair| pair.right));
            let shares: Vec<f64> = within.iter().filter_map(|k| pairs[*k].1).collect();
            let share = |of: f64, all: usize| (all > 0).then(|| of / all as f64);
            let (seen_by_both, precision) = (share(shares.iter().sum(), shares.len()), share(right as f64, matches));
            let (method, pairs) = (method.method, within.len());
            AngleRow { method, from_deg, to_deg, pairs, seen_by_both, matches, right, precision }
        };
        let all = rows.iter().flat_map(|method| bins.iter().map(move |bin| row(method, *bin)));
        let by_angle = all.filter(|row| row.pairs > 0).collect();
        Self { right_px, pairs, by_angle }
    }
}

fn row(
    method: BurstMethod,
    keypoints: &[usize],
    slopes_found: Option<Vec<SlopeGrid>>,
    pairs: &[(usize, usize)],
    by_pair: Vec<PairCounts>,
) -> MatchRow {
    let counts: Vec<_> = pairs.iter().zip(&by_pair).map(|(&pair, counted)| (pair, counted.counts)).collect();
    let judged = by_pair.iter().any(|pair| pair.on_gold_geometry.is_some());
    // Each match counts for both images.
    let on_gold = 2 * by_pair.iter().filter_map(|pair| pair.on_gold_geometry).sum::<usize>();
    MatchRow {
        method,
        counts: ImageCounts::of(keypoints, &counts).expect("pairs are matched of images that are there"),
        on_gold_geometry_per_image: judged.then(|| on_gold as f64 / keypoints.len() as f64),
        slopes_found,
        by_pair,
    }
}
