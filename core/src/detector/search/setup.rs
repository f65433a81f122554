//! Constants of a search that its tiles share, and buffers that its threads reuse.

use crate::detector::noise::gate::gate_factor;
use crate::detector::noise_model::NoiseModel;
use crate::detector::params::DetectorParams;
use crate::detector::params::slope_grid::SlopeGrid;
use crate::detector::refine::MAX_MOVES;
use crate::detector::scale_space::levels::ScaleSpace;
use crate::detector::scale_space::planes::SlopeStack;
use crate::detector::search::inputs::Inputs;
use crate::detector::search::slope_window::SlopeWindow;
use crate::detector::stack::offsets::{FrameTimes, frame_offsets};
use crate::kernel::gaussian_bank::{FilterBank, FilterScratch};
use crate::kernel::stack::FrameOffset;
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::tile::Tile;
use std::sync::Mutex;

/// Number of pixels held around a tile: enough for the moves of the refinement and for the neighbours that it reads.
pub(crate) const HELD: usize = MAX_MOVES + 1;

/// Constants of a detection that its tiles share.
pub(crate) struct Search<'a> {
    pub(crate) frames: &'a [&'a Plane],
    pub(crate) times: &'a FrameTimes,
    pub(crate) size_image: (usize, usize),
    pub(crate) grid: SlopeGrid,
    /// Offsets of the frames at each slope.
    pub(crate) offsets: Vec<Vec<FrameOffset>>,
    pub(crate) space: ScaleSpace,
    /// Filters of the first octave and of the later ones.
    pub(crate) banks: (FilterBank, FilterBank),
    pub(crate) params: &'a DetectorParams,
    pub(crate) noise: &'a NoiseModel,
    pub(crate) gate_factor: f32,
    pub(crate) monitor: &'a Monitor,
    /// Buffers that no thread is using.
    pub(crate) unused: Mutex<Vec<TileScratch>>,
}

/// Buffers that a thread reuses from tile to tile.
pub(crate) struct TileScratch {
    pub(crate) stacked: Vec<Tile>,
    pub(crate) filter: FilterScratch,
    /// The level from which the next octave starts.
    pub(crate) next: Tile,
    pub(in crate::detector) window: SlopeWindow,
}

impl<'a> Search<'a> {
    /// Prepares a search of the `frames` of `inputs`.
    pub(crate) fn new(inputs: &'a Inputs, frames: &'a [&'a Plane], monitor: &'a Monitor) -> Self {
        let Inputs { times, size_image, space, params, noise, .. } = inputs;
        let grid = params.used_slopes();
        let offsets = |slope| times.of(frame_offsets(times.frame_count, slope, params.interpolation));
        Self {
            frames,
            times,
            size_image: *size_image,
            grid,
            offsets: grid.slopes().map(offsets).collect(),
            banks: (space.bank(true, space.all_levels()), space.bank(false, space.all_levels())),
            space: space.clone(),
            params,
            noise,
            gate_factor: gate_factor(params),
            monitor,
            unused: Mutex::new(Vec::new()),
        }
    }

    /// Motion stack of one of the grid's slopes.
    pub(crate) fn stack(&self, slope_index: usize) -> SlopeStack<'_> {
        let (frames, offsets) = (self.frames, &self.offsets[slope_index]);
        SlopeStack { frames, offsets, space: &self.space, size_image: self.size_image }
    }
}
