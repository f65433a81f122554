//! Matches made exact: every inlier is measured by the pictures of its two places, and what contradicts goes.
//!
//! [`Pictures`] are the chips of an image's places ([`super::align`]). The inliers of each pair are measured by them
//! ([`measure_inliers`]); from all pairs together [`Alignment`] solves for one place of each keypoint, and
//! [`AlignedImages::confirmed`] estimates each pair's geometry again, at the solved places and with a smaller error. A
//! pair that keeps few of its matches agreed by chance, and is refused.

use super::align::{Chip, ChipSource, Link, Measured, PairFrame, Places, Solved, View, measure, pair, solve};
use super::geometry::{PointPair, Verification, verify};
use super::{Blob, Match, MatchParams, MatchResult, Refusal};
use crate::burst::Burst;
use crate::detector::DetectorParams;
use crate::detector::stack::FrameTimes;
use crate::error::Result;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use rayon::prelude::*;

/// Max error before the alignment, as a part of [`MatchParams::max_error_px`]: places are uncertain.
const WIDE: f32 = 2.0;
/// Max error after it, as a part of [`MatchParams::max_error_px`]; also the largest contradiction between a match and
/// the solved places.
pub const NARROW: f32 = 0.35;
/// Fewest matches that a pair keeps.
const FEWEST_KEPT: usize = 30;
/// Least share of its inliers that a pair keeps: wrong pairs keep less.
const LEAST_KEPT: f64 = 0.25;

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
}

/// Places of the features at `places`, of scales as in `blobs`.
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
        let chip = |&index: &usize| {
            let ([u, v], blob) = (places[index].map(|x| x as f32), &blobs[index]);
            source.chip((u, v), blob.sigma, blob.slope)
        };
        let chips = of.first.par_iter().map(chip).collect();
        Self { places: of, chips, orientations: blobs.iter().map(|blob| blob.orientation).collect() }
    }

    /// Chip of a feature; `None` beyond the image.
    pub fn chip(&self, feature: usize) -> Option<&Chip> {
        self.chips[self.places.of_feature[feature]].as_ref()
    }

    fn view(&self, feature: usize) -> Option<View<'_>> {
        Some(View { chip: self.chip(feature)?, orientation: self.orientations[feature] })
    }
}

/// Measures those of `matches` that are `inlier`; `None` for the others, and for those whose pictures do not tell.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn measure_inliers(
    matches: &[Match],
    inlier: &[bool],
    [a, b]: [&Pictures; 2],
    monitor: &Monitor,
) -> Result<Vec<Option<Measured>>, Cancelled> {
    let views = |(index, m): (usize, &Match)| Some((index, [a.view(m.a)?, b.view(m.b)?]));
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
    /// For each match what the pictures say, and how far it contradicts the solved places, pixels; `None` for what was
    /// no inlier, and where the pictures do not tell.
    pub measured: Vec<Option<(Measured, f64)>>,
}

impl PairAlignment {
    /// From the place in B of match `index` to where A's place is seen there (u, v), pixels, and the correlation of the
    /// pictures of both, −1 … 1; `None` where they do not tell.
    pub fn shift_in_b(&self, index: usize) -> Option<([f64; 2], f64)> {
        let (measured, _) = self.measured[index]?;
        Some((measured.shift_px, measured.correlation))
    }
}

/// Solves for the places of one pair's features, found at `places` with shapes `blobs`, from its `measured` matches,
/// and verifies the inliers again there. Nothing is done to a pair without a geometry.
///
/// # Errors
/// Parameters that make no sense, and cancellation once `monitor` was cancelled.
pub fn align_pair(
    result: &mut MatchResult,
    sides: [(&[[f64; 2]], &[Blob]); 2],
    measured: &[Option<Measured>],
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<()> {
    let Some(verified) = result.verification.as_ref().filter(|v| v.model.is_some()) else { return Ok(()) };
    let mut alignment = Alignment::default();
    sides.into_iter().for_each(|(places, blobs)| alignment.add_image(places.to_vec(), blobs));
    let mut link = |(m, measured): (&Match, &Option<Measured>)| {
        measured.map(|measured| alignment.add_match((0, 1), (m.a, m.b), measured))
    };
    let links: Vec<Option<usize>> = result.matches.iter().zip(measured).map(&mut link).collect();
    let aligned = alignment.solve(monitor)?;
    let inliers: Vec<usize> = (0..links.len()).filter(|&index| verified.inlier[index]).collect();
    let linked: Vec<(Match, Option<usize>)> =
        inliers.iter().map(|&index| (result.matches[index], links[index])).collect();
    let Some(confirmed) = aligned.confirmed((0, 1), &linked, params, monitor)? else { return Ok(()) };
    let residual =
        |(measured, link): (&Option<Measured>, Option<usize>)| Some(((*measured)?, aligned.residuals_px[link?]));
    let measured = measured.iter().zip(links).map(residual).collect();
    let Ok([a, b]) = <[Vec<[f64; 2]>; 2]>::try_from(aligned.places) else { return Ok(()) };
    let error_px = |m: &Match| {
        let error_px = confirmed.model.as_ref().map(|model| model.error_px(a[m.a], b[m.b]) as f32);
        error_px.unwrap_or(f32::INFINITY)
    };
    let error_px = result.matches.iter().map(error_px).collect();
    let mut inlier = vec![false; result.matches.len()];
    inliers.iter().zip(&confirmed.inlier).for_each(|(&index, &is_one)| inlier[index] = is_one);
    result.counts.inliers = Some(confirmed.inlier_count());
    result.counts.refused = confirmed.model.is_none().then_some(Refusal::Pictures);
    let verification = Verification { inlier, error_px, ..confirmed };
    let was_inlier = result.verification.replace(verification).map_or_else(Vec::new, |before| before.inlier);
    result.alignment = Some(PairAlignment { was_inlier, places: [a, b], measured });
    Ok(())
}

/// Images and their measured matches, before the solution.
#[derive(Debug, Clone, Default)]
pub struct Alignment {
    images: Vec<Image>,
    sigmas: Vec<f32>,
    links: Vec<Link>,
}

/// An image of an [`Alignment`].
#[derive(Debug, Clone)]
struct Image {
    /// Place of each feature, counted over all images.
    place_of: Vec<usize>,
    features: Vec<[f64; 2]>,
}

impl Alignment {
    /// Adds an image with features at `places`.
    pub fn add_image(&mut self, places: Vec<[f64; 2]>, blobs: &[Blob]) {
        let (of, first) = (places_of(&places, blobs), self.sigmas.len());
        self.sigmas.extend(of.first.iter().map(|&feature| blobs[feature].sigma));
        let place_of = of.of_feature.into_iter().map(|place| first + place).collect();
        self.images.push(Image { place_of, features: places });
    }

    /// Adds a measured match of the features `a` and `b` of `images`. Returns its index.
    pub fn add_match(&mut self, images: (usize, usize), (a, b): (usize, usize), measured: Measured) -> usize {
        let place = |image: usize, feature: usize| self.images[image].place_of[feature];
        self.links.push(Link { a: place(images.0, a), b: place(images.1, b), measured });
        self.links.len() - 1
    }

    /// Solves for the places on which all matches agree best.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` was cancelled.
    pub fn solve(self, monitor: &Monitor) -> Result<AlignedImages, Cancelled> {
        let Solved { corrections, residuals_px } = solve(&self.sigmas, &self.links, monitor)?;
        let moved = |image: Image| {
            let places = image.features.iter().zip(&image.place_of);
            places.map(|(&[u, v], &place)| [u + corrections[place][0], v + corrections[place][1]]).collect()
        };
        Ok(AlignedImages { places: self.images.into_iter().map(moved).collect(), residuals_px })
    }
}

/// Images with the solved places of their features.
#[derive(Debug, Clone, PartialEq)]
pub struct AlignedImages {
    /// Solved place of each feature of each image, pixels; as it was where nothing was measured.
    pub places: Vec<Vec<[f64; 2]>>,
    /// Contradiction of each measured match with them, pixels.
    pub residuals_px: Vec<f64>,
}

impl AlignedImages {
    /// Estimates a pair's geometry again. `inliers` are its matches that agreed before, each with its index among the
    /// measured ones, if it was measured. In the order of `inliers`.
    ///
    /// # Errors
    /// Parameters that make no sense, and cancellation once `monitor` was cancelled.
    pub fn confirmed(
        &self,
        images: (usize, usize),
        inliers: &[(Match, Option<usize>)],
        params: &MatchParams,
        monitor: &Monitor,
    ) -> Result<Option<Verification>> {
        let limit = NARROW * params.max_error_px;
        let agrees = |link: &Option<usize>| link.is_some_and(|link| self.residuals_px[link] <= f64::from(limit));
        let kept: Vec<usize> = (0..inliers.len()).filter(|&index| agrees(&inliers[index].1)).collect();
        let point = |index: usize| {
            let m = inliers[index].0;
            PointPair { a: self.places[images.0][m.a], b: self.places[images.1][m.b], rank: m.ratio }
        };
        let points: Vec<PointPair> = kept.iter().map(|&index| point(index)).collect();
        let again = verify(&points, &MatchParams { max_error_px: limit, ..params.clone() }, monitor)?;
        let Some(mut of_kept) = again else { return Ok(None) };
        let enough = FEWEST_KEPT.max((LEAST_KEPT * inliers.len() as f64).ceil() as usize);
        if of_kept.inlier_count() < enough {
            of_kept.refuse();
        }
        let error_px = |index: usize| {
            let PointPair { a, b, .. } = point(index);
            of_kept.model.as_ref().map_or(f32::INFINITY, |model| model.error_px(a, b) as f32)
        };
        let mut inlier = vec![false; inliers.len()];
        kept.iter().zip(&of_kept.inlier).for_each(|(&index, &is_one)| inlier[index] = is_one);
        let error_px = (0..inliers.len()).map(error_px).collect();
        Ok(Some(Verification { inlier, error_px, ..of_kept }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::Slope;
    use crate::matching::MatchCounts;
    use crate::matching::geometry::tests::places_in_space;
    use crate::synth::random::Stream;

    const SIGMA: f32 = 4.0;

    fn blobs(count: usize) -> Vec<Blob> {
        let slope = Slope::default();
        vec![Blob { sigma: SIGMA, orientation: 0.0, slope, motion: slope, motion_sigma: 1.0 }; count]
    }

    /// Places of a scene in both images, and where blobs are found in B: some pixels beside them.
    fn scene(count: usize) -> [Vec<[f64; 2]>; 3] {
        let mut random = Stream::new(3, 0);
        let seen = places_in_space(&mut random, count);
        let [a, b] = [0, 1].map(|side| seen.iter().map(|views| views[side].0).collect::<Vec<_>>());
        let beside = |place: &[f64; 2]| place.map(|x| x + random.within(-3.0, 3.0));
        let found = b.iter().map(beside).collect();
        [a, b, found]
    }

    fn measured(from: [f64; 2], to: [f64; 2]) -> Measured {
        let shift_px = [to[0] - from[0], to[1] - from[1]];
        Measured { shift_px, jacobian: [[1.0, 0.0], [0.0, 1.0]], correlation: 0.9 }
    }

    /// Matches of the i-th features, measured by `measure`, and their geometry after the alignment.
    fn confirmed(
        count: usize,
        measure: impl Fn(usize) -> Option<Measured>,
        [a, b]: [&[[f64; 2]]; 2],
    ) -> (AlignedImages, Verification) {
        let mut alignment = Alignment::default();
        [a, b].into_iter().for_each(|places| alignment.add_image(places.to_vec(), &blobs(count)));
        let found = |i| Match { a: i, b: i, distance: 1.0, ratio: 0.5 };
        let mut link = |i| (found(i), measure(i).map(|measured| alignment.add_match((0, 1), (i, i), measured)));
        let inliers: Vec<(Match, Option<usize>)> = (0..count).map(&mut link).collect();
        let aligned = alignment.solve(&Monitor::default()).expect("not cancelled");
        let params = MatchParams::default();
        let verified = aligned.confirmed((0, 1), &inliers, &params, &Monitor::default()).expect("valid parameters");
        (aligned, verified.expect("asked for"))
    }

    #[test]
    fn places_that_the_pictures_correct_fit_the_geometry_exactly() {
        let [a, b, found] = scene(80);
        let (aligned, verified) = confirmed(80, |i| Some(measured(found[i], b[i])), [&a, &found]);
        assert!(verified.model.is_some() && verified.inlier_count() == 80, "{}", verified.inlier_count());
        // A prior that is weak beside the measurement leaves a hundredth of the correction.
        let apart = |i: usize| {
            let correction = |side: usize, before: [f64; 2], k: usize| aligned.places[side][i][k] - before[k];
            [0, 1].map(|k| found[i][k] - b[i][k] + correction(1, found[i], k) - correction(0, a[i], k))
        };
        let largest = (0..80).flat_map(apart).map(f64::abs).fold(0.0, f64::max);
        assert!(largest < 0.05, "{largest} px");
        assert!(verified.error_px.iter().all(|error| *error < 0.5), "{:?}", verified.error_px);
    }

    #[test]
    fn what_is_not_measured_stays_where_it_is_and_is_no_inlier() {
        let [a, b, _] = scene(80);
        let (aligned, verified) = confirmed(80, |i| (i < 60).then(|| measured(b[i], b[i])), [&a, &b]);
        assert!(aligned.places[0][60..] == a[60..] && aligned.places[1][60..] == b[60..]);
        assert!(verified.inlier[..60].iter().all(|inlier| *inlier) && !verified.inlier[60..].contains(&true));
        assert!(verified.error_px[60..].iter().all(|error| *error < 0.5), "its error is known all the same");
    }

    #[test]
    fn a_pair_that_keeps_few_matches_is_refused() {
        let [a, b, _] = scene(200);
        for (kept, is_believed) in [(29, false), (49, false), (60, true)] {
            let (_, verified) = confirmed(200, |i| (i < kept).then(|| measured(b[i], b[i])), [&a, &b]);
            assert_eq!(
                (verified.model.is_some(), verified.inlier.contains(&true)),
                (is_believed, is_believed),
                "{kept}"
            );
        }
    }

    #[test]
    fn places_that_contradict_their_other_matches_lose_them() {
        // Three images; the third sees the first's places 5 px beside where the second one does.
        let [a, b, _] = scene(60);
        let mut alignment = Alignment::default();
        [&a, &b, &b].into_iter().for_each(|places| alignment.add_image(places.clone(), &blobs(60)));
        let found = |i| Match { a: i, b: i, distance: 1.0, ratio: 0.5 };
        let mut pairs = [(0, 1), (0, 2), (1, 2)].map(|images| (images, Vec::new()));
        for (images, matches) in &mut pairs {
            for (i, &at) in b.iter().enumerate() {
                let to = if *images == (0, 2) && i < 20 { [at[0] + 5.0, at[1]] } else { at };
                let link = alignment.add_match(*images, (i, i), measured(at, to));
                matches.push((found(i), Some(link)));
            }
        }
        let aligned = alignment.solve(&Monitor::default()).expect("not cancelled");
        let (images, matches) = &pairs[1];
        let params = MatchParams::default();
        let verified =
            aligned.confirmed(*images, matches, &params, &Monitor::default()).expect("valid").expect("asked");
        assert!(!verified.inlier[..20].contains(&true) && verified.inlier[20..].iter().all(|inlier| *inlier));
    }

    #[test]
    fn a_pair_without_a_geometry_is_left_alone() {
        let counts = MatchCounts::default();
        let mut result =
            MatchResult { matches: Vec::new(), verification: None, prediction: None, alignment: None, counts };
        let before = result.clone();
        let sides = [(&[][..], &[][..]); 2];
        align_pair(&mut result, sides, &[], &MatchParams::default(), &Monitor::default()).expect("valid");
        assert_eq!(result, before);
    }
}
