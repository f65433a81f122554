//! Pictures of what the search sees: the motion-stack image and the DoG response at any slope, octave and level, and
//! the noise by place.

use super::error::DetectError;
use super::noise_model::pyramid::sample_at;
use super::params::{DetectorParams, ParamError, doc};
use super::search::inputs::known_noise;
use crate::burst::Burst;
use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::levels::{ScaleSpace, octave_size, searched_octaves};
use crate::detector::scale_space::octave::{Base, DogTile, OctaveFilters, Pixels, dog_tile, stack_tiles};
use crate::detector::stack::offsets::{frame_offsets, motion_stack};
use crate::kernel::gaussian_bank::FilterScratch;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::tile::{Region, Tile, cuts, split_mut};
use rayon::prelude::*;
use std::ops::Range;

/// The motion-stack image at any `slope` (px/frame, on the grid or between) of the frames that `params` use.
/// Input-pixel size, [0, 1] unit.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn stack_view(burst: &Burst, params: &DetectorParams, slope: Slope, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let used = params.used_frames(burst.len());
    let frames: Vec<&Plane> = burst.frames[used].iter().map(|f| &**f).collect();
    motion_stack(&frames, slope, params.interpolation, monitor)
}

/// The DoG response D = G(level + 1) − G(level) of the motion-stack image at `slope`, on the pixels of `octave`: pixel
/// (i, j) lies at (i·2^octave, j·2^octave) of the input image. Levels −1 … levels are held; features come from 0 …
/// levels−1. Unit: fraction of full scale. Where `slope` is on the grid these are the very numbers that the search
/// compares, unless it searched cleaned frames (the local noise model leaves frames out and takes stripes, hot pixels
/// and flicker off): the picture is of the frames as they are.
///
/// # Errors
/// [`DetectError::Param`] for an octave or level that the parameters do not have, [`DetectError::Cancelled`] once
/// `monitor` was cancelled.
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

/// Where the noise is how strong: σ of the noise of one frame at each pixel of the image, fraction of full scale, as
/// the search of `params` takes it at its finest octave (see [`super::noise_model`]). The same everywhere for white
/// noise.
///
/// # Errors
/// [`DetectError::Param`] for parameters that make no sense for the burst, [`DetectError::Cancelled`] once `monitor`
/// was cancelled.
pub fn noise_map(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Plane, DetectError> {
    params.validate_for(burst.len(), burst.size())?;
    let noise = known_noise(burst, params, &ScaleSpace::of(params), monitor)?.model;
    let (width, height) = burst.size();
    let cells = noise.sigma_map((width, height), NOISE_CELL_PX);
    let at = |u, v| sample_at(&cells, NOISE_CELL_PX, u as f32, v as f32);
    Ok(Plane::from_fn(width, height, at))
}

/// Side of the squares between whose middles a map of the noise is interpolated, pixels: the finest squares whose
/// brightness the gate looks up.
const NOISE_CELL_PX: f32 = 8.0;

/// Columns and rows that one thread makes at once.
const TILE: (usize, usize) = (320, 128);

/// The Gaussian level indices `levels` of an octave of `size`, in parallel: `write` is given the differences of each
/// tile (and the last level where the next octave starts from it), with its place and the part of `out` that is its
/// own. `out` is `size` divided by `step`.
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

#[cfg(test)]
mod tests {
    use super::super::{NoiseModelKind, SlopeGrid};
    use super::*;
    use crate::synth::NoiseCase;

    #[test]
    fn a_map_of_the_noise_shows_where_it_is_stronger() {
        let burst = NoiseCase::NoisyHalf.burst((640, 400), 6, 0.02, 7, &Monitor::default()).expect("not cancelled");
        let map = |noise_model| {
            let params =
                DetectorParams { noise_model, slopes: SlopeGrid::line(-1.0..=1.0, 3), ..DetectorParams::default() };
            noise_map(&burst, &params, &Monitor::default()).expect("a map")
        };
        let local = map(NoiseModelKind::Local);
        assert_eq!(local.size(), burst.size());
        for (u, sigma) in [(40, 0.02), (600, 0.06)] {
            assert!((local.at(u, 200) / sigma - 1.0).abs() < 0.2, "{u}: {}", local.at(u, 200));
        }
        let white = map(NoiseModelKind::White);
        assert!(white.data().iter().all(|x| *x == white.data()[0]) && white.at(0, 0) > 0.02);
    }

    #[test]
    fn a_map_of_the_noise_needs_parameters_that_fit() {
        let burst = NoiseCase::White.burst((64, 48), 3, 0.02, 1, &Monitor::default()).expect("not cancelled");
        let params = DetectorParams { levels: 0, ..DetectorParams::default() };
        assert!(matches!(noise_map(&burst, &params, &Monitor::default()), Err(DetectError::Param(_))));
    }
}
