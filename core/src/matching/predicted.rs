//! Matches predicted by motion: where a feature lies in the other burst, and the best match there.
//!
//! The field of motion gives the inverse depth of each feature ([`crate::detector::field`]), which decides where on its
//! epipolar line a match lies. The sure matches of a pair, which pass the ratio test and agree on a geometry, determine
//! how inverse depths turn into parallax: one number with a known camera, four with an unknown one
//! ([`super::geometry`]). So the place of every feature in the other burst is known to some pixels. Where sure matches
//! and motions contradict each other, the geometry agrees by chance, and the pair is refused.
//!
//! Orientations of one keypoint count as one: they are no rivals of each other, and a pair of places is matched once.

use super::geometry::{Parallax, TwoViewModel};
use super::putative::{Nearest, Predicted, distance_squared};
use super::{Match, MatchSide, params::MatchParams};
use crate::detector::field::depth::{InverseDepth, inverse_depths};
use crate::monitor::{Cancelled, Monitor};
use crate::synth::random::Stream;
use nalgebra::{Matrix4, Vector2, Vector4};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// Maximum ratio among the features at a predicted place, where [`MatchParams::ratio`] is lower.
pub const PREDICTED_RATIO: f32 = 0.9;
/// Half of the length of a predicted place along the epipolar line, pixels, where the motion is certain.
const ALONG_PX: f64 = 24.0;
/// Largest half length, pixels; with less certain motions no place is predicted.
const MOST_ALONG_PX: f64 = 72.0;
/// Standard deviations of the motion that a predicted place reaches.
const REACH_SIGMAS: f64 = 3.0;
/// Distance across the epipolar line, as a part of the max error of sure matches.
const ACROSS: f64 = 0.5;
/// Ratio of two scales from which on they are not of one thing.
const MOST_SCALE_RATIO: f32 = 2.0;
/// Largest distance of the descriptors of a match: an angle of 53°.
const MOST_DISTANCE: f32 = 458.0;
/// Distance from its predicted place, pixels, within which a sure match agrees with its motion.
const AGREEING_PX: f64 = 10.0;
/// Share of the sure matches with known motion that must agree.
const LEAST_AGREEING: f64 = 0.4;
/// Share from which on they agree whatever chance would give: before a wall all motions are alike.
const CLEARLY_AGREEING: f64 = 0.6;
/// Standard deviations of chance by which more must agree than with motions of other places.
const BEYOND_CHANCE: f64 = 2.0;
/// Number of times that the motions are given to other places to learn what chance gives.
const SHUFFLES: usize = 4;
/// Maximum number of sure matches that decide on the parallax.
const MOST_KNOWN: usize = 200;
/// Fewest sure matches with known motion that determine the parallax.
const FEWEST_KNOWN: usize = 8;
/// Maximum number of samples of matches from which the parallax is found.
const MOST_SAMPLES: usize = 400;
const REFINEMENTS: usize = 4;
const OUTLINE_POINTS: usize = 48;

/// Place where a feature is expected in the other image: a rectangle along the epipolar line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Expected {
    /// (u, v), pixels of a camera without distortion.
    pub place: [f64; 2],
    /// Unit vector along the epipolar line.
    pub along: [f64; 2],
    /// Half of the band's length along the epipolar line, pixels.
    pub half_along_px: f64,
    /// Half of its width across it, pixels.
    pub half_across_px: f64,
}

impl Expected {
    /// Ellipse about the place, as points (u, v) of image B, in which it is expected.
    pub fn outline(&self, model: &TwoViewModel) -> Vec<[f64; 2]> {
        let [x, y] = self.along;
        let point = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / OUTLINE_POINTS as f64).sin_cos();
            let (along, across) = (cos * self.half_along_px, sin * self.half_across_px);
            model.seen_in_b([self.place[0] + along * x - across * y, self.place[1] + along * y + across * x])
        };
        (0..=OUTLINE_POINTS).map(point).collect()
    }

    pub(crate) fn holds(&self, place: [f64; 2]) -> bool {
        let off = Vector2::from(place) - Vector2::from(self.place);
        let along = Vector2::from(self.along);
        off.dot(&along).abs() <= self.half_along_px && off.perp(&along).abs() <= self.half_across_px
    }
}

/// Agreement of a pair's sure matches with the motions of their places, in one image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// Number of sure matches whose motion is known, of those that were looked at.
    pub known: usize,
    /// Number of those near their predicted place.
    pub agreeing: usize,
    /// Mean number that would be if the motions were those of other places.
    pub by_chance: f64,
}

/// Prediction of a pair's matches.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Agreement of the motions of A, and of B.
    pub agreement: [Agreement; 2],
    /// Expected place in B of each feature of A; `None` where its motion is unknown or the place lies nowhere.
    pub in_b: Vec<Option<Expected>>,
    /// Expected place in A of each feature of B.
    pub in_a: Vec<Option<Expected>>,
}

impl Prediction {
    /// Predicts the matches of a pair with sure matches `inliers` of `model`; `None` if few motions are known.
    pub fn of(
        [a, b]: [MatchSide<'_>; 2],
        model: &TwoViewModel,
        inliers: &[(usize, usize)],
        params: &MatchParams,
    ) -> Option<Self> {
        let places: Vec<([f64; 2], [f64; 2])> = inliers.iter().map(|&(i, j)| (a.places[i], b.places[j])).collect();
        let [forward, backward] = Parallax::of(model, &places)?;
        let across = ACROSS * f64::from(params.max_error_px);
        let (to_b, to_a) = inliers.iter().map(|&(i, j)| ((i, b.places[j]), (j, a.places[i]))).unzip();
        // Both ways: motions of one burst may be right and those of the other not.
        let (of_a, in_b) = one_way(&forward, a, to_b, across, params.seed)?;
        let (of_b, in_a) = one_way(&backward, b, to_a, across, params.seed)?;
        Some(Self { agreement: [of_a, of_b], in_b, in_a })
    }

    /// Whether motions and sure matches agree as they do in one scene.
    pub fn is_believed(&self) -> bool {
        self.agreement.iter().all(|&Agreement { known, agreeing, by_chance }| {
            let (known, agreeing) = (known as f64, agreeing as f64);
            let share = by_chance / known;
            let beyond = by_chance + BEYOND_CHANCE * (known * share * (1.0 - share)).max(1.0).sqrt();
            agreeing >= CLEARLY_AGREEING * known || (agreeing >= LEAST_AGREEING * known && agreeing >= beyond)
        })
    }
}

#[derive(Clone, Copy)]
struct SureMatch {
    x: Vector2<f64>,
    there: Vector2<f64>,
    /// Inverse depth, and the place: u and v in thousands of pixels, and 1.
    terms: Vector4<f64>,
    kappa: f64,
}

fn terms(x: Vector2<f64>, inverse_depth: f64) -> Vector4<f64> {
    Vector4::new(inverse_depth, x.x / 1000.0, x.y / 1000.0, 1.0)
}

/// Agreement of the motions of `side` with its `inliers` in the other image, and where each feature is expected there.
fn one_way(
    parallax: &Parallax,
    side: MatchSide<'_>,
    inliers: Vec<(usize, [f64; 2])>,
    half_across_px: f64,
    seed: u64,
) -> Option<(Agreement, Vec<Option<Expected>>)> {
    let motions: Vec<_> = side.blobs.iter().map(|blob| (blob.motion, blob.motion_sigma)).collect();
    let depths = inverse_depths(side.places, &motions);
    let straight: Vec<Vector2<f64>> = side.places.iter().map(|place| parallax.straight(0, *place)).collect();
    let known = |(index, there): (usize, [f64; 2])| {
        let depth = depths.get(index).copied().flatten()?;
        let (x, there) = (straight[index], parallax.straight(1, there));
        Some(SureMatch { x, there, terms: terms(x, depth.value), kappa: parallax.parallax(x, there)? })
    };
    let all: Vec<SureMatch> = inliers.into_iter().filter_map(known).collect();
    if all.len() < FEWEST_KNOWN {
        return None;
    }
    // Evenly thinned out, so that all parts of the image decide.
    let mut known: Vec<SureMatch> = all.iter().copied().step_by(all.len().div_ceil(MOST_KNOWN)).collect();
    let agreeing = |known: &[SureMatch], numbers: &Vector4<f64>| {
        known.iter().filter(|known| miss(parallax, known, numbers) < AGREEING_PX).count()
    };
    let factors = numbers(parallax, &known, seed)?;
    let mut agreement = Agreement { known: known.len(), agreeing: agreeing(&known, &factors), by_chance: 0.0 };
    let mut random = Stream::new(seed, 1);
    for _ in 0..SHUFFLES {
        // By chance: the inverse depths of other places, fitted in the same way.
        for i in (1..known.len()).rev() {
            let j = random.below(i + 1);
            (known[i].terms[0], known[j].terms[0]) = (known[j].terms[0], known[i].terms[0]);
        }
        let by_chance = numbers(parallax, &known, seed).map_or(0, |numbers| agreeing(&known, &numbers));
        agreement.by_chance += by_chance as f64 / SHUFFLES as f64;
    }
    let expected = |(x, depth): (&Vector2<f64>, &Option<InverseDepth>)| {
        let depth = depth.as_ref()?;
        let there = parallax.transferred(*x, factors.dot(&terms(*x, depth.value)))?;
        let px_by_depth = there.by_parallax * factors[0];
        let along = px_by_depth.try_normalize(0.0)?;
        let half_along_px = (REACH_SIGMAS * depth.sigma * px_by_depth.norm()).max(ALONG_PX);
        let (place, along) = (there.place.into(), along.into());
        (half_along_px <= MOST_ALONG_PX).then_some(Expected { place, along, half_along_px, half_across_px })
    };
    Some((agreement, straight.iter().zip(&depths).map(expected).collect()))
}

fn miss(parallax: &Parallax, known: &SureMatch, numbers: &Vector4<f64>) -> f64 {
    let there = parallax.transferred(known.x, numbers.dot(&known.terms));
    there.map_or(f64::INFINITY, |there| (there.place - known.there).norm())
}

/// Factors of [`SureMatch::terms`]: the parallax for an inverse depth of 1, and that of a plane.
fn numbers(parallax: &Parallax, known: &[SureMatch], seed: u64) -> Option<Vector4<f64>> {
    let weight = |numbers: &Vector4<f64>, known: &SureMatch| {
        1.0 / (1.0 + (miss(parallax, known, numbers) / (0.5 * AGREEING_PX)).powi(2))
    };
    let score = |numbers: &Vector4<f64>| known.iter().map(|known| weight(numbers, known)).sum::<f64>();
    let scored = samples(parallax.cameras.is_some(), known, seed).into_iter().map(|numbers| (score(&numbers), numbers));
    let mut best = scored.reduce(|best, other| if other.0 > best.0 { other } else { best })?;
    // Reweighted least squares from the best sample, as long as the score rises.
    for _ in 0..REFINEMENTS {
        let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for known in known {
            let Some(there) = parallax.transferred(known.x, best.1.dot(&known.terms)) else { continue };
            // The error of κ in pixels; matches far off hardly count.
            let weight = there.by_parallax.norm_squared() * weight(&best.1, known).powi(2);
            normal += known.terms * known.terms.transpose() * weight;
            right += known.terms * (weight * known.kappa);
        }
        // A known camera leaves one factor to be found.
        let refined = if parallax.cameras.is_some() {
            Some(Vector4::new(right[0] / normal[(0, 0)], 0.0, 0.0, 0.0))
        } else {
            normal.cholesky().map(|normal| normal.solve(&right))
        };
        let Some(refined) = refined.filter(|refined| refined.iter().all(|x| x.is_finite())) else { break };
        let score = score(&refined);
        if score <= best.0 {
            break;
        }
        best = (score, refined);
    }
    Some(best.1)
}

fn samples(is_calibrated: bool, known: &[SureMatch], seed: u64) -> Vec<Vector4<f64>> {
    if is_calibrated {
        // What is before both cameras has a positive parallax for a positive depth.
        let of_one = |known: &SureMatch| known.kappa / known.terms[0];
        let step = known.len().div_ceil(MOST_SAMPLES);
        let factors = known.iter().step_by(step).map(of_one).filter(|factor| *factor > 0.0 && factor.is_finite());
        return factors.map(|factor| Vector4::new(factor, 0.0, 0.0, 0.0)).collect();
    }
    let mut random = Stream::new(seed, 0);
    let sample = |_| {
        let chosen: [&SureMatch; 4] = std::array::from_fn(|_| &known[random.below(known.len())]);
        let matrix = Matrix4::from_rows(&chosen.map(|known| known.terms.transpose()));
        let kappas = Vector4::from(chosen.map(|known| known.kappa));
        matrix.lu().solve(&kappas).filter(|numbers| numbers.iter().all(|x| x.is_finite()))
    };
    (0..MOST_SAMPLES).filter_map(sample).collect()
}

/// Finds the matches at the places of `prediction`, in the order of A's features: nearest there, with a ratio of at
/// most [`PREDICTED_RATIO`] to the nearest at another place, and, with the mutual check, both ways. Features without a
/// predicted place keep their `sure` match, as do those that do not agree with `model`.
pub(super) fn predicted_matches(
    [a, b]: [MatchSide<'_>; 2],
    (model, sure): (&TwoViewModel, &[Match]),
    prediction: &Prediction,
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<Vec<Match>, Cancelled> {
    let in_b = candidates([a, b], model, prediction);
    let mut in_a: Vec<Vec<u32>> = vec![Vec::new(); b.places.len()];
    for (i, others) in in_b.iter().enumerate() {
        others.iter().for_each(|&j| in_a[j as usize].push(i as u32));
    }
    let of_a = nearest_among(a, b, &in_b, monitor)?;
    let of_b = params.mutual.then(|| nearest_among(b, a, &in_a, monitor)).transpose()?;
    let back = of_b.as_ref().map(|of_b| move |b: usize| of_b[b]);
    let limit = params.ratio.max(PREDICTED_RATIO);
    // Orientations of a place repeat its matches: the best of each pair of places stays.
    let mut best: BTreeMap<[u64; 4], Match> = BTreeMap::new();
    let found = of_a.iter().enumerate().filter_map(|(a, nearest)| nearest.as_ref()?.matched(a, back));
    for found in found.filter(|found| found.rank() <= limit && found.distance <= MOST_DISTANCE) {
        let ([au, av], [bu, bv]) = (a.places[found.a], b.places[found.b]);
        let there: BTreeSet<_> = in_b[found.a].iter().map(|&j| b.places[j as usize].map(f64::to_bits)).collect();
        let found = Match { predicted: Some(Predicted { among: there.len(), ratio_among_all: None }), ..found };
        let of_places = best.entry([au, av, bu, bv].map(f64::to_bits)).or_insert(found);
        if found.rank() < of_places.rank() {
            *of_places = found;
        }
    }
    let mut matches: Vec<Match> = best.into_values().collect();
    // A feature without known motion keeps its sure match, and so does an outlier, to be shown as one.
    let [of_a, of_b]: [BTreeSet<usize>; 2] =
        [matches.iter().map(|m| m.a).collect(), matches.iter().map(|m| m.b).collect()];
    let is_kept = |m: &&Match| {
        let is_free = !of_a.contains(&m.a) && !of_b.contains(&m.b);
        let is_unknown = prediction.in_b[m.a].is_none() && prediction.in_a[m.b].is_none();
        is_free && (is_unknown || model.error_px(a.places[m.a], b.places[m.b]) > f64::from(params.max_error_px))
    };
    matches.extend(sure.iter().filter(is_kept));
    matches.sort_by_key(|m| m.a);
    Ok(matches)
}

/// For each feature of A those of B that it is compared with.
fn candidates([a, b]: [MatchSide<'_>; 2], model: &TwoViewModel, prediction: &Prediction) -> Vec<Vec<u32>> {
    let straight = |side: MatchSide<'_>, image| -> Vec<Vector2<f64>> {
        side.places.iter().map(|place| Vector2::from(model.straight(image, *place))).collect()
    };
    let (places_a, places_b) = (straight(a, 0), straight(b, 1));
    // Sorted from left to right, so that few features are compared with each place.
    let mut order: Vec<u32> = (0..places_b.len() as u32).collect();
    order.sort_by(|&i, &j| places_b[i as usize].x.total_cmp(&places_b[j as usize].x).then(i.cmp(&j)));
    let is_of_scale = |i: usize, j: usize| {
        let (one, other) = (a.blobs[i].sigma, b.blobs[j].sigma);
        one <= MOST_SCALE_RATIO * other && other <= MOST_SCALE_RATIO * one
    };
    let of_one = |(i, expected): (usize, &Option<Expected>)| {
        let Some(expected) = expected else { return Vec::new() };
        // The line may have any direction: along the columns the area reaches no further than this.
        let reach = expected.half_along_px + expected.half_across_px;
        let from = order.partition_point(|&j| places_b[j as usize].x < expected.place[0] - reach);
        let near = order[from..].iter().take_while(|&&j| places_b[j as usize].x <= expected.place[0] + reach);
        let is_it = |j: usize| {
            let agrees_back = prediction.in_a[j].is_none_or(|back| back.holds(places_a[i].into()));
            expected.holds(places_b[j].into()) && agrees_back && is_of_scale(i, j)
        };
        let mut others: Vec<u32> = near.copied().filter(|&j| is_it(j as usize)).collect();
        // Of equal descriptors the first counts, as in the search among all.
        others.sort_unstable();
        others
    };
    prediction.in_b.par_iter().enumerate().map(of_one).collect()
}

/// For each feature of `from` the nearest one of `to` among its `candidates`, and the nearest one at another place.
fn nearest_among(
    from: MatchSide<'_>,
    to: MatchSide<'_>,
    candidates: &[Vec<u32>],
    monitor: &Monitor,
) -> Result<Vec<Option<Nearest>>, Cancelled> {
    let nearest = |(index, others): (usize, &Vec<u32>)| {
        monitor.check()?;
        let mut best: Option<Nearest> = None;
        for other in others.iter().map(|other| *other as usize) {
            let distance_squared = distance_squared(&from.descriptors[index], &to.descriptors[other]);
            let found = Nearest { index: other, distance_squared, second_distance_squared: None };
            let Some(old) = best else {
                best = Some(found);
                continue;
            };
            let [near, far] = if distance_squared < old.distance_squared { [found, old] } else { [old, found] };
            // Orientations of one place are no rivals: the second nearest must lie elsewhere.
            let rival = (to.places[old.index] != to.places[other]).then_some(far.distance_squared);
            let second_distance_squared = [old.second_distance_squared, rival].into_iter().flatten().min();
            best = Some(Nearest { second_distance_squared, ..near });
        }
        Ok(best)
    };
    candidates.par_iter().enumerate().with_min_len(32).map(nearest).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::detector::{Descriptor, Slope, memory::on_threads};
    use crate::matching::geometry::tests::{camera, places_in_space};
    use crate::matching::{Blob, Geometry, MatchResult, match_pair};

    #[derive(Clone, Default)]
    pub struct Features {
        pub places: Vec<[f64; 2]>,
        pub descriptors: Vec<Descriptor>,
        pub blobs: Vec<Blob>,
    }

    impl Features {
        pub fn side(&self) -> MatchSide<'_> {
            MatchSide { places: &self.places, descriptors: &self.descriptors, blobs: &self.blobs, pictures: None }
        }
    }

    const MOTION_SIGMA: f64 = 0.05;

    fn blob(random: &mut Stream, inverse_depth: f64) -> Blob {
        let speed = 8.0 * inverse_depth + MOTION_SIGMA * random.normal();
        let slope = Slope::new(speed as f32, 0.0);
        Blob { sigma: 3.0, orientation: 0.0, slope, motion: slope, motion_sigma: MOTION_SIGMA as f32 }
    }

    pub fn near(random: &mut Stream, around: &Descriptor, by: f64) -> Descriptor {
        around.map(|x| (f64::from(x) + random.within(-by, by)).clamp(0.0, 255.0) as u8)
    }

    /// A scene of `count` points in both images with noisy, often alike descriptors, and `others` in each image alone.
    fn noisy_pair(seed: u64, count: usize, others: usize) -> [Features; 2] {
        let mut random = Stream::new(seed, 1);
        let kinds: Vec<Descriptor> = (0..8).map(|_| std::array::from_fn(|_| random.within(20.0, 70.0) as u8)).collect();
        let [mut a, mut b] = [Features::default(), Features::default()];
        for seen in places_in_space(&mut random, count) {
            let kind = random.within(0.0, 8.0) as usize;
            let own = near(&mut random, &kinds[kind], 20.0);
            for (side, (place, inverse_depth)) in [&mut a, &mut b].into_iter().zip(seen) {
                side.places.push(place);
                side.descriptors.push(near(&mut random, &own, 17.0));
                side.blobs.push(blob(&mut random, inverse_depth));
            }
        }
        for side in [&mut a, &mut b] {
            for _ in 0..others {
                side.places.push([random.within(0.0, 639.0), random.within(0.0, 479.0)]);
                let kind = random.within(0.0, 8.0) as usize;
                side.descriptors.push(near(&mut random, &kinds[kind], 26.0));
                let inverse_depth = random.within(0.1, 0.35);
                side.blobs.push(blob(&mut random, inverse_depth));
            }
        }
        [a, b]
    }

    fn params(geometry: Geometry) -> MatchParams {
        let camera = (geometry == Geometry::Essential).then(camera);
        MatchParams { geometry, camera, align: false, ..MatchParams::default() }
    }

    fn matched([a, b]: &[Features; 2], params: &MatchParams) -> MatchResult {
        match_pair([a.side(), b.side()], params, &Monitor::default()).expect("valid parameters")
    }

    /// The right inliers, and all: the first `count` features of both images belong together.
    fn judged(result: &MatchResult, count: usize) -> (usize, usize) {
        let inlier = &result.verification.as_ref().expect("verified").inlier;
        let inliers = || result.matches.iter().zip(inlier).filter(|(_, inlier)| **inlier).map(|(m, _)| m);
        (inliers().filter(|m| m.a == m.b && m.a < count).count(), inliers().count())
    }

    #[test]
    fn motions_find_what_the_ratio_test_lost() {
        let pair = noisy_pair(5, 600, 600);
        for geometry in [Geometry::Essential, Geometry::Fundamental] {
            let params = params(geometry);
            let sure = judged(&matched(&pair, &MatchParams { predict: false, ..params.clone() }), 600);
            let result = matched(&pair, &params);
            let (right, all) = judged(&result, 600);
            assert!(10 * right >= 12 * sure.0 && sure.0 > 100, "{geometry:?}: {sure:?}, {right} of {all}");
            assert!(right * 10 > all * 9, "{geometry:?}: {right} of {all} are right");
            let prediction = result.prediction.as_ref().expect("predicted");
            let off = |i: usize| {
                let expected = prediction.in_b[i].expect("known");
                Vector2::from([expected.place[0] - pair[1].places[i][0], expected.place[1] - pair[1].places[i][1]])
            };
            let close = (0..600).filter(|i| off(*i).norm() < 10.0).count();
            assert!(close > 560, "{geometry:?}: {close} of 600 are where they are expected");
            let unique = |of: fn(&Match) -> usize| result.matches.iter().map(of).collect::<BTreeSet<_>>().len();
            assert_eq!((unique(|m| m.a), unique(|m| m.b)), (result.matches.len(), result.matches.len()));
            assert!(result.matches.is_sorted_by_key(|m| m.a));
            // From B to A as from A to B.
            let [a, b] = pair.clone();
            let (back, of_back) = judged(&matched(&[b, a], &params), 600);
            assert!(back.abs_diff(right) * 50 <= right && of_back.abs_diff(all) * 30 <= all, "{back} of {of_back}");
        }
    }

    #[test]
    fn orientations_of_one_place_count_once() {
        let pair = noisy_pair(5, 300, 0);
        let twice = |of: &Features| {
            let turned = of.descriptors.iter().map(|d| d.map(|x| x.saturating_add(1)));
            let descriptors = of.descriptors.iter().copied().chain(turned).collect();
            Features { places: of.places.repeat(2), descriptors, blobs: of.blobs.repeat(2) }
        };
        let params = MatchParams { ratio: 1.0, ..params(Geometry::Fundamental) };
        let result = matched(&pair, &params);
        let (model, prediction) = (result.verification.and_then(|v| v.model), result.prediction.expect("predicted"));
        let model = model.expect("a model");
        let found = |[a, b]: [&Features; 2], prediction: &Prediction| {
            let sides = [a.side(), b.side()];
            predicted_matches(sides, (&model, &[]), prediction, &params, &Monitor::default()).expect("done")
        };
        let once = found([&pair[0], &pair[1]], &prediction);
        let repeated = Prediction { in_a: prediction.in_a.repeat(2), in_b: prediction.in_b.repeat(2), ..prediction };
        let both = found([&twice(&pair[0]), &twice(&pair[1])], &repeated);
        assert!(once.len() > 200, "{}", once.len());
        let places = |matches: &[Match]| matches.iter().map(|m| (m.a % 300, m.b % 300)).collect::<BTreeSet<_>>();
        assert_eq!(places(&both).len(), both.len());
        let same = places(&once).intersection(&places(&both)).count();
        assert!(same * 10 > once.len() * 9, "{same} of {}", once.len());
    }

    #[test]
    fn without_motions_the_sure_matches_stay_and_threads_change_nothing() {
        let mut pair = noisy_pair(7, 300, 300);
        let params = params(Geometry::Essential);
        let with = |threads| on_threads(threads, || matched(&pair, &params));
        assert_eq!(with(1), with(2));
        pair.iter_mut().for_each(|side| side.blobs.clear());
        let sure = MatchParams { predict: false, ..params.clone() };
        assert_eq!(matched(&pair, &params), matched(&pair, &sure));
    }
}
