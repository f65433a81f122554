//! The motion stack of a patch: few rows and columns of many frames.
//!
//! Where every frame covers the whole patch, which frame pixels belong together and with which weights is the same for all of its pixels; it is worked out once.
//! Each frame pixel adds to two of the patch's pixels, the one at its place and the one before, in proportion to the frame's fraction of a column; so two
//! sums are made of the frames, both from the same loads and in registers, and the second is shifted by a pixel at last. At the image's sides
//! rows are made one by one as those of whole images.

use super::motion::FrameOffset;
use super::patch::{LANES, Patch, inside};
use super::stack_rows::RowStacker;
use super::vectors::{MOST_VECTORS, in_vectors, load, store};
use crate::plane::Plane;
use crate::plane::aligned::Aligned;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Fills the part of `patch` inside the frames with the motion-stack image of `frames`, of one size, at their [`super::motion::frame_offsets`].
pub(super) fn stack_patch(frames: &[&Plane], offsets: &[FrameOffset], patch: &mut Patch, shifted: &mut Aligned) {
    let size = frames[0].size();
    let (columns, rows) = (inside(&patch.columns(), size.0), inside(&patch.rows(), size.1));
    let (left, top, stride) = (columns.start as i64, rows.start as i64, patch.stride());
    if columns.len() < LANES || !offsets.iter().all(|offset| reaches(offset, &columns, &rows, size)) {
        let mut stacker = RowStacker::new(frames, vec![offsets]);
        for v in rows {
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
                taps.push((&frame.data()[start + below..], [weight * (1.0 - offset.part_u), weight * offset.part_u]));
            }
        }
    }
    shifted.grow(columns.len() + LANES);
    let (columns, rows, out) = (columns.len(), rows.len(), patch.values_mut(left, top));
    Arch::new().dispatch(WeightedRows { taps: &taps, width: size.0, columns, rows, shifted, out, stride });
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

/// Rows of the weighted sum of the taps, which begin at the first row's first pixel and have rows `width` apart.
struct WeightedRows<'a> {
    taps: &'a [Tap<'a>],
    width: usize,
    /// At least [`LANES`].
    columns: usize,
    rows: usize,
    /// Room for a row of the second sum.
    shifted: &'a mut [f32],
    /// Rows `stride` apart.
    out: &'a mut [f32],
    stride: usize,
}

impl WithSimd for WeightedRows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for v in 0..self.rows {
            let (out, row) = (&mut self.out[v * self.stride..], v * self.width);
            // Of the second sum one more is needed.
            in_vectors!(S, self.columns + 1, |V, places| {
                weighted::<S, V>(simd, self.taps, row, places, out, self.shifted);
            });
            for (out, shifted) in out[..self.columns].chunks_mut(LANES).zip(self.shifted[1..].chunks(LANES)) {
                out.iter_mut().zip(shifted).for_each(|(out, shifted)| *out += shifted);
            }
        }
    }
}

/// Vectors of both weighted sums at `places` of the row that begins `row` values after the taps.
#[inline(always)]
fn weighted<S: Simd, const V: usize>(
    simd: S,
    taps: &[Tap<'_>],
    row: usize,
    places: [usize; V],
    here: &mut [f32],
    shifted: &mut [f32],
) {
    let zero = simd.splat_f32s(0.0);
    let mut sums = [[zero; V]; 2];
    for &(pixels, weights) in taps {
        let weights = [simd.splat_f32s(weights[0]), simd.splat_f32s(weights[1])];
        let pixels = &pixels[row..];
        for i in 0..V {
            let pixels = load::<S>(pixels, places[i]);
            sums[0][i] = simd.mul_add_f32s(weights[0], pixels, sums[0][i]);
            sums[1][i] = simd.mul_add_f32s(weights[1], pixels, sums[1][i]);
        }
    }
    for i in 0..V {
        store::<S>(here, places[i], sums[0][i]);
        store::<S>(shifted, places[i], sums[1][i]);
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
