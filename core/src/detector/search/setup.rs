//! What does not change during a search, and the space that its threads reuse: what the tiles share.

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
use crate::kernel::offset::FrameOffset;
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::tile::Tile;
use std::sync::Mutex;

/// Pixels held around a tile: the refinement moves this far and looks at a neighbour there.
pub(crate) const HELD: usize = MAX_MOVES + 1;

/// What does not change during a detection.
pub(crate) struct Search<'a> {
    pub(crate) frames: &'a [&'a Plane],
    pub(crate) times: &'a FrameTimes,
    pub(crate) size_image: (usize, usize),
    pub(crate) grid: SlopeGrid,
    /// For each slope, where its frames are read.
    pub(crate) offsets: Vec<Vec<FrameOffset>>,
    pub(crate) space: ScaleSpace,
    /// The filters of the first octave and of the later ones.
    pub(crate) banks: (FilterBank, FilterBank),
    pub(crate) params: &'a DetectorParams,
    pub(crate) noise: &'a NoiseModel,
    pub(crate) gate_factor: f32,
    pub(crate) monitor: &'a Monitor,
    /// Space that no thread is using.
    pub(crate) unused: Mutex<Vec<TileScratch>>,
}

/// Space that a thread reuses from tile to tile.
pub(crate) struct TileScratch {
    pub(crate) stacked: Vec<Tile>,
    pub(crate) filter: FilterScratch,
    /// The level from which the next octave starts.
    pub(crate) next: Tile,
    pub(in crate::detector) window: SlopeWindow,
}

impl<'a> Search<'a> {
    /// Of the `frames` of `inputs`.
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

    /// The motion stack of one of the grid's slopes.
    pub(crate) fn stack(&self, slope_index: usize) -> SlopeStack<'_> {
        let (frames, offsets) = (self.frames, &self.offsets[slope_index]);
        SlopeStack { frames, offsets, space: &self.space, size_image: self.size_image }
    }
}
