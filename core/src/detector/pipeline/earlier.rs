//! Searching only new slopes: a search of the same frames goes on from the results of an earlier one.
//!
//! Noise, cleaned frames and [keypoints](KnownSlopes) at slopes that both searches have are taken over,
//! and features of keypoints whose neighbouring slopes are the same too. The choice of features, their field of
//! motion and the marks at the ends of the range are computed again.

use super::outcome::{Outcome, are_as_strict, sigma_d};
use super::trail::{SampleKey, Trail, sample_key};
use crate::burst::Burst;
use crate::detector::describe::Described;
use crate::detector::feature::{Feature, Tally};
use crate::detector::params::{DetectorParams, NoiseGate, NoiseModelKind, SearchSlopes, Slope, SlopeGrid};
use crate::detector::search::setup::{KnownSlopes, Search};
use crate::detector::search::slope_window::OtherSlopes;
use std::collections::HashMap;
use std::sync::Arc;

/// Number of slopes of a search with `params` that an earlier search of the same frames with `searched` covers: 0 where
/// nothing can be taken over. (In noise with very light tails a higher gate may be less strict; all are searched then.)
pub fn shared_slopes(params: &DetectorParams, searched: &DetectorParams) -> usize {
    // The noise is measured over the enclosing range of slopes: another range may give another noise.
    let same_slopes = DetectorParams { slopes: searched.slopes, ..params.clone() };
    let same_noise = params.noise_model == NoiseModelKind::White
        || searched.used_slopes().enclosing(0.0) == params.used_slopes().enclosing(0.0);
    // A strict gate may refuse a noise that the earlier gate accepted.
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

fn known_slopes(grid: &SlopeGrid, earlier: &SlopeGrid) -> Vec<Option<usize>> {
    // 0 and −0 are one slope with different bits.
    let bits = |slope: Slope| [slope.u + 0.0, slope.v + 0.0].map(f32::to_bits);
    let known: HashMap<[u32; 2], usize> = earlier.slopes().map(bits).zip(0..).collect();
    grid.slopes().map(|slope| known.get(&bits(slope)).copied()).collect()
}

impl Trail {
    /// Number of slopes that a search of `burst` with `params` would take over from this one.
    pub fn known_slopes(&self, burst: &Burst, params: &DetectorParams) -> usize {
        let used = params.used_frames(burst.len());
        let read = &burst.frames[used.clone()];
        let same_frames = read.len() == self.inputs.read.len()
            && burst.positions.part(used) == self.inputs.times.positions
            && read.iter().zip(&self.inputs.read).all(|(one, other)| Arc::ptr_eq(one, other));
        if same_frames { shared_slopes(params, &self.outcome.params) } else { 0 }
    }

    /// Results of this search for `search`; `None` where it might have missed keypoints at the same slopes.
    pub(super) fn known(&self, search: &Search<'_>) -> Option<KnownSlopes<'_>> {
        let outcome = &*self.outcome;
        let bases = outcome.bases.as_ref()?;
        let slopes = known_slopes(&search.grid, &outcome.params.used_slopes());
        let judged = outcome.judged(search, &sigma_d(search), &slopes)?;
        let tally = |earlier: &Option<usize>| earlier.map_or_else(Tally::default, |index| outcome.tallies[index]);
        let mut tallies: Vec<Tally> = slopes.iter().map(tally).collect();
        let mut keypoints = Vec::with_capacity(judged.len());
        for (found, failed) in judged {
            match failed {
                // It passed before, so that the earlier tally counts no rejection of it.
                Some(test) => tallies[found.0.slope_index].reject(test, 1),
                None => keypoints.push(found),
            }
        }
        Some(KnownSlopes { slopes, bases, keypoints, tallies })
    }

    /// Takes over features of `known` keypoints of `outcome` with the same neighbours among the slopes of `grid`.
    pub(super) fn lend_features(&self, grid: &SlopeGrid, known: &KnownSlopes<'_>, outcome: &mut Outcome) {
        let earlier = self.inputs.params.used_slopes();
        // Features read D at neighbouring slopes: other steps or neighbours make other features.
        let same_steps = [grid.u.step(), grid.v.step(), grid.direction_deg]
            == [earlier.u.step(), earlier.v.step(), earlier.direction_deg]
            && grid.is_plane() == earlier.is_plane();
        if !same_steps || outcome.described.is_empty() || self.outcome.described.is_empty() {
            return;
        }
        let stays = |index: usize| {
            let own = known.slopes[index]?;
            let around = grid.around(index).map(|near| near.map(|near| known.slopes[near]));
            let same = around.eq(earlier.around(own).map(|near| near.map(Some)));
            same.then_some(own)
        };
        let own_of: Vec<Option<usize>> = (0..grid.len()).map(stays).collect();
        let earlier = &self.outcome;
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
