//! The motion stack of a patch: few rows and columns of many frames.
//!
//! Where every frame covers the whole patch, which frame pixels belong together and with which weights is the same for all of its pixels; it is worked out once.
//! Each frame pixel adds to two of the patch's pixels, the one at its place and the one before, in proportion to the frame's fraction of a column; so two
//! sums are made of the frames, both from the same loads and in registers, and the second is shifted by a pixel at last. At the image's sides
//! rows are made one by one as those of whole images.

use super::motion::{FrameOffset, stack_row};
use super::patch::{Block, LANES, Patch, in_blocks, inside, room};
use crate::plane::Plane;
use multiversion::multiversion;
use std::ops::Range;

/// Fills the part of `patch` inside the frames with the motion-stack image of `frames`, of one size, at their [`super::motion::frame_offsets`].
pub(super) fn stack_patch(frames: &[&Plane], offsets: &[FrameOffset], patch: &mut Patch, shifted: &mut Vec<Block>) {
    let size = frames[0].size();
    let (columns, rows) = (inside(&patch.columns(), size.0), inside(&patch.rows(), size.1));
    let (left, top, stride) = (columns.start as i64, rows.start as i64, patch.stride());
    if columns.len() < LANES || !offsets.iter().all(|offset| reaches(offset, &columns, &rows, size)) {
        for v in rows {
            let out = &mut patch.from_mut(left, v as i64)[..columns.len()];
            stack_row(frames, offsets, v, columns.clone(), out);
        }
        return;
    }
    let mut taps: Vec<Tap<'_>> = Vec::with_capacity(2 * frames.len());
    let scale = 1.0 / frames.len() as f32;
    for (frame, offset) in frames.iter().zip(offsets) {
        let start = (top + offset.whole_v) as usize * size.0 + (left + offset.whole_u) as usize;
        for (below, weight) in [(0, scale * (1.0 - offset.part_v)), (size.0, scale * offset.part_v)] {
            if weight > 0.0 {
                taps.push((&frame.data()[start + below..], [weight * (1.0 - offset.part_u), weight * offset.part_u]));
            }
        }
    }
    let shifted = room(shifted, columns.len() + 1);
    let rows_of = (columns.len(), rows.len());
    weighted_rows(&taps, size.0, rows_of, shifted, patch.from_mut(left, top), stride);
}

/// Pixels of a frame from where a patch reads them, and their weights at their own place and a pixel to the left.
type Tap<'a> = (&'a [f32], [f32; 2]);

/// Whether a frame read at `offset` has pixels of its own for all of `columns` × `rows`, and one more in each row.
fn reaches(offset: &FrameOffset, columns: &Range<usize>, rows: &Range<usize>, size: (usize, usize)) -> bool {
    let covers = |range: &Range<usize>, whole: i64, more: bool, n: usize| {
        range.start as i64 + whole >= 0 && range.end as i64 + whole + i64::from(more) <= n as i64
    };
    covers(columns, offset.whole_u, true, size.0) && covers(rows, offset.whole_v, offset.part_v > 0.0, size.1)
}

/// `V` vectors of both weighted sums, `at` values from where the taps begin.
#[inline(always)]
fn weighted_block<const V: usize>(taps: &[(&[f32], [f32; 2])], at: usize, here: &mut [f32], shifted: &mut [f32]) {
    let mut sums = [[[0.0f32; LANES]; V]; 2];
    for &(pixels, weights) in taps {
        let pixels: &[[f32; LANES]] = pixels[at..at + V * LANES].as_chunks().0;
        for j in 0..V {
            for i in 0..LANES {
                sums[0][j][i] = weights[0].mul_add(pixels[j][i], sums[0][j][i]);
            }
            for i in 0..LANES {
                sums[1][j][i] = weights[1].mul_add(pixels[j][i], sums[1][j][i]);
            }
        }
    }
    here[..V * LANES].copy_from_slice(sums[0].as_flattened());
    shifted[..V * LANES].copy_from_slice(sums[1].as_flattened());
}

/// Rows of the weighted sum of the taps, which begin at the first row's first pixel and have rows `width` apart; `columns` is at least [`LANES`].
/// The rows of `out` lie `stride` apart; `shifted` has room for a pixel more than a row.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn weighted_rows(
    taps: &[(&[f32], [f32; 2])],
    width: usize,
    (columns, rows): (usize, usize),
    shifted: &mut [f32],
    out: &mut [f32],
    stride: usize,
) {
    for v in 0..rows {
        let (out, row) = (&mut out[v * stride..], v * width);
        // Of the second sum one more is needed; the last block overlaps the one before.
        in_blocks!(u, columns + 1, V, weighted_block::<V>(taps, row + u, &mut out[u..], &mut shifted[u..]));
        for (out, shifted) in out[..columns].iter_mut().zip(&shifted[1..]) {
            *out += shifted;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::motion::frame_offsets;
    use super::super::octave::Base;
    use super::super::params::Interpolation;
    use super::super::patch::PatchScratch;
    use super::super::slope_grid::Slope;
    use super::*;

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
