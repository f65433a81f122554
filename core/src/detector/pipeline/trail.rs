//! Data that a detection keeps to explain its result. Questions run the search's own functions again on a few samples
//! (see [`Trail::neighbourhood`]), with bitwise equal values, because a value does not depend on its tile.

use crate::burst::Positions;
use crate::detector::along::Along;
use crate::detector::coherence::Evenness;
use crate::detector::distinct::{Blob, Deciding, Rule};
use crate::detector::feature::{Detection, Feature, Keypoint, Test};
use crate::detector::memory::on_threads;
use crate::detector::noise_model::NoiseModel;
use crate::detector::params::{DetectorParams, Distinct, Slope};
use crate::detector::pipeline::choice::{Choice, Chooser, Verdict};
use crate::detector::pipeline::outcome::{Outcome, PassingKeypoints, SigmaD, sigma_d};
use crate::detector::scale_space::{Scale, ScaleSpace, octave_size};
use crate::detector::search::setup::{Inputs, Search};
use crate::kernel::patch::{Patch, PatchScratch};
use crate::kernel::stack::FrameOffset;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use crate::plane::tile::Region;
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// Key of a keypoint's sample: octave, level, slope and place.
pub(super) type SampleKey = (i32, i32, usize, [u32; 2]);

pub(super) fn sample_key(keypoint: &Keypoint) -> SampleKey {
    (keypoint.octave, keypoint.level, keypoint.slope_index, keypoint.sample)
}

/// Radius around a keypoint in links of a chain: keypoints that remove one another form chains.
const CHAIN_LINKS: f32 = 6.0;

/// A detection and the data from which it was computed.
#[derive(Debug)]
pub struct Trail {
    pub(super) inputs: Inputs,
    /// Result of the search, which trails for other thresholds share.
    pub(super) outcome: Arc<Outcome>,
    passing: PassingKeypoints,
    choice: Choice,
    /// The choice without a maximum number of features, computed on first use.
    uncut: OnceLock<Choice>,
    by_sample: HashMap<SampleKey, usize>,
    /// Keypoints that are known to have stayed, sorted by row.
    stayed: Vec<(usize, Blob)>,
    pub(super) sigma_d: SigmaD,
    pub(super) detection: Detection,
    /// Seconds that the search behind this trail took, with the description of its features.
    pub search_secs: f32,
}

impl Trail {
    pub(super) fn new(
        inputs: Inputs,
        outcome: Arc<Outcome>,
        passing: PassingKeypoints,
        choice: Choice,
        detection: Detection,
    ) -> Self {
        let (by_sample, stayed, sigma_d, uncut) = (HashMap::new(), Vec::new(), Vec::new(), OnceLock::new());
        let search_secs = detection.times.total_secs();
        Self { inputs, outcome, passing, choice, uncut, by_sample, stayed, sigma_d, detection, search_secs }
    }

    /// Adds the lookup tables for questions; a detection without questions need not pay for them.
    pub(super) fn ready(mut self) -> Self {
        self.by_sample = self.keypoints().iter().map(sample_key).zip(0..).collect();
        let blob = |&index: &usize| (index, Blob::of(&self.keypoints()[index], &self.inputs.space));
        self.stayed = self.choice.distinct.iter().map(blob).collect();
        self.stayed.sort_by(|a, b| a.1.v.total_cmp(&b.1.v));
        self.sigma_d = self.with_search(&Monitor::default(), sigma_d);
        self
    }

    pub(super) fn with_search<T>(&self, monitor: &Monitor, work: impl FnOnce(&Search<'_>) -> T) -> T {
        work(&Search::new(&self.inputs, monitor))
    }

    /// D along any motion, at single places.
    pub(crate) fn along(&self) -> Along<'_> {
        Along::with_means(&self.inputs, &self.outcome.means)
    }

    /// Memory of the trail, bytes, without the frames among `others`. It grows as questions are answered.
    pub fn bytes_beside(&self, others: &[Arc<Plane>]) -> usize {
        let plane = |plane: &Plane| size_of_val(plane.data());
        // Frames that others hold too are counted there.
        let is_own = |frame: &&Arc<Plane>| !others.iter().any(|other| Arc::ptr_eq(other, frame));
        let frames: usize = self.inputs.frames.iter().filter(is_own).map(|frame| plane(frame)).sum();
        let means = self.outcome.means.iter().filter_map(OnceLock::get).flatten();
        let bases = self.outcome.bases.iter().flatten().flat_map(|levels| &levels.planes).map(|level| &**level);
        let planes: usize = bases.chain(means).chain(&*self.inputs.binned).map(plane).sum();
        let Detection { features, descriptors, .. } = &self.detection;
        let found = size_of_val(&features[..]) + size_of_val(&descriptors[..]) + size_of_val(&self.choice.ranked[..]);
        let of_keypoint = size_of::<(Keypoint, Verdict, SampleKey, usize)>();
        frames
            + planes
            + self.outcome.bytes()
            + found
            + of_keypoint * self.keypoints().len()
            + size_of_val(&self.stayed[..])
    }

    /// Whether both trails come from one search: each can then be [judged](Trail::rejudged) from the other.
    pub fn shares_search(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.outcome, &other.outcome)
    }

    /// Detection that this trail explains.
    pub fn detection(&self) -> &Detection {
        &self.detection
    }

    /// Parameters of the detection, which may be stricter than those of the [search](Trail::searched_with).
    pub fn params(&self) -> &DetectorParams {
        &self.inputs.params
    }

    /// Parameters of the search behind this trail: parameters that [follow](super::follows) from them need no search.
    pub fn searched_with(&self) -> &DetectorParams {
        &self.outcome.params
    }

    /// Size (columns, rows) of a frame.
    pub fn size_image(&self) -> (usize, usize) {
        self.inputs.size_image
    }

    /// Octaves that were searched.
    pub fn octaves(&self) -> Range<i32> {
        self.inputs.octaves()
    }

    /// Size (columns, rows) of an octave.
    pub fn octave_size(&self, octave: i32) -> (usize, usize) {
        octave_size(self.inputs.size_image, octave)
    }

    /// Scales that were searched.
    pub fn space(&self) -> &ScaleSpace {
        &self.inputs.space
    }

    /// Noise model with which the gate and all σ_D were computed.
    pub fn noise(&self) -> &Arc<NoiseModel> {
        &self.inputs.noise
    }

    /// Frames of the search, their indices among the frames used, and the positions of all frames used.
    pub fn frames(&self) -> (&[Arc<Plane>], &[usize], &Positions) {
        (&self.inputs.frames, &self.inputs.times.kept, &self.inputs.times.positions)
    }

    /// All keypoints that passed the tests of the search, including those that show the same blob as a stronger one.
    pub fn keypoints(&self) -> &[Keypoint] {
        &self.passing.keypoints
    }

    /// Index of the stronger keypoint on the same blob as keypoint `index`; `None` for [cut](Trail::is_cut) ones too.
    pub fn covered_by(&self, index: usize) -> Option<usize> {
        if let Verdict::CoveredBy(by) = self.choice.verdicts[index] { Some(by) } else { None }
    }

    /// Whether keypoint `index` is too weak for any of its features to be kept. It may not have been compared.
    pub fn is_cut(&self, index: usize) -> bool {
        self.choice.verdicts[index] == Verdict::Cut
    }

    /// First test that a keypoint that [is cut](Trail::is_cut) would fail if all features were kept.
    pub fn fails_uncut(&self, index: usize) -> Option<Test> {
        matches!(self.uncut().verdicts[index], Verdict::CoveredBy(_)).then_some(Test::Duplicate)
    }

    /// The choice without a maximum number of features. The first call takes as long as describing all keypoints.
    fn uncut(&self) -> &Choice {
        if self.inputs.params.max_features == 0 {
            return &self.choice;
        }
        let choose = || {
            let monitor = Monitor::default();
            let search = &Search::new(&self.inputs, &monitor);
            let chooser = Chooser { search, outcome: &self.outcome, passing: &self.passing, along: &self.along() };
            chooser.choose(0).expect("nobody cancels it").1
        };
        // On own threads: a thread of the pool that waits here might run a job that waits for this result.
        let on_own_threads = || {
            std::thread::scope(|scope| {
                scope.spawn(|| on_threads(0, choose)).join().unwrap_or_else(|panic| resume_unwind(panic))
            })
        };
        self.uncut.get_or_init(on_own_threads)
    }

    /// Whether keypoint `index` would stay with another `radius` and `scale_ratio` for distinct keypoints. All
    /// keypoints around are compared again: removed ones may then stay, and remove others.
    pub fn would_stay(&self, index: usize, radius: f32, scale_ratio: f32) -> bool {
        let keypoints = self.keypoints();
        let own = keypoints[index].in_image();
        let own_radius = if let Distinct::Radius(radius) = self.inputs.params.distinct { radius } else { 0.0 };
        let near = |k: &Keypoint| {
            let (u, v, sigma) = k.in_image();
            (u - own.0).hypot(v - own.1) <= CHAIN_LINKS * radius.max(own_radius) * sigma.max(own.2)
        };
        // Only the chains of keypoints around decide, not the whole picture.
        let around: Vec<usize> = (0..keypoints.len()).filter(|&other| near(&keypoints[other])).collect();
        let blobs: Vec<Blob> = around.iter().map(|&other| Blob::of(&keypoints[other], &self.inputs.space)).collect();
        let along = self.along();
        let are_two = |a: usize, b: usize| along.are_two(&keypoints[around[a]], &keypoints[around[b]]);
        let mut deciding = Deciding::new(&blobs, Rule { radius, scale_ratio });
        let own = around.partition_point(|&other| other < index);
        deciding.decide(&[own], are_two, &Monitor::default()).expect("nobody cancels it");
        deciding.covered_by(own).is_none()
    }

    /// Index of the kept keypoint that would remove `keypoint`, one that was not found, by the rule for distinct
    /// keypoints. Keypoints that [are cut](Trail::is_cut) may not be compared.
    pub fn would_be_covered_by(&self, keypoint: &Keypoint) -> Option<usize> {
        let params = &self.inputs.params;
        let Distinct::Radius(radius) = params.distinct else { return None };
        let rule = Rule { radius, scale_ratio: params.distinct_scale };
        let blob = Blob::of(keypoint, &self.inputs.space);
        // Reach of a stronger keypoint that covers this one: its scale is larger by the ratio at most.
        let reach = radius * params.distinct_scale * blob.sigma;
        let first = self.stayed.partition_point(|(_, other)| other.v < blob.v - reach);
        let last = self.stayed.partition_point(|(_, other)| other.v <= blob.v + reach);
        let along = self.along();
        let stronger = self.stayed[first..last].iter().filter(|(_, other)| other.rank >= blob.rank);
        let covering = stronger
            .filter(|(index, other)| other.covers(&blob, rule) && !along.are_two(&self.keypoints()[*index], keypoint));
        covering.max_by(|a, b| a.1.rank.total_cmp(&b.1.rank)).map(|(index, _)| *index)
    }

    /// Index of the keypoint of feature `index` of the detection, or of those beyond `max_features`.
    pub fn keypoint_of_feature(&self, index: usize) -> usize {
        self.choice.ranked.get(index).copied().unwrap_or_else(|| self.uncut().ranked[index])
    }

    /// Number of features including those beyond `max_features`.
    pub fn ranked(&self) -> usize {
        self.uncut().ranked.len()
    }

    /// Rank by strength that a keypoint that [is cut](Trail::is_cut) has, or would have, among all features.
    pub fn rank_uncut(&self, keypoint: usize) -> usize {
        let ranked = &self.uncut().ranked;
        let strength = |index: usize| self.keypoints()[index].strength();
        let own = ranked.iter().position(|of| *of == keypoint);
        own.unwrap_or_else(|| ranked.partition_point(|of| strength(*of) > strength(keypoint)))
    }

    /// Ranks by strength of a keypoint's features that are kept.
    pub fn ranks_of(&self, keypoint: usize) -> impl Iterator<Item = usize> + '_ {
        self.choice.ranked.iter().enumerate().filter(move |(_, of)| **of == keypoint).map(|(rank, _)| rank)
    }

    /// Index of the keypoint that was found at the sample (column, row) of an octave, level and slope.
    pub fn keypoint_at(&self, octave: i32, level: i32, slope_index: usize, sample: [u32; 2]) -> Option<usize> {
        self.by_sample.get(&(octave, level, slope_index, sample)).copied()
    }

    /// Offsets at which the frames that took part are read at `slope`.
    pub fn offsets(&self, slope: Slope) -> Vec<FrameOffset> {
        self.inputs.offsets(slope)
    }

    /// σ_D at `octave` and `level` (−1 … S) for slope `slope_index` of the grid, at the place of least noise.
    pub fn sigma_d_min(&self, Scale { octave, level }: Scale, slope_index: usize) -> f32 {
        self.sigma_d[(octave - self.octaves().start) as usize][(level + 1) as usize][slope_index]
    }

    /// σ_D at `octave` and `level` (0 … S−1) for any slope, at the image's place (u, v): the noise of the mean over the
    /// `chosen` frames (indices among those that took part) that see it.
    pub fn sigma_d_at(&self, scale: Scale, (place, slope): ((f32, f32), Slope), chosen: &[usize]) -> f32 {
        self.along().sigma_d_at(scale, (place, slope), chosen)
    }

    /// Indices, among the kept frames, of those that cover the place (u, v), input pixels, at `slope` without a mask.
    pub fn showing(&self, place: (f32, f32), slope: Slope) -> Vec<usize> {
        self.along().showing(place, slope)
    }

    /// Share (0 … 1) of a disc of scale `sigma` px at `place` that its frames see at `slope`; `None` without masks.
    pub fn seen_share(&self, place: (f32, f32), slope: Slope, sigma: f32) -> Option<f32> {
        self.inputs.seen_share(&self.inputs.offsets(slope), place, sigma)
    }

    /// Evenness of the frames' responses along the motion of each of `features`, in their order.
    pub fn evenness_of(&self, features: &[Feature], monitor: &Monitor) -> Result<Vec<Evenness>, Cancelled> {
        let done = AtomicUsize::new(0);
        monitor.report(Stage::Frames, 0.0);
        let along = self.along();
        let evenness = |feature: &Feature| {
            let evenness = along.evenness(feature, monitor)?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            monitor.report(Stage::Frames, done as f32 / features.len() as f32);
            Ok(evenness)
        };
        features.par_iter().map(evenness).collect()
    }

    /// Mean of the `chosen` kept frames, shifted by `slope`, in a rectangle of the image, less its value in the middle.
    pub fn stack_part(&self, region: &Region, slope: Slope, chosen: &[usize]) -> Plane {
        let along = self.along();
        let frames = along.of(0);
        let (planes, offsets) = frames.chosen(slope, chosen);
        let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
        let pixels = |range: &Range<usize>| range.start as i64..range.end as i64;
        let (columns, rows) = (pixels(&region.columns), pixels(&region.rows));
        let base = frames.base(&planes, &offsets);
        base.patch(self.inputs.size_image, columns, rows.clone(), &mut scratch, &mut patch);
        let values = rows.flat_map(|v| patch.row(v).iter().copied());
        Plane::from_vec(region.columns.len(), region.rows.len(), values.collect())
    }
}
