//! The motion stack of a patch: few rows and columns of many frames.
//!
//! Where every frame covers the whole patch, the frame pixels that belong together and their weights are the same for
//! all of its pixels; they are computed once. At the image's sides rows are made one by one as those of whole images. A
//! pixel has the same bits either way, unless a frame is read between its rows.

use crate::kernel::offset::FrameOffset;
use crate::kernel::patch::{Patch, inside};
use crate::kernel::stack_rows::RowStacker;
use crate::kernel::weighted_rows::{Tap, WeightedRows};
use crate::plane::Plane;
use crate::plane::tile::Region;
use std::ops::Range;

/// Fills the part of `patch` inside the frames with the motion-stack image of `frames`, which have one size, at their
/// [`crate::detector::stack::offsets::frame_offsets`].
pub(crate) fn stack_patch(frames: &[&Plane], offsets: &[FrameOffset], patch: &mut Patch, sums: &mut WeightedRows) {
    let part = part_inside(patch, frames[0].size());
    stack_part(frames, offsets, &part, patch, sums);
}

/// The part of `patch` inside an image of `size`.
fn part_inside(patch: &Patch, size: (usize, usize)) -> Region {
    Region { columns: inside(&patch.columns(), size.0), rows: inside(&patch.rows(), size.1) }
}

/// Fills `part` of `patch`.
fn stack_part(frames: &[&Plane], offsets: &[FrameOffset], part: &Region, patch: &mut Patch, sums: &mut WeightedRows) {
    let (size, Region { columns, rows }) = (frames[0].size(), part);
    let (left, top, stride) = (columns.start as i64, rows.start as i64, patch.stride());
    if !offsets.iter().all(|offset| reaches(offset, columns, rows, size)) {
        let mut stacker = RowStacker::new(frames, vec![offsets]);
        for v in rows.clone() {
            stacker.row(v, columns.clone(), &mut [&mut patch.values_mut(left, v as i64)[..columns.len()]]);
        }
        return;
    }
    let mut taps: Vec<Tap<'_>> = Vec::with_capacity(2 * frames.len());
    let scale = 1.0 / frames.len() as f32;
    for (frame, offset) in frames.iter().zip(offsets) {
        let start = (top + offset.whole_v) as usize * size.0 + (left + offset.whole_u) as usize;
        for (below, weight) in [(0, scale * (1.0 - offset.part_v)), (size.0, scale * offset.part_v)] {
            if weight > 0.0 {
                taps.push(Tap::new(&frame.data()[start + below..], weight, offset.part_u));
            }
        }
    }
    let (columns, rows, out) = (columns.len(), rows.len(), patch.values_mut(left, top));
    sums.make(&taps, size.0, columns, 0..rows, out, stride);
}

/// Whether a frame read at `offset` has pixels of its own for all of `columns` × `rows`, and one more in each row.
fn reaches(offset: &FrameOffset, columns: &Range<usize>, rows: &Range<usize>, size: (usize, usize)) -> bool {
    let covers = |range: &Range<usize>, whole: i64, more: bool, n: usize| {
        range.start as i64 + whole >= 0 && range.end as i64 + whole + i64::from(more) <= n as i64
    };
    covers(columns, offset.whole_u, true, size.0) && covers(rows, offset.whole_v, offset.part_v > 0.0, size.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::params::Interpolation;
    use crate::detector::params::slope_grid::Slope;
    use crate::detector::scale_space::octave::Base;
    use crate::detector::stack::offsets::frame_offsets;
    use crate::kernel::patch::PatchScratch;

    #[test]
    fn patches_are_cut_from_the_stacked_image_and_repeat_its_border() {
        let frames = [0, 1, 2, 3]
            .map(|t| Plane::from_fn(97, 61, |u, v| ((u * 31 + v * 17 + t * 7 + (u * v) % 13) % 29) as f32 / 29.0));
        let frames: Vec<&Plane> = frames.iter().collect();
        let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
        for slope in [Slope::new(0.0, 0.0), Slope::new(1.3, 0.0), Slope::new(-0.6, 2.2)] {
            let offsets = frame_offsets(4, slope, Interpolation::Linear);
            for (octave, size) in [(0, (97, 61)), (-1, (194, 122)), (1, (48, 30))] {
                let base = Base::Frames { frames: &frames, offsets: &offsets, octave };
                let mut whole = Plane::zeros(size.0, size.1);
                let mut row = Vec::new();
                base.raw_rows(0..size.1, 0..size.0, &mut row, |v, row| whole.row_mut(v).copy_from_slice(row));
                for (u, v, radius) in [(40, 25, 15), (20, 14, 20), (2, 1, 9), (47, 29, 12), (44, 22, 60)] {
                    let (columns, rows) = (u - radius..u + radius + 1, v - radius..v + radius + 1);
                    base.patch(size, columns.clone(), rows.clone(), &mut scratch, &mut patch);
                    let nearest = |x: i64, n: usize| x.clamp(0, n as i64 - 1) as usize;
                    let middle = whole.at(nearest(u, size.0), nearest(v, size.1));
                    for y in rows {
                        for (x, value) in columns.clone().zip(patch.row(y)) {
                            let expected = whole.at(nearest(x, size.0), nearest(y, size.1)) - middle;
                            assert!((value - expected).abs() < 1e-6, "{octave} {slope:?} ({x}, {y})");
                        }
                    }
                }
            }
        }
    }
}
