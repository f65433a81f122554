//! Matches that measured ones imply or contradict: what lies beside a match in A lies beside it in B, turned and
//! stretched as its pictures are.
//!
//! Descriptors change with the angle of view, and motions tell a place to some pixels only. A measured inlier is an
//! affine map, by which both the place of a neighbour and its picture follow ("match propagation", Lhuillier and Quan,
//! PAMI 2002; with affine maps Kannala and Brandt, CVPR 2007). A match that all neighbours put elsewhere lies on its
//! epipolar line, so that the geometry cannot tell, and one beside them takes its place. On a façade of equal windows
//! wrong matches have neighbours too: new ones count only where other images do not contradict.

use super::align::{Guess, Measured, measure_near};
use super::aligned::{Inlier, NARROW, keeps_enough};
use super::{Match, MatchParams, MatchSide, Unaligned};
use crate::monitor::{Cancelled, Monitor};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashSet};

/// Distance within which a match says where its neighbours lie, pixels, and number of matches that are asked.
const NEAR_PX: f64 = 60.0;
const ASKED: usize = 4;
/// Largest distance, pixels, of the place that one of them expects in B from the median of all.
const AGREED_PX: f64 = 4.0;
/// Least correlation of a match that is asked, and of a new one.
const LEAST_CORRELATION: f64 = 0.7;
/// Farthest place in B from where it is expected: before the pictures are compared, its scale σ, and after, pixels.
const REACH_SIGMAS: f64 = 2.0;
const OFF_PX: f64 = 2.0;
const MOST_SCALE_RATIO: f64 = 1.6;

type Uv = [f64; 2];

/// A measured match: its place in A, and where that lies in B.
struct Anchor {
    at: Uv,
    to: Uv,
    measured: Measured,
}

impl Anchor {
    fn new([a, b]: [MatchSide<'_>; 2], (i, j): (usize, usize), measured: Measured) -> Self {
        Self { at: a.places[i], to: [0, 1].map(|k| b.places[j][k] + measured.shift_px[k]), measured }
    }

    /// Match seen from B, by the inverse of its Jacobian; `None` where that is singular.
    fn back(&self) -> Option<Self> {
        let [[uu, uv], [vu, vv]] = self.measured.jacobian;
        let det = uu * vv - uv * vu;
        let jacobian = [[vv / det, -uv / det], [-vu / det, uu / det]];
        (det != 0.0).then_some(Self { at: self.to, to: self.at, measured: Measured { jacobian, ..self.measured } })
    }

    /// Where a place of A lies in B if its surroundings move as this match does.
    fn follows(&self, at: Uv) -> Uv {
        let off = [at[0] - self.at[0], at[1] - self.at[1]];
        let jacobian = self.measured.jacobian;
        [0, 1].map(|i| self.to[i] + jacobian[i][0] * off[0] + jacobian[i][1] * off[1])
    }
}

fn distance_squared([u, v]: Uv, [x, y]: Uv) -> f64 {
    (u - x) * (u - x) + (v - y) * (v - y)
}

fn anchors(sides: [MatchSide<'_>; 2], matches: &[Match], measured: &[Option<Measured>]) -> Vec<Option<Anchor>> {
    let anchor = |(m, measured): (&Match, &Option<Measured>)| Some(Anchor::new(sides, (m.a, m.b), (*measured)?));
    matches.iter().zip(measured).map(anchor).collect()
}

/// The nearest of `anchors` around the place `at` of A.
fn around<'a>(anchors: impl Iterator<Item = &'a Anchor>, at: Uv) -> Vec<&'a Anchor> {
    let near = anchors.map(|anchor| (distance_squared(anchor.at, at), anchor));
    let mut near: Vec<(f64, &Anchor)> = near.filter(|near| near.0 < NEAR_PX * NEAR_PX).collect();
    near.sort_by(|one, other| one.0.total_cmp(&other.0));
    near.into_iter().map(|(_, anchor)| anchor).take(ASKED).collect()
}

/// Place in B where the matches around the place `at` of A expect it, and their mean Jacobian; `None` where not even
/// two are near, or they do not agree.
fn expected(anchors: &[Anchor], at: Uv) -> Option<(Uv, [Uv; 2])> {
    let near = around(anchors.iter(), at);
    let last = near.len().checked_sub(1)?;
    let median = |k: usize| {
        let mut places: Vec<f64> = near.iter().map(|anchor| anchor.follows(at)[k]).collect();
        places.sort_by(f64::total_cmp);
        0.5 * (places[last / 2] + places[last.div_ceil(2)])
    };
    let place = [median(0), median(1)];
    let agrees = |anchor: &&Anchor| distance_squared(anchor.follows(at), place) <= AGREED_PX * AGREED_PX;
    // A wrong neighbour, or a step of depth between them: none alone says which.
    if last == 0 || !near.iter().all(agrees) {
        return None;
    }
    let mean = |i: usize, j: usize| near.iter().map(|anchor| anchor.measured.jacobian[i][j]).sum::<f64>();
    Some((place, [0, 1].map(|i| [0, 1].map(|j| mean(i, j) / near.len() as f64))))
}

/// Forgets of the `measured` of `matches` those that all others around contradict, in A and in B. Returns for each the
/// distance, pixels, from the nearest place where one of these expects it, by index; all are above `most_px`.
pub(super) fn forget_contradicted(
    sides: [MatchSide<'_>; 2],
    (matches, measured): (&[Match], &mut [Option<Measured>]),
    most_px: f64,
) -> BTreeMap<usize, f64> {
    let there = anchors(sides, matches, measured);
    let off_px = |anchors: &[Option<Anchor>], own: &Anchor| {
        // Features of one place err together.
        let others = anchors.iter().flatten().filter(|other| distance_squared(other.at, own.at) > 1.0);
        let near = around(others, own.at);
        let off_px = near.iter().map(|other| distance_squared(other.follows(own.at), own.to).sqrt());
        // In the dark half of the inliers are wrong, so two may be both.
        off_px.min_by(f64::total_cmp).filter(|off_px| near.len() > 2 && *off_px > most_px)
    };
    // Both ways, so that the images can be exchanged.
    let back: Vec<Option<Anchor>> = there.iter().map(|anchor| anchor.as_ref()?.back()).collect();
    let both = |(a, b): (&Option<Anchor>, &Option<Anchor>)| {
        Some(off_px(&there, a.as_ref()?)?.min(off_px(&back, b.as_ref()?)?))
    };
    let off_px: Vec<Option<f64>> = there.par_iter().zip(&back).map(both).collect();
    let contradicted = off_px.into_iter().enumerate().filter_map(|(index, off_px)| Some((index, off_px?)));
    let contradicted = contradicted.collect::<BTreeMap<usize, f64>>();
    contradicted.keys().for_each(|index| measured[*index] = None);
    contradicted
}

/// Matches beside the measured inliers of a pair, with their measurements: of places that are in no inlier, one each.
/// None without pictures, and where an alignment would refuse the pair.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn beside(
    sides @ [a, b]: [MatchSide<'_>; 2],
    found: &Unaligned,
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<Vec<(Inlier, Measured)>, Cancelled> {
    let verified = found.result.verification.as_ref();
    let (Some(verified), Some(of_a), Some(of_b)) = (verified, a.pictures, b.pictures) else { return Ok(Vec::new()) };
    let Some(model) = &verified.model else { return Ok(Vec::new()) };
    let narrow_px = f64::from(NARROW * params.max_error_px);
    let is_believed = |anchor: &Anchor| {
        anchor.measured.correlation >= LEAST_CORRELATION && model.error_px(anchor.at, anchor.to) <= narrow_px
    };
    let (matches, measured) = (&found.result.matches, &found.measured);
    let anchors: Vec<Anchor> = anchors(sides, matches, measured).into_iter().flatten().filter(is_believed).collect();
    if !keeps_enough(anchors.len(), verified.inlier_count()) {
        return Ok(Vec::new());
    }
    // What is contradicted, or not found by its picture, is no inlier in the end.
    let inliers = matches.iter().zip(measured).filter(|(_, measured)| measured.is_some()).map(|(m, _)| m);
    let taken_a: HashSet<usize> = inliers.clone().map(|m| of_a.place(m.a)).collect();
    let mut taken_b: HashSet<usize> = inliers.map(|m| of_b.place(m.b)).collect();
    // By rows, so that few are compared with each place.
    let mut free: Vec<usize> = of_b.first().iter().copied().filter(|j| !taken_b.contains(&of_b.place(*j))).collect();
    free.sort_by(|i, j| b.places[*i][1].total_cmp(&b.places[*j][1]));
    let before = |v: f64| free.partition_point(|j| b.places[*j][1] < v);
    let guess = |&i: &usize| {
        let (place, jacobian) = expected(&anchors, a.places[i])?;
        // Farther from the epipolar line nothing near the place would be believed.
        if model.error_px(a.places[i], place) > OFF_PX + narrow_px {
            return None;
        }
        let [[uu, uv], [vu, vv]] = jacobian;
        let sigma = f64::from(a.blobs[i].sigma) * (uu * vv - uv * vu).abs().sqrt();
        let unlike = |&j: &usize| {
            let of_b = f64::from(b.blobs[j].sigma);
            let (off, ratio) = (distance_squared(b.places[j], place).sqrt() / of_b, (of_b / sigma).max(sigma / of_b));
            (off < REACH_SIGMAS && ratio < MOST_SCALE_RATIO).then_some((off + ratio.ln(), j))
        };
        let (reach_px, v) = (REACH_SIGMAS * MOST_SCALE_RATIO * sigma, place[1]);
        let near = free[before(v - reach_px)..before(v + reach_px)].iter().filter_map(unlike);
        let (_, j) = near.min_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)))?;
        let shift_px = [0, 1].map(|k| place[k] - b.places[j][k]);
        Some(((i, j, place), ([of_a.view(i)?, of_b.view(j)?], Guess { shift_px, jacobian })))
    };
    let open = of_a.first().iter().filter(|i| !taken_a.contains(&of_a.place(**i)));
    let (pairs, guesses): (Vec<_>, Vec<_>) = open.filter_map(guess).unzip();
    let found = pairs.into_iter().zip(measure_near(&guesses, monitor)?);
    let found = found.filter_map(|((i, j, place), measured)| {
        let anchor = Anchor::new(sides, (i, j), measured?);
        (distance_squared(anchor.to, place) <= OFF_PX * OFF_PX && is_believed(&anchor))
            .then_some(((i, j), anchor.measured))
    });
    let mut found: Vec<((usize, usize), Measured)> = found.collect();
    // Of several places of A that want one of B the most alike gets it.
    found.sort_by(|(_, x), (_, y)| y.correlation.total_cmp(&x.correlation));
    found.retain(|((_, j), _)| taken_b.insert(of_b.place(*j)));
    let inlier = |(i, j)| Inlier { a: i as u32, b: j as u32, rank: Inlier::RANK_BESIDE };
    Ok(found.into_iter().map(|(pair, measured)| (inlier(pair), measured)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measurement_that_no_other_around_expects_is_forgotten_and_one_that_few_are_near_is_kept() {
        // A row of places that B sees turned by a right angle and twice as large, and one far from all.
        let places_a: Vec<Uv> = (0..6).map(|k| [12.0 * f64::from(k), 5.0]).chain([[500.0, 5.0]]).collect();
        let jacobian = [[0.0, -2.0], [2.0, 0.0]];
        let in_b = |&[u, v]: &Uv| [300.0 - 2.0 * v, 2.0 * u];
        let places_b: Vec<Uv> = places_a.iter().map(in_b).collect();
        let [a, b] =
            [&places_a, &places_b].map(|places| MatchSide { places, descriptors: &[], blobs: &[], pictures: None });
        let m = |k: usize| Match { a: k, b: k, distance: 1.0, ratio: None, predicted: None };
        let matches: Vec<Match> = (0..7).map(m).collect();
        let off = |shift_px: Uv| Some(Measured { shift_px, jacobian, correlation: 0.9 });
        let mut measured = vec![off([0.0, 0.0]); 7];
        (measured[0], measured[2], measured[4], measured[6]) =
            (None, off([0.0, 9.0]), off([3.0, 0.0]), off([0.0, 30.0]));
        let before = measured.clone();
        let contradicted = forget_contradicted([a, b], (&matches, &mut measured), 4.0);
        // The third is contradicted by all around, in A by half as many pixels; the fifth by too little.
        assert_eq!(contradicted, BTreeMap::from([(2, 4.5)]));
        assert_eq!(measured, [&before[..2], &[None], &before[3..]].concat());
        // Two others around are too few.
        let mut three = before.iter().take(4).copied().chain([None; 3]).collect::<Vec<_>>();
        assert!(forget_contradicted([a, b], (&matches, &mut three), 4.0).is_empty());
    }
}
