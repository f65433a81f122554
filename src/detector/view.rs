//! Pictures of what the search sees: the motion-stack image and the DoG response at any slope, octave and level.

use super::motion::{frame_offsets, motion_stack};
use super::octave::{Base, DogTile, OctaveFilters, Pixels, dog_tile, stack_tiles};
use super::params::{DetectorParams, ParamError, doc};
use super::pipeline::DetectError;
use super::scale_space::{ScaleSpace, octave_size};
use super::slope_grid::Slope;
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::bank::FilterScratch;
use crate::plane::tile::{Region, Tile, cuts, split_mut};
use rayon::prelude::*;
use std::ops::Range;

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

/// Columns and rows that one thread makes at once.
const TILE: (usize, usize) = (320, 128);

/// The Gaussian level indices `levels` of an octave of `size`, in parallel: `write` is given the differences of each tile (and the last level where the next
/// octave starts from it), with its place and the part of `out` that is its own. `out` is `size` divided by `step`.
fn each_tile(
    base: &Base<'_>,
    (space, levels): (&ScaleSpace, Range<usize>),
    size: (usize, usize),
    (out, step): (&mut Plane, usize),
    monitor: &Monitor,
    write: impl Fn(&DogTile, &Tile, &Region, Vec<&mut [f32]>) + Sync,
) -> Result<(), Cancelled> {
    let first = matches!(base, Base::Frames { .. });
    let filters = OctaveFilters::new(space, &space.bank(first, levels.clone()), &levels, size);
    let keeps = levels.contains(&space.levels);
    let (columns, rows) = (cuts(size.0, TILE.0), cuts(size.1, TILE.1));
    let divided = |parts: &[Range<usize>]| -> Vec<Range<usize>> {
        parts.iter().map(|part| part.start / step..part.end / step).collect()
    };
    let parts = split_mut(out, &divided(&columns), &divided(&rows));
    let places = rows.iter().flat_map(|rows| columns.iter().map(move |columns| (rows.clone(), columns.clone())));
    let jobs: Vec<_> = places.zip(parts).collect();
    jobs.into_par_iter().try_for_each_init(
        || (FilterScratch::default(), DogTile::default(), Tile::default(), Vec::new()),
        |(scratch, dog, next, stacked), ((rows, columns), part)| {
            monitor.check()?;
            let region = Region { columns, rows };
            let pixels = match base {
                Base::Frames { frames, offsets, octave } => {
                    let inputs = filters.inputs(&region);
                    stack_tiles(frames, std::slice::from_ref(offsets), *octave, &inputs, stacked);
                    Pixels::Stacked(&stacked[0])
                }
                Base::Level(plane) => Pixels::Level(plane),
            };
            dog_tile(&filters, pixels, &region, scratch, dog, keeps.then_some(&mut *next), &mut |_, _| ());
            write(dog, next, &region, part);
            Ok(())
        },
    )
}

/// One DoG level of a whole octave.
fn dog_plane(
    base: &Base<'_>,
    space: &ScaleSpace,
    size: (usize, usize),
    level_index: usize,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let mut out = Plane::zeros(size.0, size.1);
    let levels = level_index..level_index + 2;
    each_tile(base, (space, levels), size, (&mut out, 1), monitor, |dog, _, region, part| {
        for (v, row) in region.rows.clone().zip(part) {
            row.copy_from_slice(dog.levels[0].row(v));
        }
    })?;
    Ok(out)
}

/// The first level of the next octave.
fn next_first_level(
    base: &Base<'_>,
    space: &ScaleSpace,
    size: (usize, usize),
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let mut out = Plane::zeros(size.0 / 2, size.1 / 2);
    let levels = space.levels..space.levels + 1;
    each_tile(base, (space, levels), size, (&mut out, 2), monitor, |_, level, region, part| {
        for (v, row) in part.into_iter().enumerate() {
            let from = level.row(region.rows.start + 2 * v);
            row.iter_mut().zip(from.chunks(2)).for_each(|(out, pair)| *out = pair[0]);
        }
    })?;
    Ok(out)
}

/// The octaves that a search with `params` visits in an image of `size` = (columns, rows): those asked for, as long as their shorter side
/// has [`super::params::MIN_OCTAVE_SIDE`] pixels. At least the first one.
pub fn searched_octaves(params: &DetectorParams, size: (usize, usize)) -> Range<i32> {
    let first = params.first_octave;
    let side = size.0.min(size.1);
    let fits = |o: i32| (if o < 0 { side * 2 } else { side >> o }) >= super::params::MIN_OCTAVE_SIDE;
    let end = (first..first + params.octaves as i32).take_while(|&o| fits(o)).last().unwrap_or(first) + 1;
    first..end
}
