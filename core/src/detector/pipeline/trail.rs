//! What a detection leaves behind when it is to be asked why: the frames as they were searched, the first levels of the
//! coarser octaves if there is memory for them, all keypoints with the ones that removed them, and which keypoint each
//! feature comes from.
//!
//! Nothing here decides anything. Whoever explains a detection runs the search's own functions again on the few samples
//! in question (see [`Trail::neighbourhood`]); the values have the same bits, because those of a tile do not depend on
//! the tile.

use crate::detector::describe::point_response::point_response;
use crate::detector::describe::two_motions::{FramesOfOctaves, Motions};
use crate::detector::distinct::{self, Blob};
use crate::detector::feature::Detection;
use crate::detector::keypoint::Keypoint;
use crate::detector::noise_model::NoiseModel;
use crate::detector::params::slope_grid::Slope;
use crate::detector::params::{DetectorParams, Distinct};
use crate::detector::scale_space::levels::{ScaleSpace, octave_size};
use crate::detector::search::groups::FirstLevels;
use crate::detector::search::inputs::Inputs;
use crate::detector::search::setup::Search;
use crate::detector::stack::offsets::coverage;
use crate::kernel::offset::FrameOffset;
use crate::monitor::Monitor;
use crate::plane::Plane;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// What identifies the sample of a keypoint: octave, level, slope and place.
type SampleKey = (i32, i32, usize, [u32; 2]);

/// Keypoints that remove one another form chains; those farther off than this many links of one are not asked.
const CHAIN_LINKS: f32 = 6.0;

/// A detection and what it was made with.
#[derive(Debug)]
pub struct Trail {
    pub(super) inputs: Inputs,
    /// For each octave the first levels; none for the first octave. `None` where the slopes were searched in groups:
    /// they are made again when something is asked.
    pub(super) bases: Option<Vec<FirstLevels>>,
    keypoints: Vec<Keypoint>,
    covered_by: Vec<Option<usize>>,
    /// For each described feature, strongest first and before any were cut off, the keypoint it comes from.
    ranked: Vec<usize>,
    by_sample: HashMap<SampleKey, usize>,
    /// The keypoints that stayed, by row.
    stayed: Vec<(usize, Blob)>,
    /// σ_D where it is least, by octave, DoG level index and slope.
    pub(super) sigma_d: Vec<Vec<Vec<f32>>>,
    /// By octave, the frames at its resolution.
    means: Vec<OnceLock<Vec<Plane>>>,
    pub(super) detection: Detection,
}

impl Trail {
    pub(super) fn new(
        inputs: Inputs,
        bases: Option<Vec<FirstLevels>>,
        keypoints: Vec<Keypoint>,
        covered_by: Vec<Option<usize>>,
        ranked: Vec<usize>,
        detection: Detection,
    ) -> Self {
        let means = inputs.octaves().map(|_| OnceLock::new()).collect();
        let (by_sample, stayed, sigma_d) = (HashMap::new(), Vec::new(), Vec::new());
        Self { inputs, bases, keypoints, covered_by, ranked, by_sample, stayed, sigma_d, means, detection }
    }

    /// With what questions need beyond the detection itself.
    pub(super) fn ready(mut self) -> Self {
        let key = |k: &Keypoint| (k.octave, k.level, k.slope_index, k.sample);
        self.by_sample = self.keypoints.iter().enumerate().map(|(index, k)| (key(k), index)).collect();
        let kept = self.keypoints.iter().enumerate().filter(|(index, _)| self.covered_by[*index].is_none());
        self.stayed = kept.map(|(index, k)| (index, Blob::of(k, &self.inputs.space))).collect();
        self.stayed.sort_by(|a, b| a.1.v.total_cmp(&b.1.v));
        let monitor = Monitor::default();
        let sigma_d = self.with_search(&monitor, |search| {
            let levels = 0..search.space.levels + 2;
            let of_octave = |octave| levels.clone().map(|level| search.sigma_d(octave, level)).collect();
            self.octaves().map(of_octave).collect()
        });
        self.sigma_d = sigma_d;
        self
    }

    /// Does `work` with the search as it was.
    pub(super) fn with_search<T>(&self, monitor: &Monitor, work: impl FnOnce(&Search<'_>) -> T) -> T {
        let planes = self.inputs.planes();
        work(&Search::new(&self.inputs, &planes, monitor))
    }

    /// Bytes of what is held by each sample and by each keypoint, without the frames among `others`, which somebody
    /// else holds too. It grows as questions are asked.
    pub fn bytes_beside(&self, others: &[Arc<Plane>]) -> usize {
        let plane = |plane: &Plane| size_of_val(plane.data());
        let is_own = |frame: &&Arc<Plane>| !others.iter().any(|other| Arc::ptr_eq(other, frame));
        let frames: usize = self.inputs.frames.iter().filter(is_own).map(|frame| plane(frame)).sum();
        let means = self.means.iter().filter_map(OnceLock::get).flatten();
        let bases = self.bases.iter().flatten().flat_map(FirstLevels::planes);
        let planes: usize = bases.chain(means).map(plane).sum();
        let Detection { features, descriptors, .. } = &self.detection;
        let found = size_of_val(&features[..]) + size_of_val(&descriptors[..]) + size_of_val(&self.ranked[..]);
        let of_keypoint = size_of::<(Keypoint, Option<usize>, SampleKey, usize)>();
        frames + planes + found + of_keypoint * self.keypoints.len() + size_of_val(&self.stayed[..])
    }

    /// What was found.
    pub fn detection(&self) -> &Detection {
        &self.detection
    }

    /// The parameters it was found with.
    pub fn params(&self) -> &DetectorParams {
        &self.inputs.params
    }

    /// (columns, rows) of a frame.
    pub fn size_image(&self) -> (usize, usize) {
        self.inputs.size_image
    }

    /// The octaves that were searched.
    pub fn octaves(&self) -> Range<i32> {
        self.inputs.octaves()
    }

    /// (columns, rows) of an octave.
    pub fn octave_size(&self, octave: i32) -> (usize, usize) {
        octave_size(self.inputs.size_image, octave)
    }

    /// The scales that were searched.
    pub fn space(&self) -> &ScaleSpace {
        &self.inputs.space
    }

    /// What is known of the noise.
    pub fn noise(&self) -> &Arc<NoiseModel> {
        &self.inputs.noise
    }

    /// The frames that took part, with their indices among those used, and how many those are.
    pub fn frames(&self) -> (&[Arc<Plane>], &[usize], usize) {
        (&self.inputs.frames, &self.inputs.times.kept, self.inputs.times.frame_count)
    }

    /// All keypoints that passed the tests of the search, those that show the same blob as a stronger one among them.
    pub fn keypoints(&self) -> &[Keypoint] {
        &self.keypoints
    }

    /// The stronger keypoint whose blob keypoint `index` shows too, if there is one.
    pub fn covered_by(&self, index: usize) -> Option<usize> {
        self.covered_by[index]
    }

    /// Whether keypoint `index` would stay among those around it if keypoints were held distinct by another `radius`
    /// and `scale_ratio`. Those around it are asked anew with one another: what was removed may stay then, and remove
    /// others.
    pub fn would_stay(&self, index: usize, radius: f32, scale_ratio: f32) -> bool {
        let own = self.keypoints[index].in_image();
        let near = |k: &Keypoint| {
            let (u, v, sigma) = k.in_image();
            let reach = CHAIN_LINKS * radius.max(self.distinct_radius()) * sigma.max(own.2);
            (u - own.0).hypot(v - own.1) <= reach
        };
        let around: Vec<usize> = (0..self.keypoints.len()).filter(|&other| near(&self.keypoints[other])).collect();
        let blobs: Vec<Blob> =
            around.iter().map(|&other| Blob::of(&self.keypoints[other], &self.inputs.space)).collect();
        let covered = self.with_motions(|motions| {
            let are_two = |a: usize, b: usize| motions.are_two(&self.keypoints[around[a]], &self.keypoints[around[b]]);
            distinct::covered_by(&blobs, distinct::Rule { radius, scale_ratio }, are_two, &Monitor::default())
                .expect("nobody cancels it")
        });
        around.iter().zip(covered).any(|(&other, by)| other == index && by.is_none())
    }

    fn distinct_radius(&self) -> f32 {
        if let Distinct::Radius(radius) = self.inputs.params.distinct { radius } else { 0.0 }
    }

    /// Does `work` with what tells whether two keypoints at one place are two things.
    fn with_motions<T>(&self, work: impl FnOnce(&Motions<'_, '_>) -> T) -> T {
        let planes = self.inputs.planes();
        let frames = FramesOfOctaves::new(&planes, &self.inputs.times, self.octaves()).with_means(&self.means);
        let Inputs { times, size_image, space, params, .. } = &self.inputs;
        let interpolation = params.interpolation;
        work(&Motions { frames: &frames, times, size_image: *size_image, space, interpolation })
    }

    /// The keypoint that stayed and would remove `keypoint`, which is none of those found, by the rule for distinct
    /// keypoints.
    pub fn would_be_covered_by(&self, keypoint: &Keypoint) -> Option<usize> {
        let params = &self.inputs.params;
        let Distinct::Radius(radius) = params.distinct else {
            return None;
        };
        let rule = distinct::Rule { radius, scale_ratio: params.distinct_scale };
        let blob = Blob::of(keypoint, &self.inputs.space);
        // A stronger one reaches this far at most: its scale is at most the ratio larger.
        let reach = radius * params.distinct_scale * blob.sigma;
        let first = self.stayed.partition_point(|(_, other)| other.v < blob.v - reach);
        let last = self.stayed.partition_point(|(_, other)| other.v <= blob.v + reach);
        let blobs = self.stayed[first..last].iter().copied();
        self.with_motions(|motions| {
            distinct::would_cover(&blob, blobs, rule, |index| motions.are_two(&self.keypoints[index], keypoint))
        })
    }

    /// The keypoint that feature `index` of the detection comes from.
    pub fn keypoint_of_feature(&self, index: usize) -> usize {
        self.ranked[index]
    }

    /// The places of a keypoint's features in the ranking by strength, those beyond `max_features` among them.
    pub fn ranks_of(&self, keypoint: usize) -> impl Iterator<Item = usize> + '_ {
        self.ranked.iter().enumerate().filter(move |(_, of)| **of == keypoint).map(|(rank, _)| rank)
    }

    /// The keypoint that was found at the sample (column, row) of an octave, level and slope.
    pub fn keypoint_at(&self, octave: i32, level: i32, slope_index: usize, sample: [u32; 2]) -> Option<usize> {
        self.by_sample.get(&(octave, level, slope_index, sample)).copied()
    }

    /// Where the frames that took part are read at `slope`.
    pub fn offsets(&self, slope: Slope) -> Vec<FrameOffset> {
        let times = &self.inputs.times;
        times.of(crate::detector::stack::offsets::frame_offsets(
            times.frame_count,
            slope,
            self.inputs.params.interpolation,
        ))
    }

    /// σ_D at `octave` and `level` (−1 … S) for slope `slope_index` of the grid, where the noise is least.
    pub fn sigma_d_min(&self, (octave, level): (i32, i32), slope_index: usize) -> f32 {
        self.sigma_d[(octave - self.octaves().start) as usize][(level + 1) as usize][slope_index]
    }

    /// σ_D at `octave` and `level` (0 … S−1) for any slope, at the image's place (u, v): the noise of the mean over the
    /// `chosen` frames (indices among those that took part) that cover it.
    pub fn sigma_d_at(
        &self,
        (octave, level): (i32, i32),
        (place, slope): ((f32, f32), Slope),
        chosen: &[usize],
    ) -> f32 {
        let Inputs { space, noise, size_image: size, .. } = &self.inputs;
        let all = self.offsets(slope);
        let offsets: Vec<FrameOffset> = chosen.iter().map(|&index| all[index]).collect();
        let pixel = |x: f32, n: usize| (x.max(0.0) as usize).min(n - 1);
        let at = (pixel(place.0, size.0), pixel(place.1, size.1));
        let gate = self.detection.noise_gate_factor;
        let min = noise.sigma_d(space, (octave, level), (slope, &offsets), gate);
        // The factor for the place samples the frames that took part, all of them.
        let covering = coverage(&offsets, at.0, at.1, *size).max(1);
        min * (offsets.len() as f32 / covering as f32).sqrt() * noise.place_factor(octave, &all, at, *size)
    }

    /// D of the mean of the `chosen` frames (indices among those that took part) at each of the DoG `levels` of
    /// `octave`, along the way through `place` (input pixels, at mid-burst) at any `slope`: what the search would find
    /// there, up to interpolation. The octave must be one that was searched.
    pub fn point_response(
        &self,
        (octave, levels): (i32, Range<i32>),
        (place, slope): ((f32, f32), Slope),
        chosen: &[usize],
    ) -> Vec<f32> {
        let planes = self.inputs.planes();
        let frames = FramesOfOctaves::new(&planes, &self.inputs.times, self.octaves()).with_means(&self.means);
        let Inputs { space, params, size_image, .. } = &self.inputs;
        point_response(
            frames.of(octave),
            (space, octave, levels),
            *size_image,
            (place, slope),
            params.interpolation,
            chosen,
        )
    }
}
