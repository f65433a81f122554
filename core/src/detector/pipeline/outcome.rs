//! Outcome of a search, for later judgements: keypoints with the values that thresholds compared, and known features.
//!
//! The result of a stricter threshold, another rule for distinct keypoints or another number of features follows from
//! the keypoints: those that fail are left out, and the features are chosen again.

use crate::detector::along::{Along, Means};
use crate::detector::describe::Described;
use crate::detector::feature::{Keypoint, Tally, Test};
use crate::detector::field::MotionField;
use crate::detector::limit::Rise;
use crate::detector::noise::gate_factor;
use crate::detector::params::DetectorParams;
use crate::detector::refine::edge_limit;
use crate::detector::search::setup::{FirstLevels, Search, SlopeGroup};
use crate::detector::search::{Evidence, FIRST_PEAK_PART, FoundKeypoint, SearchedSlopes, first_gate_part};
use std::sync::{Arc, OnceLock};

/// σ_D at the place of least noise, by octave, DoG level index and slope.
pub(super) type SigmaD = Vec<Vec<Vec<f32>>>;

/// Whether a search with `params` follows from one with `searched`: they differ only in parameters judged later, and
/// `params` are as strict. (In noise with very light tails a higher gate may be less strict: the judgement is `None`.)
pub fn follows(params: &DetectorParams, searched: &DetectorParams) -> bool {
    searched.judged_as(params) == *params && params.validate().is_ok() && are_as_strict(params, searched)
}

pub(super) fn are_as_strict(params: &DetectorParams, searched: &DetectorParams) -> bool {
    params.peak_threshold >= searched.peak_threshold
        && edge_limit(params.edge_threshold) <= edge_limit(searched.edge_threshold)
        && gate_factor(params) >= gate_factor(searched)
}

/// Result of a search before the choice of features, shared by all trails that follow from it.
#[derive(Debug)]
pub(super) struct Outcome {
    pub(super) params: DetectorParams,
    /// First levels of each octave; none for the first octave. `None` where slopes were searched in groups.
    pub(super) bases: Option<Vec<FirstLevels>>,
    /// Groups of slopes in which first levels that were not kept are computed again.
    pub(super) groups: Vec<SlopeGroup>,
    pub(super) keypoints: Vec<Keypoint>,
    evidence: Vec<Evidence>,
    /// Numbers of samples that the search rejected, by slope.
    pub(super) tallies: Vec<Tally>,
    /// The gate's factor and σ_D of the search; none where nothing is kept for later judgements.
    gate: Option<(f32, SigmaD)>,
    /// Features of each keypoint, once it was described; empty where nothing is kept for later judgements.
    pub(super) described: Vec<OnceLock<Box<[Described]>>>,
    /// Rises beyond the slopes of the features of each keypoint, computed on demand.
    pub(super) rises: Vec<OnceLock<Vec<Rise>>>,
    pub(super) ghosts: Vec<OnceLock<bool>>,
    pub(super) means: Means,
    pub(super) field: Option<Arc<MotionField>>,
}

#[derive(Debug)]
pub(super) struct PassingKeypoints {
    /// In order of octaves.
    pub(super) keypoints: Vec<Keypoint>,
    /// Index of each in the list of the search.
    pub(super) numbers: Vec<u32>,
    /// Numbers of samples that the search and the thresholds reject.
    pub(super) tally: Tally,
}

impl Outcome {
    /// Takes the result of `search`. If it `keeps` what is computed later, judgements can follow.
    pub(super) fn new(
        search: &Search<'_>,
        SearchedSlopes { keypoints, evidence, bases }: SearchedSlopes,
        groups: &[SlopeGroup],
        tallies: Vec<Tally>,
        keeps: bool,
        field: Option<Arc<MotionField>>,
    ) -> Self {
        Self {
            params: search.params.clone(),
            bases,
            groups: groups.to_vec(),
            described: vec![OnceLock::new(); if keeps { keypoints.len() } else { 0 }],
            rises: vec![OnceLock::new(); keypoints.len()],
            ghosts: vec![OnceLock::new(); keypoints.len()],
            keypoints,
            evidence,
            tallies,
            gate: keeps.then(|| (search.inputs.gate_factor, sigma_d(search))),
            means: Along::no_means(search.inputs),
            field,
        }
    }

    pub(super) fn all(&self) -> PassingKeypoints {
        let numbers = (0..self.keypoints.len() as u32).collect();
        PassingKeypoints { keypoints: self.keypoints.clone(), numbers, tally: total(&self.tallies) }
    }

    /// Keypoints that `search`, if it [follows](follows), would find; `None` where one of its limits is lower.
    pub(super) fn passing(&self, search: &Search<'_>, sigma_d: &SigmaD) -> Option<PassingKeypoints> {
        let slopes: Vec<Option<usize>> = (0..search.grid.len()).map(Some).collect();
        let judged = self.judged(search, sigma_d, &slopes).filter(|_| follows(search.params, &self.params))?;
        let (mut keypoints, mut numbers, mut tally) = (Vec::new(), Vec::new(), total(&self.tallies));
        for (number, ((keypoint, _), failed)) in (0..).zip(judged) {
            match failed {
                Some(test) => tally.reject(test, 1),
                None => {
                    keypoints.push(keypoint);
                    numbers.push(number);
                }
            }
        }
        Some(PassingKeypoints { keypoints, numbers, tally })
    }

    /// Keypoints at the slopes that `search` shares, each with the first test that it fails there. `slopes` has the
    /// index here of each slope of `search`; keypoints get the index there. `None` where `search` might find more.
    pub(super) fn judged(
        &self,
        search: &Search<'_>,
        sigma_d: &SigmaD,
        slopes: &[Option<usize>],
    ) -> Option<Vec<(FoundKeypoint, Option<Test>)>> {
        let (params, factor) = (search.params, search.inputs.gate_factor);
        let (own_factor, own_sigma_d) = self.gate.as_ref()?;
        // The noise may differ by slope, so the gates are compared one by one: none may be lower than before.
        let has_lower_gate = |(sigma_d, own): (&Vec<f32>, &Vec<f32>)| {
            let mut known = slopes.iter().zip(sigma_d).filter_map(|(own, sigma_d)| Some(((*own)?, sigma_d)));
            known.any(|(index, sigma_d)| factor * sigma_d < own_factor * own[index])
        };
        if !are_as_strict(params, &self.params)
            || sigma_d.iter().flatten().zip(own_sigma_d.iter().flatten()).any(has_lower_gate)
        {
            return None;
        }
        // Slopes that `search` lacks keep `None`, and their keypoints are dropped.
        let mut new_index = vec![None; self.tallies.len()];
        for (new, own) in slopes.iter().enumerate().filter_map(|(new, own)| Some((new, (*own)?))) {
            new_index[own] = Some(new);
        }
        let (peak, first_part) = (FIRST_PEAK_PART * params.peak_threshold, first_gate_part(params));
        let judged = |(keypoint, evidence): (&Keypoint, &Evidence)| {
            let keypoint = Keypoint { slope_index: new_index[keypoint.slope_index]?, ..*keypoint };
            let Evidence { sample_value, place_factor, edge_quotient } = *evidence;
            let of_octave = &sigma_d[(keypoint.octave - search.space.first_octave) as usize];
            let sigma_d_min = of_octave[(keypoint.level + 1) as usize][keypoint.slope_index];
            let sigma_d = sigma_d_min * place_factor;
            let sample = sample_value.abs();
            // Rounded as in the search, which multiplies in this order: the results must agree to the bit.
            let is_above_gate =
                sample >= first_part * factor * sigma_d_min && sample >= first_part * (factor * sigma_d);
            let of_sample = [(Test::PeakThreshold, sample >= peak), (Test::NoiseGate, is_above_gate)];
            let of_fit = search.limits(sigma_d).tests(keypoint.value, edge_quotient);
            let failed = of_sample.into_iter().chain(of_fit).find(|(_, passes)| !passes);
            Some(((keypoint.with_noise(sigma_d), *evidence), failed.map(|(test, _)| test)))
        };
        Some(self.keypoints.iter().zip(&self.evidence).filter_map(judged).collect())
    }

    pub(super) fn bytes(&self) -> usize {
        let described: usize = self.described.iter().filter_map(OnceLock::get).map(|one| size_of_val(&one[..])).sum();
        described
            + size_of_val(&self.described[..])
            + size_of_val(&self.rises[..])
            + size_of_val(&self.ghosts[..])
            + size_of_val(&self.keypoints[..])
            + size_of_val(&self.evidence[..])
    }
}

fn total(tallies: &[Tally]) -> Tally {
    let mut total = Tally::default();
    tallies.iter().for_each(|tally| total.merge(tally));
    total
}

pub(super) fn sigma_d(search: &Search<'_>) -> SigmaD {
    search.inputs.octaves().map(|octave| search.sigma_d(octave)).collect()
}
