//! Pictures of what the search sees: the motion-stack image and the DoG response at any slope, octave and level.

use super::motion::{frame_offsets, motion_stack};
use super::octave::{Base, DogStrip, StripScratch};
use super::params::{DetectorParams, ParamError, doc};
use super::pipeline::DetectError;
use super::scale_space::{ScaleSpace, octave_size};
use super::slope_grid::Slope;
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use rayon::prelude::*;

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
/// Where `slope` is on the grid these are the very numbers that the search compares.
///
/// # Errors
/// [`DetectError::Param`] for an octave or level that the parameters do not have, [`DetectError::Cancelled`] once `monitor` was cancelled.
pub fn dog_view(
    burst: &Burst,
    params: &DetectorParams,
    slope: Slope,
    octave: i32,
    level: i32,
    monitor: &Monitor,
) -> Result<Plane, DetectError> {
    let octaves = searched_octaves(params, burst.size());
    if !octaves.contains(&octave) {
        return Err(ParamError {
            parameter: doc::OCTAVES.name,
            problem: format!("there is no octave {octave} in this search"),
            remedy: format!("give {} to {}, or change octaves and first-octave", octaves.start, octaves.end - 1),
        }
        .into());
    }
    if !(-1..=params.levels as i32).contains(&level) {
        return Err(ParamError {
            parameter: doc::LEVELS.name,
            problem: format!("there is no DoG level {level}"),
            remedy: format!("give -1 to {}", params.levels),
        }
        .into());
    }
    let used = params.used_frames(burst.len());
    let frames: Vec<&Plane> = burst.frames[used].iter().map(|f| &**f).collect();
    let offsets = frame_offsets(frames.len(), slope, params.interpolation);
    let space = ScaleSpace::of(params);
    let mut first_level: Option<Plane> = None;
    for current in octaves {
        let size = octave_size(burst.size(), current);
        let base = match &first_level {
            None => Base::Frames { frames: &frames, offsets: &offsets, octave: current },
            Some(plane) => Base::Level(plane),
        };
        if current == octave {
            return Ok(dog_plane(&base, &space, size, (level + 1) as usize, monitor)?);
        }
        first_level = Some(next_first_level(&base, &space, size, monitor)?);
    }
    unreachable!("the octave was checked to be among those searched")
}

/// Rows that one thread makes at once.
const STRIP_ROWS: usize = 128;

/// One DoG level of a whole octave, strips in parallel.
fn dog_plane(
    base: &Base<'_>,
    space: &ScaleSpace,
    size: (usize, usize),
    level_index: usize,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let mut out = Plane::zeros(size.0, size.1);
    let chunk = STRIP_ROWS * size.0;
    out.data_mut().par_chunks_mut(chunk).enumerate().try_for_each_init(
        StripScratch::default,
        |scratch, (i, rows)| {
            monitor.check()?;
            let wanted = i * STRIP_ROWS..i * STRIP_ROWS + rows.len() / size.0;
            let mut dog = DogStrip::default();
            base.dog_strip(space, size, &wanted, scratch, &mut dog);
            rows.copy_from_slice(dog.levels[level_index].data());
            Ok(())
        },
    )?;
    Ok(out)
}

/// The first level of the next octave.
fn next_first_level(
    base: &Base<'_>,
    space: &ScaleSpace,
    size: (usize, usize),
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let (width, height) = (size.0 / 2, size.1 / 2);
    let mut out = Plane::zeros(width, height);
    let chunk = STRIP_ROWS / 2 * width;
    out.data_mut().par_chunks_mut(chunk).enumerate().try_for_each_init(
        StripScratch::default,
        |scratch, (i, rows)| {
            monitor.check()?;
            let start = i * STRIP_ROWS;
            let wanted = start..(start + 2 * (rows.len() / width)).min(size.1);
            let top = base.dog_strip(space, size, &wanted, scratch, &mut DogStrip::default());
            for (v, row) in rows.chunks_mut(width).enumerate() {
                let from = top.row(start + 2 * v);
                row.iter_mut().zip(from.chunks(2)).for_each(|(out, pair)| *out = pair[0]);
            }
            Ok(())
        },
    )?;
    Ok(out)
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
