//! Searching only what is new: a search of the same frames at other slopes goes on from what an earlier one left.
//!
//! Noise, cleaned frames, and [what was found](crate::detector::search::known) at the slopes that both searches have
//! are taken over, and the features of keypoints whose neighbouring slopes are the same too. The choice of features,
//! their field of motion and what depends on the ends of the range are computed again.

use super::outcome::{Outcome, are_as_strict, sigma_d};
use super::trail::{SampleKey, Trail, sample_key};
use crate::burst::Burst;
use crate::detector::describe::Described;
use crate::detector::feature::{Feature, Tally};
use crate::detector::params::{DetectorParams, NoiseGate, NoiseModelKind, SearchSlopes, Slope, SlopeGrid};
use crate::detector::search::known::KnownSlopes;
use crate::detector::search::setup::{Inputs, Search};
use crate::detector::search::slope_window::OtherSlopes;
use std::collections::HashMap;
use std::sync::Arc;

/// An earlier search of the frames of a new one that differs from it in its slopes, and perhaps in what is judged
/// later.
pub(super) struct Earlier<'a> {
    trail: &'a Trail,
}

/// Number of slopes of a search with `params` that need no other search after one of the same frames with `searched`: 0
/// where nothing can be taken over. (In noise with very light tails a higher gate may still be less strict; then all
/// are searched.)
pub fn shared_slopes(params: &DetectorParams, searched: &DetectorParams) -> usize {
    let same_slopes = DetectorParams { slopes: searched.slopes, ..params.clone() };
    let same_noise = params.noise_model == NoiseModelKind::White
        || searched.used_slopes().enclosing(0.0) == params.used_slopes().enclosing(0.0);
    // A strict gate may refuse the noise.
    let may_refuse = params.noise_gate == NoiseGate::Strict && searched.noise_gate != NoiseGate::Strict;
    let is_after = is_sum(params)
        && same_noise
        && !may_refuse
        && params.validate().is_ok()
        && searched.judged_as(&same_slopes) == same_slopes
        && are_as_strict(params, searched);
    if is_after { known_slopes(&params.used_slopes(), &searched.used_slopes()).iter().flatten().count() } else { 0 }
}

/// Whether a search with `params` finds at each slope what a search of that slope alone would.
pub(super) fn is_sum(params: &DetectorParams) -> bool {
    OtherSlopes::of(params) == OtherSlopes::Unseen && params.search == SearchSlopes::All
}

/// For each slope of `grid` its index among those of `earlier`.
fn known_slopes(grid: &SlopeGrid, earlier: &SlopeGrid) -> Vec<Option<usize>> {
    // Of the two zeros one is meant.
    let bits = |slope: Slope| [slope.u + 0.0, slope.v + 0.0].map(f32::to_bits);
    let known: HashMap<[u32; 2], usize> = earlier.slopes().map(bits).zip(0..).collect();
    grid.slopes().map(|slope| known.get(&bits(slope)).copied()).collect()
}

impl<'a> Earlier<'a> {
    /// `None` where a search of `burst` with `params` has nothing to take over from `trail`.
    pub(super) fn of(trail: &'a Trail, burst: &Burst, params: &DetectorParams) -> Option<Self> {
        let used = params.used_frames(burst.len());
        let read = &burst.frames[used.clone()];
        let same_frames = read.len() == trail.inputs.read.len()
            && burst.positions.part(used) == trail.inputs.times.positions
            && read.iter().zip(&trail.inputs.read).all(|(one, other)| Arc::ptr_eq(one, other));
        let is_after = || shared_slopes(params, &trail.outcome.params) > 0;
        (same_frames && is_after()).then_some(Self { trail })
    }

    /// The search of some slopes of the new one with its own inputs: `trail`.
    pub(super) fn begun(trail: &'a Trail) -> Self {
        Self { trail }
    }

    pub(super) fn inputs(&self, params: &DetectorParams) -> Inputs {
        self.trail.inputs.judged_with(params)
    }

    /// What the earlier search left for `search`; `None` where that might find other keypoints at the same slopes.
    pub(super) fn known(&self, search: &Search<'_>) -> Option<KnownSlopes<'a>> {
        let outcome = &*self.trail.outcome;
        let bases = outcome.bases.as_ref()?;
        let slopes = known_slopes(&search.grid, &outcome.params.used_slopes());
        let judged = outcome.judged(search, &sigma_d(search), &slopes)?;
        let tally = |earlier: &Option<usize>| earlier.map_or_else(Tally::default, |index| outcome.tallies[index]);
        let mut tallies: Vec<Tally> = slopes.iter().map(tally).collect();
        let mut keypoints = Vec::with_capacity(judged.len());
        for (found, failed) in judged {
            match failed {
                Some(test) => tallies[found.0.slope_index].reject(test, 1),
                None => keypoints.push(found),
            }
        }
        Some(KnownSlopes { slopes, bases, keypoints, tallies })
    }

    /// Takes over the features of the keypoints of `outcome` that were `known` and have the same neighbours among the
    /// slopes of `grid`.
    pub(super) fn describe(&self, grid: &SlopeGrid, known: &KnownSlopes<'_>, outcome: &mut Outcome) {
        let earlier = self.trail.inputs.params.used_slopes();
        let same_steps = [grid.u.step(), grid.v.step(), grid.direction_deg]
            == [earlier.u.step(), earlier.v.step(), earlier.direction_deg]
            && grid.is_plane() == earlier.is_plane();
        if !same_steps || outcome.described.is_empty() || self.trail.outcome.described.is_empty() {
            return;
        }
        let stays = |index: usize| {
            let own = known.slopes[index]?;
            let around = grid.around(index).map(|near| near.map(|near| known.slopes[near]));
            let same = around.eq(earlier.around(own).map(|near| near.map(Some)));
            same.then_some(own)
        };
        let own_of: Vec<Option<usize>> = (0..grid.len()).map(stays).collect();
        let earlier = &self.trail.outcome;
        let numbers: HashMap<SampleKey, usize> = earlier.keypoints.iter().map(sample_key).zip(0..).collect();
        for (keypoint, described) in outcome.keypoints.iter().zip(&mut outcome.described) {
            let Some(own) = own_of[keypoint.slope_index] else { continue };
            let (octave, level, slope_index, sample) = sample_key(keypoint);
            let number = numbers.get(&(octave, level, own, sample));
            if let Some(features) = number.and_then(|number| earlier.described[*number].get()) {
                let renumbered =
                    |one: &Described| Described { feature: Feature { slope_index, ..one.feature }, ..one.clone() };
                *described = features.iter().map(renumbered).collect::<Box<[Described]>>().into();
            }
        }
    }
}
