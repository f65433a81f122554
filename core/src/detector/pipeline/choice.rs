//! Choice of features: of the keypoints on one blob the strongest, and of their features the strongest.
//!
//! Only what can be kept is computed: where the number of features is limited, keypoints are taken from the strongest
//! to the weakest, as many at a time as give the missing features, until the next is weaker than all features. A
//! feature has the strength of its keypoint, so the result is that of describing all and keeping the strongest.

use crate::detector::along::Along;
use crate::detector::coherence::Shape;
use crate::detector::describe::{Described, place_order};
use crate::detector::distinct::{Blob, Deciding, Rule};
use crate::detector::feature::{DEFINED_SIGMA, Feature, Keypoint, Moves, Tally, Test};
use crate::detector::params::Distinct;
use crate::detector::pipeline::outcome::{Outcome, PassingKeypoints};
use crate::detector::search::setup::Search;
use crate::monitor::Cancelled;
use rayon::prelude::*;
use std::ops::Range;
use std::time::Instant;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Kept,
    CoveredBy(usize),
    /// Its features are not among the strongest that are kept; it may never have been compared with others.
    Cut,
}

#[derive(Debug)]
pub(super) struct Choice {
    pub(super) verdicts: Vec<Verdict>,
    /// The keypoint of each feature, strongest first.
    pub(super) ranked: Vec<usize>,
    /// Keypoints known to be the strongest on their blobs.
    pub(super) distinct: Vec<usize>,
    pub(super) distinct_secs: f32,
}

impl Choice {
    pub(super) fn count(&self, tally: &mut Tally) {
        for verdict in &self.verdicts {
            match verdict {
                Verdict::Kept => tally.kept += 1,
                Verdict::CoveredBy(_) => tally.reject(Test::Duplicate, 1),
                Verdict::Cut => tally.reject(Test::MaxFeatures, 1),
            }
        }
    }
}

/// Smallest number of keypoints that are compared at a time.
const FEWEST: usize = 128;

pub(super) struct Chooser<'a> {
    pub(super) search: &'a Search<'a>,
    pub(super) outcome: &'a Outcome,
    pub(super) passing: &'a PassingKeypoints,
    pub(super) along: &'a Along<'a>,
}

impl Chooser<'_> {
    /// Chooses at most `max_features` features, 0 for all, and returns them, strongest first.
    pub(super) fn choose(&self, max_features: usize) -> Result<(Vec<Described>, Choice), Cancelled> {
        let max = if max_features == 0 { usize::MAX } else { max_features };
        let keypoints = &self.passing.keypoints[..];
        let blobs: Vec<Blob> = keypoints.iter().map(|keypoint| Blob::of(keypoint, self.search.space)).collect();
        let rule = match self.search.params.distinct {
            Distinct::Off => None,
            Distinct::Radius(radius) => Some(Rule { radius, scale_ratio: self.search.params.distinct_scale }),
        };
        let mut deciding = rule.map(|rule| Deciding::new(&blobs, rule));
        let mut distinct_secs = 0.0;
        let mut order: Vec<usize> = (0..keypoints.len()).collect();
        let strength = |index: &usize| keypoints[*index].strength();
        if max < keypoints.len() {
            order.par_sort_unstable_by(|a, b| strength(b).total_cmp(&strength(a)).then(a.cmp(b)));
        }
        // The comparison reads D along any motion, up to the coarsest octave of the keypoints.
        if let Some(last) = keypoints.last().filter(|_| deciding.is_some()) {
            self.along.make(last.octave);
        }
        let mut verdicts = vec![Verdict::Cut; keypoints.len()];
        let (mut found, mut left): (Vec<Described>, &[usize]) = (Vec::new(), &order);
        let mut done = 0.0;
        loop {
            // A keypoint as strong as the weakest feature may precede it by its place.
            let weakest = found.get(max.saturating_sub(1)).map(|one| one.feature.strength());
            let missing = match weakest {
                None => max - found.len(),
                Some(weakest) => left.partition_point(|index| strength(index) >= weakest),
            };
            if left.is_empty() || missing == 0 {
                break;
            }
            // Each pass decides only as many keypoints as have the missing features: describing is the costly step. Six
            // features for five keypoints are usual, as some have several orientations.
            let wanted = if weakest.is_none() { missing - missing / 6 } else { missing };
            let mut distinct: Vec<usize> = Vec::new();
            while distinct.len() < wanted && !left.is_empty() {
                let (next, after) = left.split_at((wanted - distinct.len()).max(FEWEST).min(left.len()));
                left = after;
                let started = Instant::now();
                if let Some(deciding) = &mut deciding {
                    let are_two = |a: usize, b: usize| self.along.are_two(&keypoints[a], &keypoints[b]);
                    deciding.decide(next, are_two, self.search.monitor)?;
                }
                distinct_secs += started.elapsed().as_secs_f32();
                for &index in next {
                    match deciding.as_ref().and_then(|deciding| deciding.covered_by(index)) {
                        Some(by) => verdicts[index] = Verdict::CoveredBy(by),
                        None => distinct.push(index),
                    }
                }
            }
            // With enough features now, later turns are rare and short.
            let until = if left.is_empty() { 1.0 } else { done + 0.8 * (1.0 - done) };
            self.append(&mut found, distinct, done..until)?;
            done = until;
            found.par_sort_by(in_order);
            found.truncate(max);
        }
        if let Some(weakest) = found.get(max.saturating_sub(1)).map(|one| one.feature.strength()) {
            // Candidates examined beyond are not reported: their number depends on the order of the threads.
            let weaker = verdicts.iter_mut().zip(keypoints).filter(|(_, keypoint)| keypoint.strength() < weakest);
            weaker.for_each(|(verdict, _)| *verdict = Verdict::Cut);
        }
        found.iter().for_each(|one| verdicts[one.keypoint] = Verdict::Kept);
        let distinct = deciding.map(|deciding| deciding.stayed().collect()).unwrap_or_default();
        let ranked = found.iter().map(|one| one.keypoint).collect();
        Ok((found, Choice { verdicts, ranked, distinct, distinct_secs }))
    }

    /// Appends the features of the keypoints `chosen`. `part` is this step's part of the progress.
    fn append(&self, found: &mut Vec<Described>, mut chosen: Vec<usize>, part: Range<f32>) -> Result<(), Cancelled> {
        let PassingKeypoints { keypoints, numbers, .. } = self.passing;
        let kept = |index: usize| self.outcome.described.get(numbers[index] as usize);
        chosen.sort_unstable();
        // Features of an earlier choice are reused; only the noise that judges them may differ.
        chosen.retain(|&index| {
            let described = kept(index).and_then(|kept| kept.get());
            found.extend(described.into_iter().flatten().map(|one| {
                let feature = Feature { snr: keypoints[index].snr, ..one.feature };
                Described { feature, keypoint: index, ..one.clone() }
            }));
            described.is_none()
        });
        let new: Vec<Keypoint> = chosen.iter().map(|&index| keypoints[index]).collect();
        let first = found.len();
        found.extend(self.search.describe(&new, self.outcome, self.along, part)?);
        found[first..].iter_mut().for_each(|one| one.keypoint = chosen[one.keypoint]);
        for same in found[first..].chunk_by(|a, b| a.keypoint == b.keypoint) {
            if let Some(kept) = kept(same[0].keypoint) {
                kept.get_or_init(|| same.into());
            }
        }
        Ok(())
    }

    /// Marks the features at the limit of the slopes, and adds their certainty and the motion of their surroundings.
    pub(super) fn mark(&self, found: &mut [Described]) -> Result<(), Cancelled> {
        let grid = &self.search.grid;
        // Without evidence the slope is somewhere in the grid: the deviation of a uniform distribution.
        let widest = [grid.u, grid.v].map(|axis| axis.max - axis.min + axis.step()).into_iter().fold(0.0, f32::max);
        let least_known = widest / 12f32.sqrt();
        // Frames are read at each place: neighbours share the pixels that are in the cache.
        let mut order: Vec<&mut Described> = found.iter_mut().collect();
        order.sort_by_cached_key(|one| place_order(one.feature.octave, one.feature.u, one.feature.v));
        order.into_par_iter().try_for_each(|one| {
            self.search.monitor.check()?;
            let number = self.passing.numbers[one.keypoint] as usize;
            let rises = self.outcome.rises[number].get_or_init(|| self.along.rises(&one.feature));
            one.feature.at_slope_limit = rises.iter().any(|rise| rise.exceeds_noise(one.feature.snr));
            // Noise moves the peak of a response by the response's width over the signal-to-noise ratio.
            let by_noise = |width: f32| CHOSEN[usize::from(grid.is_plane())] * width / one.feature.snr;
            // A round blob of this σ: a wider response is one along an edge, not a matter of noise.
            let round_width = one.feature.sigma / self.search.inputs.times.spread_frames();
            let is_defined_if_round = by_noise(round_width) <= DEFINED_SIGMA;
            one.feature.slope_sigma = by_noise(one.slope_width).min(least_known);
            one.feature.field_sigma = f32::INFINITY;
            if let Some(field) = &self.outcome.field {
                let Feature { u, v, slope, slope_sigma, .. } = one.feature;
                if let Some(motion) = field.known_at(u, v) {
                    (one.feature.field, one.feature.field_sigma) = (motion.slope, motion.ellipse().0[0]);
                }
                one.feature.layer = field.layer_of((u, v), slope, slope_sigma).into();
            }
            let by_numbers = Moves::by_numbers(&one.feature);
            // A ghost moves like nothing at its place, so a feature that moves like its place need not be examined.
            let may_be_ghost = by_numbers != Moves::WithSurroundings;
            one.feature.moves = if may_be_ghost && self.is_ghost(number, &one.feature)? {
                Moves::Ghost
            } else if is_defined_if_round && one.feature.slope_sigma > DEFINED_SIGMA {
                Moves::Edge
            } else {
                by_numbers
            };
            Ok(())
        })
    }

    /// Whether `feature` of keypoint `number` is a ghost; the answer is kept, as later thresholds do not change it.
    fn is_ghost(&self, number: usize, feature: &Feature) -> Result<bool, Cancelled> {
        let known = &self.outcome.ghosts[number];
        if let Some(is_ghost) = known.get() {
            return Ok(*is_ghost);
        }
        let is_ghost = self.along.evenness(feature, self.search.monitor)?.shape == Shape::Bump;
        Ok(*known.get_or_init(|| is_ghost))
    }
}

/// Factor on the error of a noisy peak for the slopes of features, on a line and in a plane: slopes are chosen among
/// many, and noise chooses with. Measured on the scene door; on entry 68 and 63 % lie within one standard deviation.
const CHOSEN: [f32; 2] = [2.1, 3.9];

/// Order of features: strongest first, then by place and sample. Features of one keypoint are equal.
fn in_order(one: &Described, other: &Described) -> std::cmp::Ordering {
    let (a, b) = (&one.feature, &other.feature);
    let by_place = || a.v.total_cmp(&b.v).then(a.u.total_cmp(&b.u));
    let by_sample = || (a.octave, a.level, a.slope_index).cmp(&(b.octave, b.level, b.slope_index));
    let by_keypoint = || one.keypoint.cmp(&other.keypoint);
    b.strength().total_cmp(&a.strength()).then_with(by_place).then_with(by_sample).then_with(by_keypoint)
}
