//! What localising and describing the keypoints of one octave start from.

use crate::detector::params::DetectorParams;
use crate::detector::params::slope_grid::SlopeGrid;
use crate::detector::scale_space::levels::ScaleSpace;
use crate::detector::scale_space::octave::Base;
use crate::detector::stack::refined::OctaveFrames;
use crate::kernel::offset::FrameOffset;
use crate::monitor::Monitor;

/// What is needed to describe the keypoints of one octave.
pub(in crate::detector) struct Describing<'a> {
    /// Where the octave's first level at a slope of the grid comes from.
    pub base: &'a (dyn Fn(usize) -> Base<'a> + Sync),
    /// The same for the octave before; the first octave has none.
    pub finer: Option<&'a (dyn Fn(usize) -> Base<'a> + Sync)>,
    /// Where the frames are read at each slope of the grid.
    pub offsets: &'a [Vec<FrameOffset>],
    /// The octave.
    pub octave: i32,
    /// Its size.
    pub size: (usize, usize),
    /// The image's size.
    pub size_image: (usize, usize),
    /// The slopes searched.
    pub grid: SlopeGrid,
    /// The scales searched.
    pub space: &'a ScaleSpace,
    /// The detection's parameters.
    pub params: &'a DetectorParams,
    /// The octave's frames, where features are described at their own slope.
    pub own_slopes: Option<&'a OctaveFrames<'a>>,
    /// Tells of a cancel.
    pub monitor: &'a Monitor,
    /// Told how many more keypoints are described.
    pub described: &'a (dyn Fn(usize) + Sync),
}
