//! Whole planes of the scale space of one slope: a DoG level, the first level of any octave.
//!
//! The search computes all levels of a tile at once; here one level of one slope is made, with bitwise equal values.

use crate::detector::scale_space::{
    Base, DogTile, OctaveFilters, Pixels, ScaleSpace, dog_tile, octave_size, stack_tiles,
};
use crate::kernel::gaussian_bank::FilterScratch;
use crate::kernel::stack::FrameOffset;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::tile::{Region, Tile, cuts, split_mut};
use rayon::prelude::*;
use std::ops::Range;

/// Size (columns, rows) of the tiles, each of which one thread computes.
const TILE: (usize, usize) = (320, 128);

/// Motion stack of one slope, and its scales.
#[derive(Debug, Clone, Copy)]
pub struct SlopeStack<'a> {
    /// Of one size, in time order; [binned](ScaleSpace::binned) where the scale space bins.
    pub frames: &'a [&'a Plane],
    pub offsets: &'a [FrameOffset],
    pub space: &'a ScaleSpace,
    pub size_image: (usize, usize),
}

impl<'a> SlopeStack<'a> {
    pub fn base(&self) -> Base<'a> {
        Base::Frames { frames: self.frames, offsets: self.offsets, octave: self.space.first_octave }
    }

    /// First level of `octave`, which is not the first one: its pixels in `region` and those of the same tiles. Other
    /// pixels are 0, and take no memory on systems that allocate it on first use.
    pub fn first_level(&self, octave: i32, region: &Region, monitor: &Monitor) -> Result<Plane, Cancelled> {
        let finer = octave - 1;
        let size = octave_size(self.size_image, finer);
        let doubled = |range: &Range<usize>, n: usize| 2 * range.start..(2 * range.end).min(n);
        let wanted = Region { columns: doubled(&region.columns, size.0), rows: doubled(&region.rows, size.1) };
        // Recursion down to the frames: each octave needs whole tiles of the finer one, and no more.
        if finer == self.space.first_octave {
            return next_first_level(&self.base(), self.space, size, &wanted, monitor);
        }
        let levels = next_level(self.space);
        let filters = OctaveFilters::new(self.space, &self.space.bank(false, levels.clone()), &levels, size);
        let inputs = filters.inputs(&whole_tiles(&wanted, size));
        let base = self.first_level(finer, &inputs, monitor)?;
        next_first_level(&Base::Level(&base), self.space, size, &wanted, monitor)
    }

    /// First levels of the octaves from the one after the first up to `last`, whole and in this order.
    pub fn first_levels(&self, last: i32, monitor: &Monitor) -> Result<Vec<Plane>, Cancelled> {
        let mut planes: Vec<Plane> = Vec::new();
        for octave in self.space.first_octave..last {
            let size = octave_size(self.size_image, octave);
            let base = planes.last().map_or_else(|| self.base(), Base::Level);
            planes.push(next_first_level(&base, self.space, size, &whole(size), monitor)?);
        }
        Ok(planes)
    }
}

pub fn whole(size: (usize, usize)) -> Region {
    Region { columns: 0..size.0, rows: 0..size.1 }
}

/// Index of the Gaussian level from which the next octave starts.
pub fn next_level(space: &ScaleSpace) -> Range<usize> {
    space.levels..space.levels + 1
}

fn holding(cuts: &[Range<usize>], wanted: &Range<usize>) -> Range<usize> {
    let first = cuts.partition_point(|part| part.end <= wanted.start);
    let end = cuts.partition_point(|part| part.start < wanted.end);
    first..end.max(first)
}

/// Smallest region of whole tiles, in an octave of `size`, that holds `wanted`, which is not empty.
fn whole_tiles(wanted: &Region, size: (usize, usize)) -> Region {
    let covered = |wanted: &Range<usize>, cuts: Vec<Range<usize>>| {
        let held = holding(&cuts, wanted);
        cuts[held.start].start..cuts[held.end - 1].end
    };
    Region {
        columns: covered(&wanted.columns, cuts(size.0, TILE.0)),
        rows: covered(&wanted.rows, cuts(size.1, TILE.1)),
    }
}

/// Computes the Gaussian level indices `levels` of the tiles of an octave of `size` that overlap `wanted`, in parallel.
/// `write` gets the differences of each tile (and the last level where the next octave starts from it), its place and
/// its part of the plane that is made, whose size is `size` divided by `step`.
fn each_tile(
    base: &Base<'_>,
    space: &ScaleSpace,
    levels: Range<usize>,
    (size, step): ((usize, usize), usize),
    wanted: &Region,
    monitor: &Monitor,
    write: impl Fn(&DogTile, &Tile, &Region, Vec<&mut [f32]>) + Sync,
) -> Result<Plane, Cancelled> {
    let mut out = Plane::zeros(size.0 / step, size.1 / step);
    let first = matches!(base, Base::Frames { .. });
    let filters = OctaveFilters::new(space, &space.bank(first, levels.clone()), &levels, size);
    let keeps = levels.contains(&space.levels);
    let (columns, rows) = (cuts(size.0, TILE.0), cuts(size.1, TILE.1));
    let (held_columns, held_rows) = (holding(&columns, &wanted.columns), holding(&rows, &wanted.rows));
    let divided = |parts: &[Range<usize>]| -> Vec<Range<usize>> {
        parts.iter().map(|part| part.start / step..part.end / step).collect()
    };
    // Parts are cut before the tiles are chosen, so that a tile finds its own by place.
    let parts = split_mut(&mut out, &divided(&columns), &divided(&rows));
    let places = (0..rows.len()).flat_map(|row| (0..columns.len()).map(move |column| (row, column)));
    let jobs: Vec<_> = places
        .zip(parts)
        .filter(|((row, column), _)| held_rows.contains(row) && held_columns.contains(column))
        .collect();
    jobs.into_par_iter().try_for_each_init(
        || (FilterScratch::default(), DogTile::default(), Tile::default(), Vec::new()),
        |(scratch, dog, next, stacked), ((row, column), part)| {
            monitor.check()?;
            let region = Region { columns: columns[column].clone(), rows: rows[row].clone() };
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
    )?;
    Ok(out)
}

/// Computes one DoG level of a whole octave.
pub fn dog_plane(
    base: &Base<'_>,
    space: &ScaleSpace,
    size: (usize, usize),
    level_index: usize,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let levels = level_index..level_index + 2;
    each_tile(base, space, levels, (size, 1), &whole(size), monitor, |dog, _, region, part| {
        region.rows.clone().zip(part).for_each(|(v, row)| row.copy_from_slice(dog.levels[0].row(v)));
    })
}

/// First level of the octave after one of `size`, as far as it comes from that octave's pixels `wanted`.
fn next_first_level(
    base: &Base<'_>,
    space: &ScaleSpace,
    size: (usize, usize),
    wanted: &Region,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    each_tile(base, space, next_level(space), (size, 2), wanted, monitor, |_, level, region, part| {
        for (v, row) in part.into_iter().enumerate() {
            let from = level.row(region.rows.start + 2 * v);
            // Every second pixel, as in the search, so that both agree to the bit.
            row.iter_mut().zip(from.as_chunks::<2>().0).for_each(|(out, pair)| *out = pair[0]);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Positions;
    use crate::detector::params::{CoarseStart, Interpolation, Slope};
    use crate::detector::scale_space::{SIGMA_BASE, SIGMA_INPUT};
    use crate::detector::stack::{frame_offsets, motion_stack};
    use crate::plane::blur::GaussianKernel;

    #[test]
    fn a_part_of_a_first_level_is_that_of_the_whole() {
        let frame =
            |t: usize| Plane::from_fn(701, 423, |u, v| ((u * 7919 + v * 104_729 + t * 31) % 997) as f32 / 997.0);
        let frames: Vec<Plane> = (0..3).map(frame).collect();
        let frames: Vec<&Plane> = frames.iter().collect();
        let offsets = frame_offsets(&Positions::even(3), Slope::new(1.3, -0.4), Interpolation::Linear);
        for first_octave in [-1, 0, 1] {
            let space = ScaleSpace::new(4, first_octave, 4.0);
            let stack = SlopeStack { frames: &frames, offsets: &offsets, space: &space, size_image: (701, 423) };
            let monitor = Monitor::default();
            let planes = stack.first_levels(first_octave + 3, &monitor).expect("not cancelled");
            assert_eq!(planes.len(), 3);
            for (octave, plane) in (first_octave + 1..).zip(&planes) {
                let size = octave_size((701, 423), octave);
                assert_eq!(plane.size(), size);
                for region in [
                    whole(size),
                    Region { columns: 0..1, rows: 0..1 },
                    Region { columns: size.0 - 1..size.0, rows: size.1 / 2..size.1 },
                    Region { columns: size.0 / 3..size.0 / 2, rows: size.1 / 3..size.1 / 3 + 1 },
                ] {
                    let part = stack.first_level(octave, &region, &monitor).expect("not cancelled");
                    for v in region.rows.clone() {
                        let columns = region.columns.clone();
                        assert_eq!(part.row(v)[columns.clone()], plane.row(v)[columns], "{first_octave} {octave}");
                    }
                }
            }
        }
    }

    #[test]
    fn stripes_finer_than_the_pixels_of_a_coarse_octave_vanish_or_where_it_skips_pixels_alias() {
        // Every second pixel of stripes 2.1 pixels apart shows stripes 21 of its own pixels apart.
        let stripes = Plane::from_fn(320, 240, |u, _| (u as f32 * 0.95 * std::f32::consts::PI).cos());
        let (offsets, monitor) =
            (frame_offsets(&Positions::even(1), Slope::default(), Interpolation::Linear), Monitor::default());
        let strongest = |start| {
            let space = ScaleSpace::starting(3, 1, start, 4.0);
            let binned = space.binned(&[&stripes], &monitor).expect("not cancelled");
            assert_eq!((binned.len(), space.skip()), if start == CoarseStart::Binned { (1, 1) } else { (0, 2) });
            let frames = [binned.first().unwrap_or(&stripes)];
            let stack = SlopeStack { frames: &frames, offsets: &offsets, space: &space, size_image: (320, 240) };
            let dog = dog_plane(&stack.base(), &space, (160, 120), 2, &monitor).expect("not cancelled");
            (20..100).flat_map(|v| dog.row(v)[20..140].to_vec()).fold(0.0, |max: f32, x| max.max(x.abs()))
        };
        let (binned, skipped) = (strongest(CoarseStart::Binned), strongest(CoarseStart::Skipped));
        assert!(skipped > 0.1 && binned < 0.01 * skipped, "{binned} {skipped}");
    }

    #[test]
    fn a_start_that_skips_pixels_keeps_theirs() {
        let frame = |t: usize| Plane::from_fn(61, 43, |u, v| ((u * 7919 + v * 104_729 + t * 31) % 997) as f32 / 997.0);
        let frames = [0, 1, 2].map(frame);
        let (slope, monitor) = (Slope::new(1.3, -0.4), Monitor::default());
        let stack = motion_stack(&frames.each_ref(), &Positions::even(3), slope, Interpolation::Linear, &monitor)
            .expect("not cancelled");
        let offsets = frame_offsets(&Positions::even(3), slope, Interpolation::Linear);
        let (mut tiles, size) = (Vec::new(), (30, 21));
        stack_tiles(&frames.each_ref(), &[&offsets], 1, &whole(size), &mut tiles);
        for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
            assert_eq!(tiles[0].at(x, y), stack.at(2 * x, 2 * y), "({x}, {y})");
        }
        let space = ScaleSpace::starting(4, 1, CoarseStart::Skipped, 4.0);
        let base = (SIGMA_BASE.powi(2) - (SIGMA_INPUT / 2.0).powi(2)).sqrt();
        assert_eq!(space.base_kernel, GaussianKernel::with_cut(base, 4.0));
        // The triangle of half-width 2 has the variance 1/2.
        assert!((ScaleSpace::new(4, 1, 4.0).sigma_before(1).powi(2) - 0.75 / 4.0).abs() < 1e-12);
    }
}
