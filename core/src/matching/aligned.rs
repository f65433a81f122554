//! Matches made exact: every inlier is measured by the pictures of its two places, and what contradicts goes.
//!
//! [`Pictures`] are the chips of an image's places ([`super::align`]). The inliers of each pair are measured by them
//! ([`measure_inliers`]); from all pairs together [`Alignment`] solves for one place of each keypoint, and
//! [`AlignedImages::confirmed`] estimates each pair's geometry again, at the solved places and with a smaller error. A
//! pair that keeps few of its matches agreed by chance, and is refused.

use super::align::{Chip, ChipSource, Link, Measured, PairFrame, Places, Solved, View, measure, pair, solve};
use super::geometry::{PointPair, Verification, verify};
use super::{Blob, Match, MatchParams};
use crate::burst::Burst;
use crate::detector::DetectorParams;
use crate::detector::stack::FrameTimes;
use crate::error::Error;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use rayon::prelude::*;

/// Largest contradiction between a match and the solved places, pixels, and largest error of an inlier there, where
/// [`MatchParams::max_error_px`] is not less.
pub const ALIGNED_ERROR_PX: f32 = 2.0;
/// Fewest matches that a pair keeps.
const FEWEST_KEPT: usize = 30;
/// Least share of its inliers that a pair keeps: wrong pairs keep less.
const LEAST_KEPT: f64 = 0.25;

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
        let frames: Vec<&Plane> = burst.frames[params.used_frames(burst.len())].iter().map(|frame| &**frame).collect();
        let largest = blobs.iter().map(|blob| blob.sigma).fold(0.0, f32::max);
        let source = ChipSource::new(&frames, &FrameTimes::all(frames.len()), largest);
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
    ) -> Result<Option<Verification>, Error> {
        let limit = params.max_error_px.min(ALIGNED_ERROR_PX);
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
        let mut verification = Verification {
            inlier: vec![false; inliers.len()],
            error_px: vec![f32::INFINITY; inliers.len()],
            ..of_kept.clone()
        };
        if let Some(model) = &of_kept.model {
            for (index, error_px) in verification.error_px.iter_mut().enumerate() {
                let point = point(index);
                *error_px = model.error_px(point.a, point.b) as f32;
            }
        }
        kept.iter().zip(&of_kept.inlier).for_each(|(&index, &inlier)| verification.inlier[index] = inlier);
        Ok(Some(verification))
    }
}
