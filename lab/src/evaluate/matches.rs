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
use burstscope_core::dataset::{BurstSide, MatchedPair, PairSource, match_pairs};
use burstscope_core::detect::{Searched, search};
use burstscope_core::detector::{DetectorParams, SearchParams, SlopeGrid};
use burstscope_core::error::{Error, Result};
use burstscope_core::matching::{
    Camera, Geometry, ImageCounts, MatchCounts, MatchParams, MatchResult, PairSelection, TwoViewModel,
};
use burstscope_core::monitor::{Monitor, Stage};
use nalgebra::{Isometry3, Point3, Vector3};
use serde::Serialize;

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
                let result = pair.aligned(&self.matching, &silent)?;
                let index = pairs.binary_search(&pair.indices).expect("it is one of the pairs, which are in order");
                let model = result.verification.as_ref().and_then(|verified| verified.model.clone());
                let judge = if method == BurstMethod::Gold { model.as_ref() } else { judges[index].as_ref() };
                let on_gold_geometry = judge.map(|judge| self.agreeing(&result, pair.sides, judge));
                let right = judged[index].as_mut().map(|truth: &mut TruePair| truth.right(&result, pair.sides));
                counted[index] = Some(PairCounts { counts: result.counts, on_gold_geometry, right });
                models.push((index, model));
                Ok(())
            };
            let mut source = Source { study: self, method, found: &found, open: &mut open, monitor: &silent };
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
        result.matches.iter().filter(|m| judge.error_px(a.places[m.a], b.places[m.b]) <= max).count()
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

/// True poses of the bursts, and the points of the scene that each sees.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueViews {
    camera: Camera,
    /// The camera of each burst in the world; `None` where it is unknown.
    poses: Vec<Option<Isometry3<f64>>>,
    /// Place in the world of each point of a sparse model, and the bursts that see it.
    points: Vec<(Point3<f64>, Vec<usize>)>,
    right_px: f64,
}

impl TrueViews {
    /// The views of the bursts of these names, from poses and points of `truth`. Right is a match within `right_px` of
    /// true epipolar geometry.
    ///
    /// # Errors
    /// No pose belongs to a burst.
    pub fn of(names: &[String], camera: Camera, truth: &Trajectory, right_px: f64) -> Result<Self> {
        let burst = |(k, name): (usize, &String)| Pose {
            label: name.clone(),
            order: k as u32,
            time: None,
            world_from_camera: Isometry3::identity(),
        };
        let bursts: Vec<Pose> = names.iter().enumerate().map(burst).collect();
        let pairing = associate(&bursts, &truth.poses, None, PoseStudy::default().max_time_difference)?;
        let (mut poses, mut burst_of) = (vec![None; names.len()], vec![None; truth.poses.len()]);
        for (k, pose) in pairing.pairs {
            (poses[k], burst_of[pose]) = (Some(truth.poses[pose].world_from_camera), Some(k));
        }
        let points = truth.model.iter().flat_map(|model| {
            let seen_by = |point| model.seen_by(point).filter_map(|(image, _)| burst_of[image]).collect();
            model.points.iter().map(move |point| (point.position.into(), seen_by(point))).collect::<Vec<_>>()
        });
        Ok(Self { points: points.collect(), camera, poses, right_px })
    }

    fn of_pair(&self, (a, b): (usize, usize)) -> Option<TruePair<'_>> {
        let poses = [self.poses[a]?, self.poses[b]?];
        let b_from_a = poses[1].inv_mul(&poses[0]);
        let essential =
            b_from_a.translation.vector.cross_matrix() * b_from_a.rotation.to_rotation_matrix().into_inner();
        let geometry = TwoViewModel::Essential { essential, cameras: [self.camera.clone(), self.camera.clone()] };
        let (mut angles_deg, mut either) = (Vec::new(), 0);
        for (point, seen_by) in &self.points {
            let seen = [a, b].map(|k| seen_by.contains(&k));
            either += usize::from(seen.contains(&true));
            if seen == [true; 2] {
                let [to_a, to_b] = poses.map(|pose| point.coords - pose.translation.vector);
                angles_deg.push(to_a.angle(&to_b).to_degrees());
            }
        }
        let seen_by_both = (either > 0).then(|| angles_deg.len() as f64 / either as f64);
        Some(TruePair { views: self, geometry, b_from_a, angles_deg, seen_by_both })
    }
}

struct TruePair<'a> {
    views: &'a TrueViews,
    geometry: TwoViewModel,
    b_from_a: Isometry3<f64>,
    /// Angle between the two rays of each point that both see; of each right match where no points are known.
    angles_deg: Vec<f64>,
    seen_by_both: Option<f64>,
}

impl TruePair<'_> {
    /// Number of right inliers, at their aligned places.
    fn right(&mut self, result: &MatchResult, [a, b]: [&BurstSide; 2]) -> usize {
        let Some(verified) = &result.verification else { return 0 };
        let places = result.alignment.as_ref().map_or([&a.places, &b.places], |aligned| aligned.places.each_ref());
        let inliers = result.matches.iter().zip(&verified.inlier).filter(|(_, inlier)| **inlier);
        let inliers = inliers.map(|(m, _)| [places[0][m.a], places[1][m.b]]);
        let right: Vec<_> = inliers.filter(|&[a, b]| self.geometry.error_px(a, b) <= self.views.right_px).collect();
        if self.seen_by_both.is_none() {
            let ray = |place| {
                let [x, y] = self.views.camera.direction_of(place);
                Vector3::new(x, y, 1.0)
            };
            let angle = |&[a, b]: &[[f64; 2]; 2]| (self.b_from_a.rotation * ray(a)).angle(&ray(b)).to_degrees();
            self.angles_deg.extend(right.iter().map(angle).collect::<Vec<_>>());
        }
        right.len()
    }
}

/// Matches judged by true poses.
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
    fn of(right_px: f64, judged: &[Option<TruePair<'_>>], rows: &[MatchRow]) -> Self {
        let of_pair = |pair: &Option<TruePair<'_>>| {
            let Some(TruePair { angles_deg, seen_by_both, .. }) = pair else { return (None, None) };
            let [median] = quantiles(angles_deg.iter().copied(), [0.5]);
            ((!median.is_nan()).then_some(median), *seen_by_both)
        };
        let pairs: Vec<_> = judged.iter().map(of_pair).collect();
        let row = |method: &MatchRow, bin: usize| {
            let (from_deg, to_deg) = (bin.checked_sub(1).map_or(0.0, |k| BINS_DEG[k]), BINS_DEG.get(bin).copied());
            let is_in = |angle: f64| angle >= from_deg && to_deg.is_none_or(|to| angle < to);
            let within: Vec<usize> = (0..pairs.len()).filter(|k| pairs[*k].0.is_some_and(is_in)).collect();
            let counts = || within.iter().map(|k| method.by_pair[*k]);
            let matches = counts().filter_map(|pair| pair.counts.inliers).sum();
            let right = counts().filter_map(|pair| pair.right).sum();
            let seen: Vec<f64> = within.iter().filter_map(|k| pairs[*k].1).collect();
            let share = |of: f64, all: usize| (all > 0).then(|| of / all as f64);
            let (seen_by_both, precision) = (share(seen.iter().sum(), seen.len()), share(right as f64, matches));
            let (method, pairs) = (method.method, within.len());
            AngleRow { method, from_deg, to_deg, pairs, seen_by_both, matches, right, precision }
        };
        let all = rows.iter().flat_map(|method| (0..=BINS_DEG.len()).map(move |bin| row(method, bin)));
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
