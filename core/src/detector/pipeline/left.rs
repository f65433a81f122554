//! All that a search leaves for later judgements: its keypoints with the values that its thresholds compared, and what
//! was computed about single keypoints since.
//!
//! A change of a threshold, of the rule for distinct keypoints or of the number of features changes no stack
//! and no sample of D. So its result follows from the keypoints of a search whose thresholds were not higher:
//! those that fail the new ones are left out, and the features are chosen again. Only keypoints that were never
//! described or compared before cost time.

use crate::detector::describe::Described;
use crate::detector::feature::{Keypoint, Tally, Test};
use crate::detector::noise::gate_factor;
use crate::detector::params::DetectorParams;
use crate::detector::refine::edge_limit;
use crate::detector::search::setup::{FirstLevels, Search, SlopeGroup};
use crate::detector::search::{Evidence, FIRST_PEAK_PART, Searched, first_gate_part};
use crate::plane::Plane;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// σ_D at the place of least noise, by octave, DoG level index and slope.
pub(super) type SigmaD = Vec<Vec<Vec<f32>>>;

/// Whether the result of a search with `params` follows from what a search with `searched` left: they differ only in
/// what is judged later, and `params` are as strict. (In noise with very light tails a higher gate may still be less
/// strict; then a judgement tells so.)
pub fn follows(params: &DetectorParams, searched: &DetectorParams) -> bool {
    searched.judged_as(params) == *params
        && params.validate().is_ok()
        && params.peak_threshold >= searched.peak_threshold
        && edge_limit(params.edge_threshold) <= edge_limit(searched.edge_threshold)
        && gate_factor(params) >= gate_factor(searched)
}

/// Values of one keypoint that were computed after the search; each is missing until it was needed.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// Its features.
    pub(super) described: Option<Box<[Described]>>,
    /// Whether it is at the limit of the slopes, and the snr with which that was decided.
    pub(super) at_limit: Option<(f32, bool)>,
    /// Numbers of stronger keypoints, the own snr at the comparison, and whether both stay.
    pub(super) twins: Vec<(u32, f32, bool)>,
}

/// Result of a search before the choice of features, shared by all trails that follow from it.
#[derive(Debug)]
pub(super) struct Left {
    /// Parameters of the search.
    params: DetectorParams,
    /// First levels of each octave; none for the first octave. `None` where the slopes were searched in groups: they
    /// are computed again when needed.
    pub(super) bases: Option<Vec<FirstLevels>>,
    /// Groups of slopes in which first levels that were not kept are computed again.
    pub(super) groups: Vec<SlopeGroup>,
    pub(super) keypoints: Vec<Keypoint>,
    evidence: Vec<Evidence>,
    /// Numbers of samples that the search rejected.
    pub(super) tally: Tally,
    /// The gate's factor and σ_D of the search; none where nothing is kept for later judgements.
    gate: Option<(f32, SigmaD)>,
    /// Later values of each keypoint, in the order of `keypoints`; empty where nothing is kept for later judgements.
    pub(super) known: Vec<Mutex<Known>>,
    /// Frames at the resolution of each octave, computed on first use.
    pub(super) means: Vec<OnceLock<Vec<Plane>>>,
}

/// Keypoints that pass thresholds.
#[derive(Debug)]
pub(super) struct Passing {
    pub(super) keypoints: Vec<Keypoint>,
    /// Their numbers among those that the search left.
    pub(super) numbers: Vec<u32>,
    /// Numbers of samples that the search and the thresholds reject.
    pub(super) tally: Tally,
}

impl Left {
    /// Takes the result of `search`. If it `keeps` what is computed later, judgements can follow.
    pub(super) fn new(
        search: &Search<'_>,
        Searched { keypoints, evidence, bases }: Searched,
        groups: &[SlopeGroup],
        tally: Tally,
        keeps: bool,
    ) -> Self {
        let octaves = search.octave_range();
        let known = if keeps { keypoints.iter().map(|_| Mutex::default()).collect() } else { Vec::new() };
        Self {
            params: search.params.clone(),
            bases,
            groups: groups.to_vec(),
            keypoints,
            evidence,
            tally,
            gate: keeps.then(|| (search.gate_factor, sigma_d(search))),
            known,
            means: octaves.map(|_| OnceLock::new()).collect(),
        }
    }

    /// Parameters of the search.
    pub(super) fn params(&self) -> &DetectorParams {
        &self.params
    }

    /// The keypoints that `search` would find, whose σ_D is `sigma_d` and whose parameters [follow](follows) from this
    /// one's. `None` where it might find others: where one of its limits is lower.
    pub(super) fn passing(&self, search: &Search<'_>, sigma_d: &SigmaD) -> Option<Passing> {
        let (params, factor) = (search.params, search.gate_factor);
        let (own_factor, own_sigma_d) = self.gate.as_ref().filter(|_| follows(params, &self.params))?;
        let (peak, first_part) = (FIRST_PEAK_PART * params.peak_threshold, first_gate_part(params));
        let gates = sigma_d.iter().flatten().flatten().zip(own_sigma_d.iter().flatten().flatten());
        if gates.into_iter().any(|(sigma_d, own)| factor * sigma_d < own_factor * own) {
            return None;
        }
        let (mut keypoints, mut numbers, mut tally) = (Vec::new(), Vec::new(), self.tally);
        for (number, (keypoint, evidence)) in self.keypoints.iter().zip(&self.evidence).enumerate() {
            let Evidence { sample_value, place_factor, edge_quotient } = *evidence;
            let of_octave = &sigma_d[(keypoint.octave - search.space.first_octave) as usize];
            let sigma_d_min = of_octave[(keypoint.level + 1) as usize][keypoint.slope_index];
            let sigma_d = sigma_d_min * place_factor;
            let sample = sample_value.abs();
            let is_above_gate =
                sample >= first_part * factor * sigma_d_min && sample >= first_part * (factor * sigma_d);
            let of_sample = [(Test::PeakThreshold, sample >= peak), (Test::NoiseGate, is_above_gate)];
            let of_fit = search.limits(sigma_d).tests(keypoint.value, edge_quotient);
            if let Some((test, _)) = of_sample.into_iter().chain(of_fit).find(|(_, passes)| !passes) {
                tally.reject(test, 1);
                continue;
            }
            keypoints.push(keypoint.with_noise(sigma_d));
            numbers.push(number as u32);
        }
        Some(Passing { keypoints, numbers, tally })
    }

    /// Later values of keypoint `number`, locked; `None` where nothing is kept.
    pub(super) fn known(&self, number: usize) -> Option<MutexGuard<'_, Known>> {
        // Each change is one whole value, so the data are valid even if the lock is poisoned.
        self.known.get(number).map(|known| known.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Approximate bytes of the keypoints and of their later values.
    pub(super) fn bytes(&self) -> usize {
        let known = |number: usize| {
            let known = self.known(number)?;
            let described = known.described.as_ref().map_or(0, |described| size_of_val(&described[..]));
            Some(size_of::<Mutex<Known>>() + described + size_of_val(&known.twins[..]))
        };
        let known: usize = (0..self.known.len()).filter_map(known).sum();
        known + size_of_val(&self.keypoints[..]) + size_of_val(&self.evidence[..])
    }
}

/// σ_D of a search at the place of least noise.
pub(super) fn sigma_d(search: &Search<'_>) -> SigmaD {
    let of_octave = |octave| (0..search.space.levels + 2).map(|level| search.sigma_d(octave, level)).collect();
    search.octave_range().map(of_octave).collect()
}
