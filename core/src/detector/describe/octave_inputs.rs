//! Inputs of localising and describing the keypoints of one octave.

use crate::detector::params::DetectorParams;
use crate::detector::params::slope_grid::SlopeGrid;
use crate::detector::scale_space::levels::ScaleSpace;
use crate::detector::scale_space::octave::Base;
use crate::detector::stack::refined::OctaveFrames;
use crate::kernel::stack::FrameOffset;
use crate::monitor::Monitor;

/// Inputs for describing the keypoints of one octave.
pub(in crate::detector) struct Describing<'a> {
    /// Source of the octave's first level at a slope of the grid.
    pub base: &'a (dyn Fn(usize) -> Base<'a> + Sync),
    /// Source of the finer octave's first level; `None` for the first octave.
    pub finer: Option<&'a (dyn Fn(usize) -> Base<'a> + Sync)>,
    /// Offsets of the frames at each slope of the grid.
    pub offsets: &'a [Vec<FrameOffset>],
    /// Index of the octave.
    pub octave: i32,
    /// Size (columns, rows) of the octave.
    pub size: (usize, usize),
    /// Size (columns, rows) of the image.
    pub size_image: (usize, usize),
    /// Slopes of the search.
    pub grid: SlopeGrid,
    /// Scales of the search.
    pub space: &'a ScaleSpace,
    /// Parameters of the detection.
    pub params: &'a DetectorParams,
    /// Frames at the octave's resolution, where features are described at their own slope.
    pub own_slopes: Option<&'a OctaveFrames<'a>>,
    /// Monitor for cancellation.
    pub monitor: &'a Monitor,
    /// Called with the number of keypoints described since the last call.
    pub described: &'a (dyn Fn(usize) + Sync),
}
