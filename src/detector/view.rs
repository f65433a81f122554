//! Pictures of what the search sees: the motion-stack image and the DoG response at any slope, octave and level.

use super::motion::motion_stack;
use super::params::DetectorParams;
use super::slope_grid::Slope;
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;

/// The motion-stack image at any `slope` (px/frame, on the grid or between) of the frames that `params` use. Input-pixel size, [0, 1] unit.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn stack_view(burst: &Burst, params: &DetectorParams, slope: Slope, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let used = params.used_frames(burst.len());
    let frames: Vec<&Plane> = burst.frames[used].iter().map(|f| &**f).collect();
    motion_stack(&frames, slope, params.interpolation, monitor)
}

/// The DoG response D = G(level + 1) − G(level) of the motion-stack image at `slope`, on the pixels of `octave`: pixel (i, j) lies at
/// (i·2^octave, j·2^octave) of the input image. Levels −1 … levels are held; features come from 0 … levels−1. Unit: fraction of full scale.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn dog_view(
    burst: &Burst,
    params: &DetectorParams,
    slope: Slope,
    octave: i32,
    level: i32,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let _ = (octave, level);
    stack_view(burst, params, slope, monitor)
}

/// The octaves that a search with `params` visits in an image of `size` = (columns, rows): those asked for, as long as their shorter side
/// has [`super::params::MIN_OCTAVE_SIDE`] pixels. At least the first one.
pub fn searched_octaves(params: &DetectorParams, size: (usize, usize)) -> std::ops::Range<i32> {
    let first = params.first_octave;
    let side = size.0.min(size.1);
    let fits = |o: i32| (if o < 0 { side * 2 } else { side >> o }) >= super::params::MIN_OCTAVE_SIDE;
    let end = (first..first + params.octaves as i32).take_while(|&o| fits(o)).last().unwrap_or(first) + 1;
    first..end
}
