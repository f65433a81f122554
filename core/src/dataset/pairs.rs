//! The matching of pairs of bursts, with the features of a few bursts in memory at a time, however many there are.

use super::BurstFeatures;
use crate::burst::Burst;
use crate::detect::prepare;
use crate::detector::{Descriptor, Detection, DetectorParams};
use crate::error::Result;
use crate::export::ColmapKeypoint;
use crate::matching::align::Measured;
use crate::matching::aligned::{Pictures, align_pair, measure_inliers};
use crate::matching::{Blob, MatchParams, MatchResult, MatchSide, match_detections, match_features};
use crate::monitor::{Monitor, Stage};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of pairs that are matched before their results are passed on.
const PAIRS_AT_ONCE: usize = 16;
/// Number of first bursts that stay in memory while the second bursts of their pairs are loaded one after the other.
const FIRST_AT_ONCE: usize = 8;
/// Maximum number of bursts whose features are in memory.
const BURSTS_AT_ONCE: usize = FIRST_AT_ONCE + PAIRS_AT_ONCE / FIRST_AT_ONCE;

/// Features of a burst as matching needs them.
#[derive(Debug, Clone, PartialEq)]
pub struct BurstSide {
    /// Position of each feature (u, v), pixels.
    pub places: Vec<[f64; 2]>,
    /// Descriptor of each feature.
    pub descriptors: Vec<Descriptor>,
    /// Shape and motion of each feature.
    pub blobs: Vec<Blob>,
    /// Pictures of their places, where matches are to be measured.
    pub pictures: Option<Pictures>,
}

impl BurstSide {
    /// The features of these keypoints, their descriptors, shapes and motions.
    pub fn new(keypoints: &[ColmapKeypoint], descriptors: Vec<Descriptor>, blobs: Vec<Blob>) -> Self {
        let places = keypoints.iter().map(ColmapKeypoint::pos_image).collect();
        Self { places, descriptors, blobs, pictures: None }
    }

    /// These features with the pictures of their places, in the frames of `burst` in which `params` search.
    ///
    /// # Errors
    /// Parameters that make no sense for the burst, and cancellation once `monitor` was cancelled.
    pub fn with_pictures(self, burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Self> {
        let (burst, params) = prepare(burst, params, monitor)?;
        let pictures = Some(Pictures::of(&burst, &params, &self.places, &self.blobs));
        Ok(Self { pictures, ..self })
    }

    fn side(&self) -> MatchSide<'_> {
        MatchSide { places: &self.places, descriptors: &self.descriptors, blobs: &self.blobs }
    }
}

impl From<BurstFeatures> for BurstSide {
    fn from(burst: BurstFeatures) -> Self {
        Self::new(&burst.keypoints, burst.descriptors, burst.blobs)
    }
}

/// A burst, and what was found in it.
#[derive(Debug, Clone, Copy)]
pub struct DetectedBurst<'a> {
    /// The burst.
    pub burst: &'a Burst,
    /// Parameters with which it was searched.
    pub params: &'a DetectorParams,
    /// Its features.
    pub detection: &'a Detection,
}

impl DetectedBurst<'_> {
    fn side(&self, monitor: &Monitor) -> Result<BurstSide> {
        let Detection { features, descriptors, .. } = self.detection;
        let places = features.iter().map(|feature| [feature.u, feature.v].map(f64::from)).collect();
        let blobs = features.iter().map(Blob::from).collect();
        let side = BurstSide { places, descriptors: descriptors.clone(), blobs, pictures: None };
        side.with_pictures(self.burst, self.params, monitor)
    }
}

/// Matches the features of two bursts, verifies the matches, and aligns them where `params` ask for it: their frames
/// are needed for that alone.
///
/// # Errors
/// Parameters that make no sense, and cancellation once `monitor` was cancelled.
pub fn match_bursts([a, b]: [DetectedBurst<'_>; 2], params: &MatchParams, monitor: &Monitor) -> Result<MatchResult> {
    if !params.align {
        return match_detections(a.detection, b.detection, params, monitor);
    }
    let (a, b) = (a.side(monitor)?, b.side(monitor)?);
    let (result, measured) = matched([&a, &b], params, monitor)?;
    MatchedPair { indices: (0, 1), sides: [&a, &b], result: &result, measured: &measured }.aligned(params, monitor)
}

/// A pair of bursts and its matches.
#[derive(Debug, Clone, Copy)]
pub struct MatchedPair<'a> {
    /// Indices of the bursts.
    pub indices: (usize, usize),
    /// Their features.
    pub sides: [&'a BurstSide; 2],
    /// Matches of the first burst's features with those of the second.
    pub result: &'a MatchResult,
    /// For each match what the pictures say, where both bursts have some and it is an inlier.
    pub measured: &'a [Option<Measured>],
}

impl MatchedPair<'_> {
    /// The result after an alignment by the measurements of this pair alone, where `params` ask for it.
    ///
    /// # Errors
    /// Parameters that make no sense, and cancellation once `monitor` was cancelled.
    pub fn aligned(&self, params: &MatchParams, monitor: &Monitor) -> Result<MatchResult> {
        let mut result = self.result.clone();
        if !params.align {
            return Ok(result);
        }
        let sides = self.sides.map(|side| (&side.places[..], &side.blobs[..]));
        align_pair(&mut result, sides, self.measured, params, monitor)?;
        Ok(result)
    }
}

/// Matches the bursts of each of `pairs`, in an order in which `load` is rarely asked for one again; `on` receives each
/// result. Pairs with a burst for which `load` gives `None` are left out. Returns their number.
///
/// # Errors
/// Parameters that make no sense, and errors of `load` and `on`.
pub fn match_pairs(
    pairs: &[(usize, usize)],
    params: &MatchParams,
    load: &mut dyn FnMut(usize) -> Result<Option<BurstSide>>,
    on: &mut dyn FnMut(MatchedPair<'_>) -> Result<()>,
    monitor: &Monitor,
) -> Result<usize> {
    params.validate()?;
    let mut ordered = pairs.to_vec();
    ordered.sort_by_key(|&(a, b)| (a / FIRST_AT_ONCE, b, a));
    let mut loaded: BTreeMap<usize, BurstSide> = BTreeMap::new();
    let mut missing = BTreeSet::new();
    let (mut done, mut left_out) = (0, 0);
    while done < ordered.len() {
        monitor.report(Stage::Match, done as f32 / ordered.len() as f32);
        let (count, needed) = next_together(&ordered[done..]);
        loaded.retain(|index, _| needed.contains(index));
        for &index in &needed {
            monitor.check()?;
            if loaded.contains_key(&index) || missing.contains(&index) {
                continue;
            }
            match load(index)? {
                Some(burst) => drop(loaded.insert(index, burst)),
                None => drop(missing.insert(index)),
            }
        }
        let there = |&(a, b): &(usize, usize)| Some(((a, b), [loaded.get(&a)?, loaded.get(&b)?]));
        let some: Vec<_> = ordered[done..done + count].iter().filter_map(there).collect();
        left_out += count - some.len();
        let matched: Vec<(MatchResult, Vec<Option<Measured>>)> =
            some.par_iter().map(|(_, sides)| matched(*sides, params, &monitor.silent())).collect::<Result<_, _>>()?;
        for (&(indices, sides), (result, measured)) in some.iter().zip(&matched) {
            on(MatchedPair { indices, sides, result, measured })?;
        }
        done += count;
    }
    monitor.report(Stage::Match, 1.0);
    Ok(left_out)
}

fn matched(
    [a, b]: [&BurstSide; 2],
    params: &MatchParams,
    monitor: &Monitor,
) -> Result<(MatchResult, Vec<Option<Measured>>)> {
    let (Some(of_a), Some(of_b)) = (&a.pictures, &b.pictures) else {
        let params = MatchParams { align: false, ..params.clone() };
        let result = match_features(a.side(), b.side(), &params, monitor)?;
        let measured = vec![None; result.matches.len()];
        return Ok((result, measured));
    };
    let result = match_features(a.side(), b.side(), params, monitor)?;
    let none = || vec![false; result.matches.len()];
    let inlier = result.verification.as_ref().map_or_else(none, |verified| verified.inlier.clone());
    let measured = measure_inliers(&result.matches, &inlier, [of_a, of_b], monitor)?;
    Ok((result, measured))
}

/// Number of the first of `pairs` that are matched together, at least 1, and the bursts that they need.
fn next_together(pairs: &[(usize, usize)]) -> (usize, BTreeSet<usize>) {
    let mut needed = BTreeSet::new();
    for (count, &(a, b)) in pairs.iter().take(PAIRS_AT_ONCE).enumerate() {
        let more = [a, b].iter().filter(|index| !needed.contains(*index)).count();
        if count > 0 && needed.len() + more > BURSTS_AT_ONCE {
            return (count, needed);
        }
        needed.extend([a, b]);
    }
    (pairs.len().min(PAIRS_AT_ONCE), needed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::PairSelection;

    fn side() -> BurstSide {
        BurstSide { places: vec![[1.0, 2.0]; 3], descriptors: vec![[7; 128]; 3], blobs: Vec::new(), pictures: None }
    }

    #[test]
    fn each_pair_is_matched_once_with_few_loads_and_pairs_without_features_are_left_out() {
        for (selection, missing) in
            [(PairSelection::All, None), (PairSelection::All, Some(4)), (PairSelection::Sequential(1), Some(0))]
        {
            let pairs = selection.pairs(40);
            let (mut loads, mut seen) = (0, Vec::new());
            let mut load = |index| {
                loads += 1;
                Ok((Some(index) != missing).then(side))
            };
            let mut on = |pair: MatchedPair<'_>| {
                seen.push(pair.indices);
                Ok(())
            };
            let params = MatchParams::default();
            let left_out = match_pairs(&pairs, &params, &mut load, &mut on, &Monitor::default()).expect("matched");
            seen.sort_unstable();
            let is_there = |&&(a, b): &&(usize, usize)| Some(a) != missing && Some(b) != missing;
            assert_eq!(seen, pairs.iter().filter(is_there).copied().collect::<Vec<_>>());
            assert_eq!(left_out, pairs.len() - seen.len());
            assert!(loads < 40 + pairs.len() / 3, "{loads} loads for {} pairs", pairs.len());
        }
    }

    #[test]
    fn few_bursts_are_needed_at_once() {
        let mut pairs = PairSelection::All.pairs(50);
        pairs.sort_by_key(|&(a, b)| (a / FIRST_AT_ONCE, b, a));
        let mut rest = &pairs[..];
        while !rest.is_empty() {
            let (count, needed) = next_together(rest);
            assert!(count > 0 && needed.len() <= BURSTS_AT_ONCE);
            rest = &rest[count..];
        }
    }
}
