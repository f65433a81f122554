//! Pictures of the search's steps: motion stack and DoG response at any slope, octave and level, and noise by place.

use super::combine::{Combine, combined_stack};
use super::field::{MotionField, in_focus, motion_field};
use super::noise_model::reading::sample_at;
use super::params::{DetectorParams, Slope, doc};
use super::search::setup::{Inputs, known_noise};
use crate::burst::{Burst, Positions};
use crate::detector::scale_space::planes::{SlopeStack, dog_plane, whole};
use crate::detector::scale_space::{Base, ScaleSpace, octave_size, searched_octaves};
use crate::detector::stack::{by_rows, coverage, frame_offsets, motion_stack, stack_part};
use crate::error::{Error, Result};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::tile::Region;
use std::ops::Range;
use std::sync::Arc;

/// Motion-stack image at any `slope` (px/frame) of the frames that `params` use. Input-pixel size, [0, 1] unit.
///
/// ```
/// use burstscope_core::detector::{Slope, view::stack_view};
/// use burstscope_core::{DetectorParams, Monitor, synth::demo_burst};
/// let sign = stack_view(&demo_burst(), &DetectorParams::default(), Slope::new(-2.1, 0.0), &Monitor::default())?;
/// assert_eq!(sign.size(), demo_burst().size());
/// # Ok::<(), burstscope_core::Cancelled>(())
/// ```
pub fn stack_view(burst: &Burst, params: &DetectorParams, slope: Slope, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let (frames, positions) = used(burst, params);
    motion_stack(&frames, &positions, slope, params.rules.interpolation, monitor)
}

/// Frames of `burst` on the pixels of `octave` (1 or more), each the mean of a square about it: see
/// [`stack_part_view`].
pub fn coarse_frames(burst: &Burst, octave: i32, monitor: &Monitor) -> Result<Vec<Plane>, Cancelled> {
    let ((columns, rows), step) = (burst.size(), 1 << octave);
    let window = |at: usize, count: usize| (at * step).saturating_sub(step / 2)..count.min(at * step + step / 2 + 1);
    let coarse = |frame: &Arc<Plane>| {
        let row_of = |y: usize, row: &mut [f32]| {
            let (seen, mut sums) = (window(y, rows), vec![0.0; columns]);
            seen.clone().for_each(|v| sums.iter_mut().zip(frame.row(v)).for_each(|(sum, x)| *sum += x));
            for (x, mean) in row.iter_mut().enumerate() {
                let of = window(x, columns);
                *mean = sums[of.clone()].iter().sum::<f32>() / (of.len() * seen.len()) as f32;
            }
        };
        by_rows(octave_size(burst.size(), octave), row_of, monitor)
    };
    burst.frames.iter().map(coarse).collect()
}

/// Part `region` of the motion-stack image at `slope` (px/frame of the input image) on the pixels of `octave`, for
/// looking at it before [`stack_view`] is there. `frames` are all frames of the burst or, from octave 1 on, its
/// [`coarse_frames`]; at octave 0 the values are those of [`stack_view`].
pub fn stack_part_view(
    (burst, frames): (&Burst, &[&Plane]),
    params: &DetectorParams,
    slope: Slope,
    (octave, region): (i32, &Region),
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let (used, pixel) = (params.used_frames(burst.len()), (octave as f32).exp2());
    let (positions, slope) = (burst.positions.part(used.clone()), Slope::new(slope.u / pixel, slope.v / pixel));
    stack_part(&frames[used], &positions, slope, params.rules.interpolation, region, monitor)
}

/// Combination of the shifted frames at any `slope`, as [`stack_view`] shows their mean.
pub fn combined_view(
    burst: &Burst,
    params: &DetectorParams,
    slope: Slope,
    combine: Combine,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let (frames, positions) = used(burst, params);
    combined_stack(&frames, &positions, slope, params.rules.interpolation, combine, monitor)
}

/// DoG response D = G(level + 1) − G(level) of the motion-stack image at `slope`, on the pixels of `octave`: pixel (i,
/// j) lies at (i·2^octave, j·2^octave) of the input image. Levels −1 … levels exist; features come from 0 … levels−1.
/// Unit: fraction of full scale. Frames are taken as they are: for a `slope` on the grid the values are bitwise those
/// that the search compares, unless the local noise model cleaned the frames.
///
/// # Errors
/// An octave or level that the parameters do not have.
pub fn dog_view(
    burst: &Burst,
    params: &DetectorParams,
    slope: Slope,
    octave: i32,
    level: i32,
    monitor: &Monitor,
) -> Result<Plane> {
    let octaves = check_level(params, burst.size(), octave, level)?;
    let ((mut frames, positions), space) = (used(burst, params), ScaleSpace::of(params));
    let binned = space.binned(&frames, monitor)?;
    // A coarse first octave starts from the binned frames.
    if !binned.is_empty() {
        frames = binned.iter().collect();
    }
    let offsets = frame_offsets(&positions, slope, params.rules.interpolation);
    let stack = SlopeStack { frames: &frames, offsets: &offsets, space: &space, size_image: burst.size() };
    let size = octave_size(burst.size(), octave);
    let first_level;
    let base = if octave == octaves.start {
        stack.base()
    } else {
        first_level = stack.first_level(octave, &whole(size), monitor)?;
        Base::Level(&first_level)
    };
    Ok(dog_plane(&base, &space, size, (level + 1) as usize, monitor)?)
}

fn used<'b>(burst: &'b Burst, params: &DetectorParams) -> (Vec<&'b Plane>, Positions) {
    let used = params.used_frames(burst.len());
    (burst.frames[used.clone()].iter().map(|frame| &**frame).collect(), burst.positions.part(used))
}

/// Checks that the search has `octave` and `level`, and returns all its octaves in images of `size` (columns, rows).
///
/// # Errors
/// An octave or level that the parameters do not have.
pub fn check_level(params: &DetectorParams, size: (usize, usize), octave: i32, level: i32) -> Result<Range<i32>> {
    let octaves = searched_octaves(params, size);
    if !octaves.contains(&octave) {
        let remedy = format!("give {} to {}, or change octaves and first-octave", octaves.start, octaves.end - 1);
        return Err(Error::param(doc::OCTAVES.name, format!("there is no octave {octave} in this search"), remedy));
    }
    if !(-1..=params.levels as i32).contains(&level) {
        let remedy = format!("give -1 to {}", params.levels);
        return Err(Error::param(doc::LEVELS.name, format!("there is no DoG level {level}"), remedy));
    }
    Ok(octaves)
}

/// σ of one frame's noise at each pixel, fraction of full scale, at the finest octave; uniform for white noise.
///
/// # Errors
/// Parameters that make no sense for the burst.
pub fn noise_map(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Plane> {
    params.validate_for(&burst.positions, burst.size())?;
    let noise = known_noise(burst, params, &ScaleSpace::of(params), monitor)?.model;
    let (width, height) = burst.size();
    let cells = noise.sigma_map((width, height), NOISE_CELL_PX);
    Ok(Plane::from_fn(width, height, |u, v| sample_at(&cells, NOISE_CELL_PX, u as f32, v as f32)))
}

/// σ of the noise in D (fraction of full scale) at each pixel of `octave`, as the gate uses it, at any `slope`
/// (px/frame, on the grid or between) and `level` (−1 … levels): a candidate must reach the gate's factor times this.
///
/// # Errors
/// Parameters that make no sense for the burst, or do not have the octave or level.
pub fn gate_noise_map(
    burst: &Burst,
    params: &DetectorParams,
    slope: Slope,
    octave: i32,
    level: i32,
    monitor: &Monitor,
) -> Result<Plane> {
    check_level(params, burst.size(), octave, level)?;
    let inputs = Inputs::new(burst, params, &monitor.silent())?;
    let offsets = inputs.offsets(slope);
    let min = inputs.sigma_d(octave, level, slope, &offsets);
    // As the search forms the product, so that the map has its bits.
    let at = |x, y| min * inputs.place_factor(octave, &offsets, (x, y));
    Ok(map_of(octave_size(burst.size(), octave), at, monitor)?)
}

/// Share (0 … 1) of the kept frames that see each pixel of the image at `slope` (px/frame, on the grid or between):
/// they cover it, and no mask hides it. Where fewer do, the mean over them is noisier.
///
/// # Errors
/// Parameters that make no sense for the burst.
pub fn coverage_view(burst: &Burst, params: &DetectorParams, slope: Slope, monitor: &Monitor) -> Result<Plane> {
    let inputs = Inputs::new(burst, params, &monitor.silent())?;
    let (offsets, size) = (inputs.offsets(slope), inputs.size_image);
    let share = |u, v| coverage(&inputs.frames, &offsets, (u, v), 0.0).1 / offsets.len().max(1) as f32;
    Ok(map_of(size, share, monitor)?)
}

/// Field of motion of the burst as a search with `params` finds it; `None` where [`motion_field`] finds none.
///
/// # Errors
/// Parameters that make no sense for the burst.
pub fn field_view(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Option<MotionField>> {
    let inputs = Inputs::new(burst, params, &monitor.silent())?;
    Ok(motion_field(&inputs.planes(), &inputs.times, &params.used_slopes(), monitor)?)
}

/// Mean of the frames with every place shifted by its own motion: [`in_focus`], from the field of [`field_view`].
///
/// # Errors
/// As [`field_view`].
pub fn in_focus_view(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Option<Plane>> {
    let inputs = Inputs::new(burst, params, &monitor.silent())?;
    let field = motion_field(&inputs.planes(), &inputs.times, &params.used_slopes(), monitor)?;
    Ok(field.map(|field| in_focus(&inputs.planes(), &inputs.times, &field)))
}

/// Plane of `size` with the value of `f` at each (column, row); rows in parallel.
fn map_of(size: (usize, usize), f: impl Fn(usize, usize) -> f32 + Sync, monitor: &Monitor) -> Result<Plane, Cancelled> {
    by_rows(size, |y, row| row.iter_mut().enumerate().for_each(|(x, value)| *value = f(x, y)), monitor)
}

/// Side of the squares between whose centres a map of the noise is interpolated, pixels.
const NOISE_CELL_PX: f32 = 8.0;

#[cfg(test)]
mod tests {
    use super::super::pipeline::{Keeping, search_with_trail};
    use super::super::{Scale, SlopeExtrema, SlopeGrid};
    use super::*;
    use crate::synth::NoiseCase;

    #[test]
    fn the_gate_s_map_is_what_the_search_compares_with() {
        let burst = NoiseCase::NoisyHalf.burst((160, 120), 5, 0.02, 7, &Monitor::default()).expect("not cancelled");
        let monitor = Monitor::default();
        for slope_extrema in [SlopeExtrema::Each, SlopeExtrema::Joint] {
            let slopes = SlopeGrid::line(-2.0..=2.0, 5);
            let params = DetectorParams { slopes, octaves: 2, slope_extrema, ..DetectorParams::default() };
            let trail = search_with_trail(&burst, &params, Keeping::ANEW, &monitor).expect("not cancelled");
            let all: Vec<usize> = (0..trail.frames().0.len()).collect();
            for (octave, level, slope) in [(0, 1, Slope::new(2.0, 0.0)), (1, 2, Slope::new(-0.7, 0.0))] {
                let map = gate_noise_map(&burst, &params, slope, octave, level, &monitor).expect("a map");
                assert_eq!(map.size(), octave_size(burst.size(), octave));
                for (x, y) in [(1, 30), (20, 5), (40, 55), (map.width() - 1, map.height() - 1)] {
                    let place = ((x << octave) as f32, (y << octave) as f32);
                    let scale = Scale { octave, level };
                    assert_eq!(map.at(x, y), trail.sigma_d_at(scale, (place, slope), &all), "({x}, {y})");
                }
            }
            let slope = Slope::new(2.0, 0.0);
            let share = coverage_view(&burst, &params, slope, &monitor).expect("a map");
            for (u, v) in [(0, 3), (80, 60), (159, 119)] {
                let (count, _) = coverage(&burst.frames, &trail.offsets(slope), (u, v), 0.0);
                assert_eq!(share.at(u, v), count / all.len() as f32);
            }
            assert!(share.at(0, 3) < 1.0 && share.at(80, 60) == 1.0);
        }
        let wrong = gate_noise_map(&burst, &DetectorParams::default(), Slope::default(), 9, 0, &monitor);
        assert!(wrong.is_err_and(|error| error.subject == doc::OCTAVES.name));
    }
}
