//! Guided matching: a second search for matches, among the features that agree with a geometry found before.
//!
//! A feature is compared only with those in a band around its epipolar line (or at its place under a homography), a
//! hundredth of the image: a looser ratio is then as safe. It is off by default: where the sure matches of a pair gave
//! a wrong geometry, hundreds of guided ones agree with that, and a reconstruction has wrong poses
//! (docs/MEASUREMENTS.md).
//!
//! Orientations of one keypoint count as one: they are no rivals of each other, and a pair of places is matched once.

use super::geometry::GuidingBand;
use super::params::MatchParams;
use super::putative::{Nearest, distance_squared};
use super::{Match, MatchSide, TwoViewModel};
use crate::detector::Descriptor;
use crate::monitor::{Cancelled, Monitor};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum ratio within the band, where [`MatchParams::ratio`] is lower.
pub const GUIDED_RATIO: f32 = 0.9;

/// Max error of guided matches, as a part of that of the sure ones (docs/MEASUREMENTS.md).
const GUIDED_ERROR: f32 = 0.5;

/// The parameters of guided matching after sure matches with `params`.
pub(super) fn guided_params(params: &MatchParams) -> MatchParams {
    MatchParams { max_error_px: GUIDED_ERROR * params.max_error_px, ..params.clone() }
}

/// Finds the matches that agree with `model` to [`MatchParams::max_error_px`], in the order of A's features: nearest
/// within the band, with a ratio of at most [`GUIDED_RATIO`] to the nearest one at another place in the band, and, with
/// the mutual check, both ways.
pub fn guided_matches(
    a: MatchSide<'_>,
    b: MatchSide<'_>,
    model: &TwoViewModel,
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<Vec<Match>, Cancelled> {
    let max_error_px = f64::from(params.max_error_px);
    let of_a = nearest_in_band(a, b, &model.band_in_b(a.places, b.places, max_error_px), monitor)?;
    let in_a = params.mutual.then(|| model.band_in_a(a.places, b.places, max_error_px));
    let of_b = in_a.map(|band| nearest_in_band(b, a, &band, monitor)).transpose()?;
    let limit = params.ratio.max(GUIDED_RATIO);
    let mut best: BTreeMap<[u64; 4], Match> = BTreeMap::new();
    let back = of_b.as_ref().map(|of_b| move |b: usize| of_b[b]);
    let found = of_a.iter().enumerate().filter_map(|(a, nearest)| nearest.as_ref()?.matched(a, back));
    for found in found.filter(|found| found.ratio <= limit) {
        let ([au, av], [bu, bv]) = (a.places[found.a], b.places[found.b]);
        let of_places = best.entry([au, av, bu, bv].map(f64::to_bits)).or_insert(found);
        if found.ratio < of_places.ratio {
            *of_places = found;
        }
    }
    let mut matches: Vec<Match> = best.into_values().collect();
    matches.sort_by_key(|m| m.a);
    Ok(matches)
}

/// For a feature of A at `place` (u, v), pixels, the nearest feature of `to`, those of B, that guided matching after
/// sure matches with `params` compares it with: its index, and the ratio (0 … 1) of its distance to that of the next
/// one at another place there. `None` where there is none.
pub fn nearest_along(
    (place, descriptor): ([f64; 2], Descriptor),
    to: MatchSide<'_>,
    model: &TwoViewModel,
    params: &MatchParams,
) -> Option<(usize, f32)> {
    let from = MatchSide { places: &[place], descriptors: &[descriptor] };
    let max_error_px = f64::from(guided_params(params).max_error_px);
    let band = model.band_in_b(from.places, to.places, max_error_px);
    let nearest = nearest_in_band(from, to, &band, &Monitor::default()).ok()?;
    nearest[0].map(|nearest| (nearest.index, nearest.ratio()))
}

/// Adds to `guided` those of `putative` that share no feature with it, in the order of A's features.
pub(super) fn with_others(guided: Vec<Match>, putative: &[Match]) -> Vec<Match> {
    let used_a: BTreeSet<usize> = guided.iter().map(|m| m.a).collect();
    let used_b: BTreeSet<usize> = guided.iter().map(|m| m.b).collect();
    let mut all = guided;
    all.extend(putative.iter().filter(|m| !used_a.contains(&m.a) && !used_b.contains(&m.b)));
    all.sort_by_key(|m| m.a);
    all
}

/// For each feature of `from` the nearest one of `to` within `band`, and the nearest one at another place.
fn nearest_in_band(
    from: MatchSide<'_>,
    to: MatchSide<'_>,
    band: &GuidingBand,
    monitor: &Monitor,
) -> Result<Vec<Option<Nearest>>, Cancelled> {
    let nearest = |(index, descriptor): (usize, &Descriptor)| {
        monitor.check()?;
        let mut best: Option<Nearest> = None;
        band.for_each_within(index, |other| {
            let distance_squared = distance_squared(descriptor, &to.descriptors[other]);
            let found = |second| Some(Nearest { index: other, distance_squared, second_distance_squared: second });
            best = match best {
                None => found(None),
                Some(old) => {
                    let elsewhere = to.places[old.index] != to.places[other];
                    if distance_squared < old.distance_squared {
                        found(if elsewhere { Some(old.distance_squared) } else { old.second_distance_squared })
                    } else if elsewhere {
                        let second = old.second_distance_squared.map_or(distance_squared, |x| x.min(distance_squared));
                        Some(Nearest { second_distance_squared: Some(second), ..old })
                    } else {
                        Some(old)
                    }
                }
            };
        });
        Ok(best)
    };
    from.descriptors.par_iter().enumerate().with_min_len(32).map(nearest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::memory::on_threads;
    use crate::matching::geometry::tests::scene_in_space;
    use crate::matching::{MatchParams, match_features};
    use crate::synth::random::Stream;

    type Features = (Vec<[f64; 2]>, Vec<Descriptor>);

    /// A scene of `count` points in both images, whose descriptors differ by noise, and `others` in each image alone;
    /// many descriptors are alike, so that few are clearly nearest in the whole image.
    fn noisy_pair(count: usize, others: usize) -> [Features; 2] {
        let mut random = Stream::new(0, 3);
        let scene = scene_in_space(&mut random, count);
        let kinds: Vec<Descriptor> =
            (0..8).map(|_| std::array::from_fn(|_| random.within(40.0, 120.0) as u8)).collect();
        let near = |random: &mut Stream, around: &Descriptor, by: f64| -> Descriptor {
            around.map(|x| (f64::from(x) + random.within(-by, by)).clamp(0.0, 255.0) as u8)
        };
        let (mut a, mut b) = ((Vec::new(), Vec::new()), (Vec::new(), Vec::new()));
        for (place_a, place_b) in scene {
            let kind = random.within(0.0, 8.0) as usize;
            let own = near(&mut random, &kinds[kind], 20.0);
            a.0.push(place_a);
            a.1.push(near(&mut random, &own, 17.0));
            b.0.push(place_b);
            b.1.push(near(&mut random, &own, 17.0));
        }
        for side in [&mut a, &mut b] {
            for _ in 0..others {
                side.0.push([random.within(0.0, 639.0), random.within(0.0, 479.0)]);
                let kind = random.within(0.0, 8.0) as usize;
                side.1.push(near(&mut random, &kinds[kind], 26.0));
            }
        }
        [a, b]
    }

    fn side(of: &Features) -> MatchSide<'_> {
        MatchSide { places: &of.0, descriptors: &of.1 }
    }

    fn matched([a, b]: &[Features; 2], params: &MatchParams) -> crate::matching::MatchResult {
        match_features(side(a), side(b), params, &Monitor::default()).expect("valid parameters")
    }

    #[test]
    fn guided_matching_finds_what_the_ratio_test_lost() {
        let pair = noisy_pair(600, 600);
        let found = |guided| matched(&pair, &MatchParams { guided, max_error_px: 2.0, ..MatchParams::default() });
        // The first 600 features of both images belong together.
        let right = |guided: bool| {
            let result = found(guided);
            let inlier = result.verification.expect("verified").inlier;
            let right = |(m, inlier): &(&Match, &bool)| **inlier && m.a == m.b && m.a < 600;
            let inliers = inlier.iter().filter(|inlier| **inlier).count();
            (result.matches.iter().zip(&inlier).filter(right).count(), inliers)
        };
        let ((plain, of_plain), (guided, of_guided)) = (right(false), right(true));
        assert!(plain > 300 && 10 * guided >= 12 * plain, "{plain} of {of_plain}, {guided} of {of_guided}");
        assert!(guided * 10 > of_guided * 8, "{guided} of {of_guided} inliers are right");
        let result = found(true);
        let unique = |of: fn(&Match) -> usize| result.matches.iter().map(of).collect::<BTreeSet<_>>().len();
        assert_eq!((unique(|m| m.a), unique(|m| m.b)), (result.matches.len(), result.matches.len()));
        assert!(result.matches.is_sorted_by_key(|m| m.a));
    }

    #[test]
    fn orientations_of_one_place_count_once() {
        let pair = noisy_pair(300, 0);
        let twice = |(places, descriptors): &Features| {
            let turned = descriptors.iter().map(|d| d.map(|x| x.saturating_add(1)));
            ([&places[..], places].concat(), descriptors.iter().copied().chain(turned).collect::<Vec<Descriptor>>())
        };
        let params = MatchParams { max_error_px: 2.0, ratio: 1.0, ..MatchParams::default() };
        let model = matched(&pair, &params).verification.and_then(|v| v.model).expect("a model");
        let guided = |a: &Features, b: &Features| {
            guided_matches(side(a), side(b), &model, &params, &Monitor::default()).expect("done")
        };
        let [a, b] = &pair;
        let (once, both) = (guided(a, b), guided(&twice(a), &twice(b)));
        assert!(once.len() > 200, "{}", once.len());
        let places = |matches: &[Match]| matches.iter().map(|m| (m.a % 300, m.b % 300)).collect::<BTreeSet<_>>();
        assert_eq!(places(&both).len(), both.len());
        let same = places(&once).intersection(&places(&both)).count();
        assert!(same * 10 > once.len() * 9, "{same} of {}", once.len());
    }

    #[test]
    fn threads_change_nothing() {
        let pair = noisy_pair(300, 300);
        let params = MatchParams { guided: true, ..MatchParams::default() };
        let with = |threads| on_threads(threads, || matched(&pair, &params));
        assert_eq!(with(1), with(2));
    }
}
