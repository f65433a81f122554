//! Matches made exact: every inlier is measured by the pictures of its two places, and what contradicts goes.
//!
//! [`Pictures`] are the chips of an image's places ([`super::align`]), by which the inliers of each pair are measured
//! ([`measure_inliers`]); from all pairs together [`Alignment`] solves for one place of each keypoint, and
//! [`AlignedImages::confirmed`] estimates each pair's geometry again, at these places and with a smaller error.

use super::align::{Chip, ChipSource, Link, Measured, PairFrame, Places, Solved, View, measure, pair, solve};
use super::geometry::{PointPair, TwoViewModel, Verification, verify};
use super::{Blob, Match, MatchParams, MatchResult, MatchSide, Refusal};
use crate::detector::{DetectorParams, stack::FrameTimes};
use crate::monitor::{Cancelled, Monitor};
use crate::{burst::Burst, error::Result, plane::Plane};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Max error before the alignment, as a part of [`MatchParams::max_error_px`]: places are uncertain.
const WIDE: f32 = 2.0;
/// Max error after it, as a part of [`MatchParams::max_error_px`]; also the largest contradiction with solved places.
pub const NARROW: f32 = 0.35;
const FEWEST_KEPT: usize = 30;
/// Least share of its inliers that a pair keeps: wrong pairs keep less.
const LEAST_KEPT: f64 = 0.25;
/// Largest distance by which a keypoint is moved, pixels. Of matches that would move one farther half are right, and a
/// fifth beyond 50 px. A limit in σ would not help: beyond 3 σ as many are right as below.
pub const MOST_MOVED_PX: f64 = 20.0;

/// Whether a pair of `inliers` may keep its geometry by as many as are `left`.
pub(super) fn keeps_enough(left: usize, inliers: usize) -> bool {
    left >= FEWEST_KEPT.max((LEAST_KEPT * inliers as f64).ceil() as usize)
}

/// Parameters with which predicted matches are verified that are aligned afterwards.
pub(super) fn before_alignment(params: &MatchParams) -> MatchParams {
    MatchParams { max_error_px: WIDE * params.max_error_px, ..params.clone() }
}

/// Pictures of an image's places.
#[derive(Debug, Clone, PartialEq)]
pub struct Pictures {
    places: Places,
    /// Chip of each place; none beyond the image.
    chips: Vec<Option<Chip>>,
    orientations: Vec<f32>,
    seen: Seen,
}

/// Part of an image in which keypoints are moved: without what its mask hides at mid-burst.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    size: (usize, usize),
    /// Numbers of the pixels, row by row, at which hidden ones begin and end by turns; none where all are seen.
    turns: Vec<u64>,
}

impl Seen {
    /// Seen part of an image whose plane at mid-burst is `middle`.
    pub fn of(middle: &Plane) -> Self {
        let (width, height) = middle.size();
        let (pixels, mut before) = (if middle.mask().is_some() { width * height } else { 0 }, false);
        let is_turn = |pixel: &usize| {
            let is_hidden = middle.is_hidden_at(pixel % width, pixel / width);
            std::mem::replace(&mut before, is_hidden) != is_hidden
        };
        Self { size: (width, height), turns: (0..pixels).filter(is_turn).map(|pixel| pixel as u64).collect() }
    }

    /// Seen part of the image of `burst`, in the frames that `params` use.
    pub fn in_burst(burst: &Burst, params: &DetectorParams) -> Self {
        let used = params.used_frames(burst.len());
        Self::of(&burst.frames[used.start + used.len() / 2])
    }

    /// Whether the place (u, v), pixels, lies in the image and is not hidden.
    pub fn holds(&self, place: [f64; 2]) -> bool {
        let [u, v] = place.map(f64::round);
        let (width, height) = self.size;
        if !(u >= 0.0 && v >= 0.0 && u < width as f64 && v < height as f64) {
            return false;
        }
        let pixel = (v as usize * width + u as usize) as u64;
        self.turns.partition_point(|turn| *turn <= pixel).is_multiple_of(2)
    }
}

fn places_of(places: &[[f64; 2]], blobs: &[Blob]) -> Places {
    Places::of(places.iter().zip(blobs).map(|(&[u, v], blob)| [u as f32, v as f32, blob.sigma]))
}

impl Pictures {
    /// Pictures of features at `places` in the frames of `burst` that `params` use.
    pub fn of(burst: &Burst, params: &DetectorParams, places: &[[f64; 2]], blobs: &[Blob]) -> Self {
        let used = params.used_frames(burst.len());
        let frames: Vec<&Plane> = burst.frames[used.clone()].iter().map(|frame| &**frame).collect();
        let largest = blobs.iter().map(|blob| blob.sigma).fold(0.0, f32::max);
        let source = ChipSource::new(&frames, &FrameTimes::all(burst.positions.part(used)), largest);
        let of = places_of(places, blobs);
        // One chip for all orientations of a place.
        let chip = |&index: &usize| {
            let ([u, v], blob) = (places[index].map(|x| x as f32), &blobs[index]);
            source.chip((u, v), blob.sigma, blob.slope)
        };
        let chips = of.first.par_iter().map(chip).collect();
        let seen = Seen::in_burst(burst, params);
        Self { places: of, chips, orientations: blobs.iter().map(|blob| blob.orientation).collect(), seen }
    }

    /// Part of the image in which its places are moved.
    pub fn seen(&self) -> &Seen {
        &self.seen
    }

    /// First feature of each place.
    pub(super) fn first(&self) -> &[usize] {
        &self.places.first
    }

    pub(super) fn place(&self, feature: usize) -> usize {
        self.places.of_feature[feature]
    }

    /// Chip of a feature; `None` beyond the image.
    pub fn chip(&self, feature: usize) -> Option<&Chip> {
        self.chips[self.place(feature)].as_ref()
    }

    pub(super) fn view(&self, feature: usize) -> Option<View<'_>> {
        Some(View { chip: self.chip(feature)?, orientation: self.orientations[feature] })
    }
}

/// Measures those of `matches` that are `inlier`; `None` for the others, and for those whose pictures do not tell.
pub fn measure_inliers(
    matches: &[Match],
    inlier: &[bool],
    [a, b]: [&Pictures; 2],
    monitor: &Monitor,
) -> Result<Vec<Option<Measured>>, Cancelled> {
    let views = |(index, m): (usize, &Match)| Some((index, [a.view(m.a)?, b.view(m.b)?]));
    // Outliers would disturb the common rotation and scale, which come from these views.
    let some = matches.iter().enumerate().filter(|(index, _)| inlier[*index]);
    let (indices, views): (Vec<usize>, Vec<[View<'_>; 2]>) = some.filter_map(views).unzip();
    let found = measure(&views, PairFrame::of(&views), pair::FIT_RADIUS, monitor)?;
    let mut measured = vec![None; matches.len()];
    indices.into_iter().zip(found).for_each(|(index, found)| measured[index] = found);
    Ok(measured)
}

/// Alignment of one pair of images.
#[derive(Debug, Clone, PartialEq)]
pub struct PairAlignment {
    /// Solved place of each feature of A, and of B, pixels; as it was where nothing was measured.
    pub places: [Vec<[f64; 2]>; 2],
    /// For each match whether it was an inlier before.
    pub was_inlier: Vec<bool>,
    /// For each match its measurement, and the contradiction with the solved places, pixels; `None` if not measured.
    pub measured: Vec<Option<(Measured, f64)>>,
    /// Distance of each contradicted match from the nearest place where one around expects it, pixels, above the max
    /// error; by the match's index. All around contradict it, in A and in B, so that it counts as not measured.
    pub contradicted: BTreeMap<usize, f64>,
}

impl PairAlignment {
    /// Shift (u, v) in B of match `index`, pixels, to A's place seen there, and its correlation; `None` if unmeasured.
    pub fn shift_in_b(&self, index: usize) -> Option<([f64; 2], f64)> {
        let (measured, _) = self.measured[index]?;
        Some((measured.shift_px, measured.correlation))
    }
}

/// Moves the places of one pair's features by its `measured` matches, and verifies again, if `params` ask for it.
pub(super) fn align_pair(
    result: &mut MatchResult,
    sides: [MatchSide<'_>; 2],
    (measured, contradicted): (&[Option<Measured>], BTreeMap<usize, f64>),
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<()> {
    let Some(verified) = result.verification.as_ref().filter(|v| v.model.is_some() && params.aligns()) else {
        return Ok(());
    };
    // The solution of a dataset, for two images.
    let mut alignment = Alignment::default();
    for side in sides {
        alignment.add_image(side.places.to_vec(), side.blobs, side.pictures.map(Pictures::seen).cloned());
    }
    let mut link = |(m, measured): (&Match, &Option<Measured>)| {
        measured.map(|measured| alignment.add_match((0, 1), (m.a, m.b), measured))
    };
    let links: Vec<Option<usize>> = result.matches.iter().zip(measured).map(&mut link).collect();
    let aligned = alignment.solve(monitor)?;
    let inliers: Vec<usize> = (0..links.len()).filter(|&index| verified.inlier[index]).collect();
    let linked: Vec<(Inlier, Option<usize>)> =
        inliers.iter().map(|&index| (Inlier::from(&result.matches[index]), links[index])).collect();
    let Some(confirmed) = aligned.confirmed((0, 1), verified.model.as_ref(), &linked, params, monitor)? else {
        return Ok(());
    };
    let residual =
        |(measured, link): (&Option<Measured>, Option<usize>)| Some(((*measured)?, aligned.residuals_px[link?]));
    let measured = measured.iter().zip(links).map(residual).collect();
    let Ok([a, b]) = <[Vec<[f64; 2]>; 2]>::try_from(aligned.places) else { return Ok(()) };
    let error_px =
        |m: &Match| confirmed.model.as_ref().map_or(f32::INFINITY, |model| model.error_px(a[m.a], b[m.b]) as f32);
    let error_px = result.matches.iter().map(error_px).collect();
    // Only former inliers can stay inliers.
    let mut inlier = vec![false; result.matches.len()];
    inliers.iter().zip(&confirmed.inlier).for_each(|(&index, &is_one)| inlier[index] = is_one);
    result.counts.inliers = Some(confirmed.inlier_count());
    result.counts.refused = confirmed.model.is_none().then_some(Refusal::Pictures);
    let verification = Verification { inlier, error_px, ..confirmed };
    let was_inlier = result.verification.replace(verification).map_or_else(Vec::new, |before| before.inlier);
    result.alignment = Some(PairAlignment { was_inlier, places: [a, b], measured, contradicted });
    Ok(())
}

/// Inlier of a pair that waits for the solution; kept small, since a dataset holds those of all pairs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inlier {
    /// Index of the feature in image A.
    pub a: u32,
    /// Index of the feature in image B.
    pub b: u32,
    /// Rank of its match, [`Match::rank`].
    pub rank: f32,
}

impl Inlier {
    /// Rank of a match beside measured ones: behind all ratios, since no descriptor was compared.
    pub const RANK_BESIDE: f32 = 2.0;
}

impl From<&Match> for Inlier {
    fn from(m: &Match) -> Self {
        Self { a: m.a as u32, b: m.b as u32, rank: m.rank() }
    }
}

/// Images and their measured matches, before the solution.
#[derive(Debug, Clone, Default)]
pub struct Alignment {
    images: Vec<Image>,
    sigmas: Vec<f32>,
    /// Image and first feature of each place.
    first: Vec<[u32; 2]>,
    links: Vec<Link>,
}

#[derive(Debug, Clone)]
struct Image {
    /// Place of each feature, counted over all images.
    place_of: Vec<u32>,
    features: Vec<[f64; 2]>,
    seen: Option<Seen>,
}

impl Alignment {
    /// Adds an image with features at `places`, which stay in the part that is `seen`; anywhere without.
    pub fn add_image(&mut self, places: Vec<[f64; 2]>, blobs: &[Blob], seen: Option<Seen>) {
        let (of, first) = (places_of(&places, blobs), self.sigmas.len());
        self.sigmas.extend(of.first.iter().map(|&feature| blobs[feature].sigma));
        // All images of a dataset are held at once, so no more is reserved than needed.
        self.first.reserve_exact(of.first.len());
        self.first.extend(of.first.iter().map(|&feature| [self.images.len() as u32, feature as u32]));
        let place_of = of.of_feature.into_iter().map(|place| (first + place) as u32).collect();
        self.images.push(Image { place_of, features: places, seen });
    }

    /// Whether `correction` leaves a place near, in its image, and in what is seen of it.
    fn may_move(&self, place: usize, [du, dv]: [f64; 2]) -> bool {
        let [image, feature] = self.first[place].map(|number| number as usize);
        let Image { features, seen, .. } = &self.images[image];
        let [u, v] = features[feature];
        du.hypot(dv) <= MOST_MOVED_PX && seen.as_ref().is_none_or(|seen| seen.holds([u + du, v + dv]))
    }

    /// Adds a measured match of the features `a` and `b` of `images`. Returns its index.
    pub fn add_match(&mut self, images: (usize, usize), (a, b): (usize, usize), measured: Measured) -> usize {
        let place = |image: usize, feature: usize| self.images[image].place_of[feature] as usize;
        self.links.push(Link { a: place(images.0, a), b: place(images.1, b), measured });
        self.links.len() - 1
    }

    /// Solves for the places on which all matches agree best, and forgets these: the images stay, for other matches.
    pub fn solve(&mut self, monitor: &Monitor) -> Result<AlignedImages, Cancelled> {
        let may_move = |place, correction| self.may_move(place, correction);
        let Solved { corrections, residuals_px, refused } = solve(&self.sigmas, &self.links, may_move, monitor)?;
        self.links = Vec::new();
        let place = |([u, v], place): ([f64; 2], u32)| {
            let [du, dv] = corrections[place as usize];
            [u + du, v + dv]
        };
        let moved =
            |image: &Image| image.features.iter().copied().zip(image.place_of.iter().copied()).map(place).collect();
        let places = self.images.iter().map(moved).collect();
        let place_of = self.images.iter().map(|image| image.place_of.clone()).collect();
        // Median and largest are of places that move: most features have no match.
        let mut moved_px: Vec<f64> = corrections.iter().map(|[u, v]| u.hypot(*v)).filter(|px| *px > 0.0).collect();
        moved_px.sort_unstable_by(f64::total_cmp);
        let share = moved_px.len() as f64 / corrections.len().max(1) as f64;
        let (median_px, max_px) = (moved_px.get(moved_px.len() / 2).copied(), moved_px.last().copied());
        let moved = Moved { share, median_px, max_px, refused };
        Ok(AlignedImages { places, place_of, residuals_px, moved })
    }
}

/// Images with the solved places of their features.
#[derive(Debug, Clone, PartialEq)]
pub struct AlignedImages {
    /// Solved place of each feature of each image, pixels; as it was where nothing was measured.
    pub places: Vec<Vec<[f64; 2]>>,
    /// Number of each feature's place by image, which those of other orientations share.
    pub place_of: Vec<Vec<u32>>,
    /// Contradiction of each measured match with them, pixels.
    pub residuals_px: Vec<f64>,
    /// Distances by which they were moved.
    pub moved: Moved,
}

/// Distances by which keypoints were moved to where their matches agree; those of several orientations count once.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Moved {
    /// Share of the keypoints that were moved, 0 … 1.
    pub share: f64,
    /// Median distance of those, pixels; `None` without any.
    pub median_px: Option<f64>,
    /// Largest distance, pixels.
    pub max_px: Option<f64>,
    /// Number of keypoints that stay as found, since their matches put them too far away or out of sight.
    pub refused: usize,
}

impl AlignedImages {
    /// Estimates a pair's geometry again, from the `former` one and its inliers with the indices of their measurements.
    pub fn confirmed(
        &self,
        images: (usize, usize),
        former: Option<&TwoViewModel>,
        inliers: &[(Inlier, Option<usize>)],
        params: &MatchParams,
        monitor: &Monitor,
    ) -> Result<Option<Verification>> {
        let limit = NARROW * params.max_error_px;
        let agrees = |link: &Option<usize>| link.is_some_and(|link| self.residuals_px[link] <= f64::from(limit));
        // What contradicts the solved places goes before the geometry is estimated again.
        let kept: Vec<usize> = (0..inliers.len()).filter(|&index| agrees(&inliers[index].1)).collect();
        let point = |index: usize| self.point(images, &inliers[index].0);
        let Some(mut of_kept) = self.verified(kept.iter().map(|&index| point(index)), former, params, monitor)? else {
            return Ok(None);
        };
        // A wrong geometry agrees by chance, and its pictures do not: few are left.
        if !keeps_enough(of_kept.inlier_count(), inliers.len()) {
            of_kept.refuse();
        }
        let error_px = |index: usize| {
            let PointPair { a, b, .. } = point(index);
            of_kept.model.as_ref().map_or(f32::INFINITY, |model| model.error_px(a, b) as f32)
        };
        // Back to the indices of the former inliers.
        let mut inlier = vec![false; inliers.len()];
        kept.iter().zip(&of_kept.inlier).for_each(|(&index, &is_one)| inlier[index] = is_one);
        Ok(Some(Verification { inlier, error_px: (0..inliers.len()).map(error_px).collect(), ..of_kept }))
    }

    /// Geometry of a pair estimated again, from the `former` one, its `inliers` and those that others imply, and which
    /// of both agree with it. `None` where they are fewer than `inliers`, or than a pair keeps.
    pub fn with_implied(
        &self,
        images: (usize, usize),
        former: Option<&TwoViewModel>,
        [inliers, implied]: [&[Inlier]; 2],
        params: &MatchParams,
        monitor: &Monitor,
    ) -> Result<Option<(TwoViewModel, [Vec<Inlier>; 2])>> {
        let all = inliers.iter().chain(implied).map(|inlier| self.point(images, inlier));
        let Some(found) = self.verified(all, former, params, monitor)? else { return Ok(None) };
        let enough = found.inlier_count() >= FEWEST_KEPT.max(inliers.len());
        let (own, others) = found.inlier.split_at(inliers.len());
        let agreed = |of: &[Inlier], agree: &[bool]| {
            of.iter().zip(agree).filter(|(_, agrees)| **agrees).map(|(inlier, _)| *inlier).collect()
        };
        let agreed = [agreed(inliers, own), agreed(implied, others)];
        Ok(found.model.filter(|_| enough).map(|model| (model, agreed)))
    }

    fn point(&self, images: (usize, usize), &Inlier { a, b, rank }: &Inlier) -> PointPair {
        PointPair { a: self.places[images.0][a as usize], b: self.places[images.1][b as usize], rank }
    }

    fn verified(
        &self,
        points: impl Iterator<Item = PointPair>,
        former: Option<&TwoViewModel>,
        params: &MatchParams,
        monitor: &Monitor,
    ) -> Result<Option<Verification>> {
        let narrow = MatchParams { max_error_px: NARROW * params.max_error_px, ..params.clone() };
        verify(&points.collect::<Vec<_>>(), former, &narrow, monitor)
    }
}
