//! Setup of a search, before its first tile: the frames that take part, the noise and the scales, checked and owned;
//! the constants that tiles share; the groups of slopes; and the buffers that threads reuse.
//!
//! If memory allows, all slopes are one group; otherwise there are several ([`SlopeGroup`]). A group holds the levels
//! of its own slopes and of the slopes around them, which its own are compared with or localised between. Every value
//! is computed by identical operations whatever the group, so the keypoints together are those of the whole search.

use crate::burst::Burst;
use crate::detector::feature::Tally;
use crate::detector::noise::{frame_noise, gate_factor};
use crate::detector::noise_model::warning::of_merge;
use crate::detector::noise_model::{Examined, ForSearch, NoiseModel, examine};
use crate::detector::params::{DetectorParams, Method, NoiseGate, NoiseModelKind, Slope, SlopeGrid};
use crate::detector::refine::MAX_FITS;
use crate::detector::scale_space::planes::SlopeStack;
use crate::detector::scale_space::{Base, Scale, ScaleSpace, octave_pixel, searched_octaves};
use crate::detector::search::FoundKeypoint;
use crate::detector::search::around_field::SlopesAround;
use crate::detector::search::slope_window::SlopeWindow;
use crate::detector::stack::{FrameTimes, coverage, frame_offsets};
use crate::error::Result;
use crate::kernel::gaussian_bank::{FilterBank, FilterScratch};
use crate::kernel::stack::FrameOffset;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use crate::plane::tile::Tile;
use std::borrow::Borrow;
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// Radius of the disc around a feature in which masked samples are counted, in σ of the feature.
const DISC_SIGMAS: f32 = 2.0;

/// Number of pixels held around a tile: enough for the moves of the refinement and for the neighbours that it reads.
pub(crate) const HELD: usize = MAX_FITS + 1;

/// Constants of a detection that its tiles share.
pub(crate) struct Search<'a> {
    pub(crate) inputs: &'a Inputs,
    pub(crate) params: &'a DetectorParams,
    pub(crate) space: &'a ScaleSpace,
    pub(crate) planes: Vec<&'a Plane>,
    pub(crate) grid: SlopeGrid,
    /// Offsets of the frames, `[slope][frame]`.
    pub(crate) offsets: Vec<Vec<FrameOffset>>,
    pub(crate) banks: (FilterBank, FilterBank),
    pub(crate) monitor: &'a Monitor,
    pub(crate) unused: Mutex<Vec<TileScratch>>,
}

pub(crate) struct TileScratch {
    pub(crate) stacked: Vec<Tile>,
    pub(crate) filter: FilterScratch,
    /// The level from which the next octave starts.
    pub(crate) next: Tile,
    pub window: SlopeWindow,
}

impl<'a> Search<'a> {
    pub(crate) fn new(inputs: &'a Inputs, monitor: &'a Monitor) -> Self {
        let Inputs { space, params, .. } = inputs;
        let grid = params.used_slopes();
        let offsets = grid.slopes().map(|slope| inputs.offsets(slope)).collect();
        let banks = (space.bank(true, space.all_levels()), space.bank(false, space.all_levels()));
        let (planes, unused) = (inputs.first_planes(), Mutex::new(Vec::new()));
        Self { inputs, params, space, planes, grid, offsets, banks, monitor, unused }
    }

    pub(crate) fn stack(&self, slope_index: usize) -> SlopeStack<'_> {
        let (frames, offsets) = (&self.planes, &self.offsets[slope_index]);
        SlopeStack { frames, offsets, space: self.space, size_image: self.inputs.size_image }
    }

    /// Source of an octave's first level at a slope: the frames for the first octave, else its part of `bases`.
    pub(crate) fn base<'s>(&'s self, bases: &'s [FirstLevels], octave: i32, slope_index: usize) -> Base<'s> {
        match (octave - self.space.first_octave) as usize {
            0 => self.stack(slope_index).base(),
            later => Base::Level(bases[later].at(slope_index)),
        }
    }
}

/// Owned inputs of a search. Cheap to clone: the frames and the noise model are shared.
#[derive(Debug, Clone)]
pub(crate) struct Inputs {
    /// Frames that take part, cleaned by the noise model.
    pub(crate) frames: Vec<Arc<Plane>>,
    /// Used frames, as read.
    pub(crate) read: Vec<Arc<Plane>>,
    /// The frames binned for the first octave; none where it reads them unbinned.
    pub(crate) binned: Arc<[Plane]>,
    pub(crate) times: FrameTimes,
    pub(crate) frames_used: Range<usize>,
    pub(crate) size_image: (usize, usize),
    pub(crate) space: ScaleSpace,
    pub(crate) params: DetectorParams,
    pub(crate) noise: Arc<NoiseModel>,
    pub(crate) gate_factor: f32,
    /// Slopes that are searched at each place; `None` for all.
    pub(crate) around: Option<Arc<SlopesAround>>,
}

impl Inputs {
    /// Checks the parameters and examines the noise.
    pub(crate) fn new(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Self> {
        params.validate_for(&burst.positions, burst.size())?;
        let frames_used = params.used_frames(burst.len());
        monitor.report(Stage::Noise, 0.0);
        let space = ScaleSpace::of(params);
        let Examined { model, frames, kept } = known_noise(burst, params, &space, monitor)?;
        // A strict gate promises a rate of false features, which needs a noise that can be measured.
        if let Some(refused) = model.flattened.filter(|f| params.noise_gate == NoiseGate::Strict && !f.is_measurable())
        {
            return Err(refused.against_strict());
        }
        let times = FrameTimes { positions: burst.positions.part(frames_used.clone()), kept };
        let read = burst.frames[frames_used.clone()].to_vec();
        let (size_image, noise, gate_factor) = (burst.size(), Arc::new(model), gate_factor(params));
        let planes: Vec<&Plane> = frames.iter().map(|frame| &**frame).collect();
        let binned = space.binned(&planes, monitor)?.into();
        let (params, around) = (params.clone(), None);
        Ok(Self { frames, read, binned, times, frames_used, size_image, space, params, noise, gate_factor, around })
    }

    /// Inputs with other parameters, which may differ only in those judged after the search.
    pub(crate) fn judged_with(&self, params: &DetectorParams) -> Self {
        Self { params: params.clone(), gate_factor: gate_factor(params), ..self.clone() }
    }

    pub(crate) fn planes(&self) -> Vec<&Plane> {
        self.frames.iter().map(|frame| &**frame).collect()
    }

    pub(crate) fn first_planes(&self) -> Vec<&Plane> {
        if self.binned.is_empty() { self.planes() } else { self.binned.iter().collect() }
    }

    pub(crate) fn searches(&self, place: [f32; 2], index: usize) -> bool {
        self.around.as_ref().is_none_or(|around| around.searches(place, index))
    }

    pub(crate) fn holds(&self, index: usize) -> bool {
        self.around.as_ref().is_none_or(|around| around.holds(index))
    }

    pub(crate) fn octaves(&self) -> Range<i32> {
        searched_octaves(&self.params, self.size_image)
    }

    pub(crate) fn offsets(&self, slope: Slope) -> Vec<FrameOffset> {
        self.times.of(frame_offsets(&self.times.positions, slope, self.params.rules.interpolation))
    }

    /// σ_D at `octave` and `level` (−1 … S) of the mean over the frames at `offsets`, at the place of least noise.
    pub(crate) fn sigma_d(&self, octave: i32, level: i32, slope: Slope, offsets: &[FrameOffset]) -> f32 {
        self.noise.sigma_d(&self.space, Scale { octave, level }, (slope, offsets), self.gate_factor)
    }

    /// √(N / number of frames at `offsets` that see the octave pixel (x, y)), times the relative noise there.
    pub(crate) fn place_factor(&self, octave: i32, offsets: &[FrameOffset], (x, y): (usize, usize)) -> f32 {
        let (pixel, size) = (octave_pixel(octave), self.size_image);
        let to_image = |at: usize, n: usize| ((at as f32 * pixel) as usize).min(n - 1);
        let at = (to_image(x, size.0), to_image(y, size.1));
        let seeing = self.seeing(&self.frames, octave, offsets, at);
        (offsets.len() as f32 / seeing).sqrt() * self.noise.place_factor(octave, offsets, at, size)
    }

    /// Number (1 or more) of `frames`, read at `offsets`, that see image pixel `at` and all that `octave` reads for it.
    pub(crate) fn seeing(
        &self,
        frames: &[impl Borrow<Plane>],
        octave: i32,
        offsets: &[FrameOffset],
        at: (usize, usize),
    ) -> f32 {
        coverage(frames, offsets, at, DISC_SIGMAS * self.space.sigma_image(octave, 0.0) as f32).1.max(1.0)
    }

    /// Seen share (0 … 1) of a feature's disc at (u, v), input pixels, in the covering frames; `None` without masks.
    pub(crate) fn seen_share(&self, offsets: &[FrameOffset], (u, v): (f32, f32), sigma: f32) -> Option<f32> {
        if self.frames.iter().all(|frame| frame.mask().is_none()) {
            return None;
        }
        let pixel = |x: f32, n: usize| (x.round().max(0.0) as usize).min(n - 1);
        let at = (pixel(u, self.size_image.0), pixel(v, self.size_image.1));
        let (covering, seeing) = coverage(&self.frames, offsets, at, DISC_SIGMAS * sigma);
        Some(if covering > 0.0 { seeing / covering } else { 1.0 })
    }

    /// Whether frame `index` of those that take part, read at `offset`, sees the pixel `at` of the image.
    pub(crate) fn sees(&self, index: usize, offset: &FrameOffset, at: (usize, usize)) -> bool {
        offset.sees(&self.frames[index], at.0, at.1)
    }
}

/// Noise of the burst by the model in the parameters, and the frames that are searched: with [`NoiseModelKind::White`],
/// or with too little data for a local model, all used frames, unchanged. The scene's motion is sought in the range
/// that [encloses](SlopeGrid::enclosing) the slopes, so that a search of a few more has the same noise.
pub(in crate::detector) fn known_noise(
    burst: &Burst,
    params: &DetectorParams,
    space: &ScaleSpace,
    monitor: &Monitor,
) -> Result<Examined, Cancelled> {
    let used = params.used_frames(burst.len());
    let frames = &burst.frames[used.clone()];
    let local = match params.noise_model {
        NoiseModelKind::Local => {
            let positions = &burst.positions.part(used.clone());
            let slopes: Vec<Slope> = params.used_slopes().enclosing(positions.span() as f32).slopes().collect();
            let octaves = searched_octaves(params, burst.size());
            let search = ForSearch { space, octaves, slopes: &slopes, flicker: params.flicker, positions };
            examine(frames, burst.quantisation_step, &search, monitor)?
        }
        NoiseModelKind::White => None,
    };
    match local {
        Some(examined) => Ok(examined),
        None => {
            let mut model = NoiseModel::white(frame_noise(burst, used, monitor)?);
            model.warnings.extend((params.method == Method::Merge).then(of_merge));
            Ok(Examined { model, frames: frames.to_vec(), kept: (0..frames.len()).collect() })
        }
    }
}

/// Group of consecutive slopes in running order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SlopeGroup {
    /// Slopes whose keypoints are found.
    pub(crate) own: Range<usize>,
    /// Slopes that are computed for that: the group's own and the slopes around them.
    pub(crate) visited: Range<usize>,
}

impl SlopeGroup {
    pub(crate) fn whole(count: usize) -> Self {
        Self { own: 0..count, visited: 0..count }
    }

    /// Divides `count` slopes into as few nearly equal groups as visit at most `max` slopes each: their own and those
    /// up to `reach` steps beside them, or all for `None`. `None` where no such groups exist.
    pub(crate) fn cut(count: usize, reach: Option<usize>, max: usize) -> Option<Vec<Self>> {
        if count <= max {
            return Some(vec![Self::whole(count)]);
        }
        let reach = reach?;
        // Slopes beside a group are computed again by its neighbours: a group must own some besides.
        let own = max.checked_sub(2 * reach).filter(|own| *own > 0)?;
        let groups = count.div_ceil(own);
        let cut = |i: usize| i * count / groups;
        let around = |own: &Range<usize>| own.start.saturating_sub(reach)..(own.end + reach).min(count);
        let group = |own: Range<usize>| Self { visited: around(&own), own };
        Some((0..groups).map(|i| group(cut(i)..cut(i + 1))).collect())
    }
}

/// First levels (s = −1) of one octave at consecutive slopes.
#[derive(Debug, Default)]
pub(crate) struct FirstLevels {
    pub(crate) first_slope: usize,
    /// Shared with searches that [continue](super::known) this one.
    pub(crate) planes: Vec<Arc<Plane>>,
}

impl FirstLevels {
    /// First level at slope `slope_index` of the grid, which is among those held.
    pub(crate) fn at(&self, slope_index: usize) -> &Plane {
        &self.planes[slope_index - self.first_slope]
    }
}

/// Slopes of a search that an earlier one has searched already. Where each slope is searched for itself, a search is
/// the sum of the searches of its slopes: one whose range was widened, moved or made finer takes over the keypoints and
/// the first levels that an earlier search of the same frames left at the slopes that both have.
pub(crate) struct KnownSlopes<'a> {
    /// For each slope of the grid its index in the grid of the earlier search; `None` where it is new.
    pub(crate) slopes: Vec<Option<usize>>,
    /// First levels of each octave at the slopes of the earlier search.
    pub(crate) bases: &'a [FirstLevels],
    /// Keypoints at these slopes, with the indices of this search's grid.
    pub(crate) keypoints: Vec<FoundKeypoint>,
    /// Numbers of samples by slope of the grid; zeros where it is new.
    pub(crate) tallies: Vec<Tally>,
}

impl KnownSlopes<'_> {
    /// First level of the octave `later` octaves after the first at slope `index`, if it is known.
    pub(super) fn first_level(&self, later: usize, index: usize) -> Option<Arc<Plane>> {
        self.slopes[index].map(|earlier| self.bases[later].planes[earlier].clone())
    }

    /// Adds the known keypoints of `octave` to its `tiles`, in the order of one search of all slopes.
    pub(super) fn merge_into(
        &self,
        tiles: &mut [Vec<FoundKeypoint>],
        octave: i32,
        (columns, rows): (Vec<Range<usize>>, Vec<Range<usize>>),
    ) {
        let part = |parts: &[Range<usize>], at: u32| parts.partition_point(|part| part.end <= at as usize);
        for found in self.keypoints.iter().filter(|(keypoint, _)| keypoint.octave == octave) {
            let [x, y] = found.0.sample;
            tiles[part(&rows, y) * columns.len() + part(&columns, x)].push(*found);
        }
        // The sort is stable: keypoints of one slope keep the order in which they were found.
        tiles.iter_mut().for_each(|tile| tile.sort_by_key(|(keypoint, _)| keypoint.slope_index));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn groups_own_every_slope_once_and_visit_what_they_need(
            count in 1usize..90, reach in 0usize..9, max in 0usize..100,
        ) {
            let Some(groups) = SlopeGroup::cut(count, Some(reach), max) else {
                prop_assert!(max < count && max <= 2 * reach);
                return Ok(());
            };
            let owned: Vec<usize> = groups.iter().flat_map(|group| group.own.clone()).collect();
            prop_assert_eq!(owned, (0..count).collect::<Vec<_>>());
            for SlopeGroup { own, visited } in &groups {
                prop_assert!(!own.is_empty() && visited.len() <= max);
                prop_assert_eq!(visited.start, own.start.saturating_sub(if groups.len() > 1 { reach } else { 0 }));
                prop_assert!(visited.end == count || visited.end >= own.end + reach);
            }
        }
    }

    #[test]
    fn what_needs_all_slopes_is_not_cut() {
        let groups = |reach, max| SlopeGroup::cut(7, reach, max).map(|groups| groups.len());
        assert_eq!([groups(None, 7), groups(None, 6), groups(Some(1), 5)], [Some(1), None, Some(3)]);
    }
}
