//! Patches: the pixels around one feature at one slope, their motion stack and their blur.
//!
//! Localisation and description make the part that they need of a feature's own motion-stack image again. A patch
//! always holds the whole rectangle: beyond the octave's border the nearest pixel is repeated. Where every frame covers
//! the patch, pixels that belong together and their weights are computed once; at the sides row by row. A pixel has the
//! same bits either way, unless a frame is read between its rows. One blur equals a chain up to its cut.

use crate::kernel::compact_kernel::PixelView;
use crate::kernel::machine::{PATCH_ROWS_TOGETHER as TOGETHER, load, store};
use crate::kernel::stack::{FrameOffset, RowStacker, Tap, WeightedRows};
use crate::plane::{Plane, blur::GaussianKernel, halve_pair, memory::Aligned};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Values in a vector; values beyond the end of a patch's row are computed and dropped.
pub(crate) const LANES: usize = 16;

/// A rectangle of pixels of an octave, with its place. The buffer keeps its capacity when it is reset.
#[derive(Debug, Default)]
pub struct Patch {
    columns: Range<i64>,
    rows: Range<i64>,
    /// Values from row to row, a multiple of [`LANES`].
    stride: usize,
    data: Aligned,
}

#[derive(Debug, Default)]
pub struct PatchScratch {
    pub(crate) narrow: Patch,
    pub(crate) row: Vec<f32>,
    pub(crate) sums: WeightedRows,
}

/// The part of `range` inside an octave of `n` pixels, which it must touch.
pub(crate) fn inside(range: &Range<i64>, n: usize) -> Range<usize> {
    debug_assert!(range.start < n as i64 && range.end > 0, "a patch touches its octave");
    range.start.max(0) as usize..range.end.min(n as i64) as usize
}

impl Patch {
    /// Sets the columns and rows. The contents are unspecified until written.
    pub fn reset(&mut self, columns: Range<i64>, rows: Range<i64>) {
        self.stride = columns.clone().count().next_multiple_of(LANES);
        // Vectors may begin at any pixel of a row and at the next one.
        self.data.grow(self.stride * rows.clone().count() + 2 * LANES);
        (self.columns, self.rows) = (columns, rows);
    }

    pub fn columns(&self) -> Range<i64> {
        self.columns.clone()
    }

    pub fn rows(&self) -> Range<i64> {
        self.rows.clone()
    }

    pub fn pixels(&self) -> PixelView<'_> {
        let size = (self.columns.clone().count(), self.rows.clone().count());
        PixelView { data: &self.data, stride: self.stride, size, left: self.columns.start, top: self.rows.start }
    }

    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    /// All values from pixel (u, v) on: the rest of its row, its padding, and the rows below; at least a vector.
    #[inline(always)]
    pub(crate) fn values(&self, u: i64, v: i64) -> &[f32] {
        assert!(self.columns.contains(&u) && self.rows.contains(&v), "({u}, {v}) is not held");
        let at = (v - self.rows.start) as usize * self.stride + (u - self.columns.start) as usize;
        &self.data[at..]
    }

    pub(crate) fn values_mut(&mut self, u: i64, v: i64) -> &mut [f32] {
        assert!(self.columns.contains(&u) && self.rows.contains(&v), "({u}, {v}) is not held");
        let at = (v - self.rows.start) as usize * self.stride + (u - self.columns.start) as usize;
        &mut self.data[at..]
    }

    pub fn row(&self, v: i64) -> &[f32] {
        &self.values(self.columns.start, v)[..self.columns.clone().count()]
    }

    fn row_mut(&mut self, v: i64) -> &mut [f32] {
        let width = self.columns.clone().count();
        &mut self.values_mut(self.columns.start, v)[..width]
    }

    /// Fills the pixels beyond the octave of `size` from those inside.
    pub(crate) fn repeat_border(&mut self, size: (usize, usize)) {
        let (columns, rows) = (inside(&self.columns, size.0), inside(&self.rows, size.1));
        let (left, right) = (self.columns.start, columns.end as i64);
        let before = (columns.start as i64 - left) as usize;
        if before > 0 || right < self.columns.end {
            let end = (right - left) as usize;
            for v in rows.clone() {
                let row = self.row_mut(v as i64);
                let (first, last) = (row[before], row[end - 1]);
                row[..before].fill(first);
                row[end..].fill(last);
            }
        }
        // Rows above and below last, so that they copy the repeated corners too.
        let stride = self.stride;
        let (above, below) = (rows.start as i64 - self.rows.start, self.rows.end - rows.end as i64);
        let last = (rows.end as i64 - 1 - self.rows.start) as usize;
        let data = &mut *self.data;
        let first = above as usize;
        (0..first).for_each(|v| data.copy_within(first * stride..(first + 1) * stride, v * stride));
        (1..=below as usize).for_each(|v| data.copy_within(last * stride..(last + 1) * stride, (last + v) * stride));
    }

    /// Subtracts the value in the middle: smaller numbers have smaller rounding errors.
    pub(crate) fn centre(&mut self) {
        let (columns, rows) = (self.columns(), self.rows());
        let middle = self.values((columns.start + columns.end) / 2, (rows.start + rows.end) / 2)[0];
        let held = self.stride * rows.count();
        self.data[..held].iter_mut().for_each(|x| *x -= middle);
    }

    /// Fills the patch from `narrow` doubled by linear interpolation: pixel (2i, 2j) is pixel (i, j) of `narrow`.
    pub(crate) fn double(&mut self, narrow: &Self, row: &mut Vec<f32>) {
        let left = self.columns.start;
        row.resize(narrow.columns.clone().count(), 0.0);
        for v in self.rows() {
            let upper = narrow.row(v.div_euclid(2));
            if v % 2 == 0 {
                row.copy_from_slice(upper);
            } else {
                let lower = narrow.row(v.div_euclid(2) + 1);
                row.iter_mut().zip(upper).zip(lower).for_each(|((out, a), b)| *out = 0.5 * (a + b));
            }
            // The patch begins at a narrow pixel or between it and the next.
            let odd = left.rem_euclid(2) as usize;
            for (i, out) in self.row_mut(v).iter_mut().enumerate() {
                let at = (i + odd) / 2;
                *out = if (i + odd).is_multiple_of(2) { row[at] } else { 0.5 * (row[at] + row[at + 1]) };
            }
        }
    }

    /// Fills the patch from `fine` at half its resolution: all means of pixels 2i and 2i + 1 of rows 2j and 2j + 1.
    pub(crate) fn halve(&mut self, fine: &Self) {
        let half = |range: Range<i64>| (range.start + 1).div_euclid(2)..range.end.div_euclid(2);
        self.reset(half(fine.columns()), half(fine.rows()));
        let left = 2 * self.columns.start;
        for v in self.rows() {
            halve_pair(fine.values(left, 2 * v), fine.values(left, 2 * v + 1), self.row_mut(v));
        }
    }

    /// Blurs at least four rows into `out`. The patch must extend beyond them by the kernel's radius.
    pub fn blurred(
        &self,
        columns: Range<i64>,
        rows: Range<i64>,
        kernel: &GaussianKernel,
        scratch: &mut BlurScratch,
        out: &mut Self,
    ) {
        let radius = kernel.radius() as i64;
        let (left, top) = (columns.start - radius, rows.start - radius);
        assert!(self.columns().start <= left && self.columns().end >= columns.end + radius, "the patch is wide enough");
        assert!(self.rows().start <= top && self.rows().end >= rows.end + radius, "the patch is high enough");
        // Vectors begin at cache lines.
        let skipped = (left - self.columns().start) as usize % LANES;
        let (width, count) = (columns.clone().count(), rows.clone().count());
        assert!(count >= TOGETHER, "{count} rows are too few");
        out.reset(columns.clone(), rows.clone());
        let stride = out.stride();
        let band_stride = (skipped + width + 2 * kernel.radius()).next_multiple_of(LANES);
        scratch.0.grow(TOGETHER * band_stride + LANES);
        Arch::new().dispatch(BlurRows {
            from: self.values(left - skipped as i64, top),
            from_stride: self.stride(),
            half: kernel.half(),
            band: &mut scratch.0,
            band_stride,
            skipped,
            out: out.values_mut(columns.start, rows.start),
            stride,
            columns: width,
            rows: count,
        });
    }
}

/// Fills the part of `patch` inside the frames with their motion-stack image.
pub(crate) fn stack_patch(frames: &[&Plane], offsets: &[FrameOffset], patch: &mut Patch, sums: &mut WeightedRows) {
    let size = frames[0].size();
    let (columns, rows) = (inside(&patch.columns(), size.0), inside(&patch.rows(), size.1));
    let (left, top, stride) = (columns.start as i64, rows.start as i64, patch.stride());
    // At the sides and under masks the frames that count differ from pixel to pixel.
    if !frames.iter().zip(offsets).all(|(frame, offset)| reaches(frame, offset, &columns, &rows)) {
        let out = patch.values_mut(left, top);
        return RowStacker::new(frames, vec![offsets]).rows(rows, &columns, &mut [out], stride);
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

/// Whether `frame`, read at `offset`, has seen own pixels for all of `columns` × `rows`, and one more in each row.
fn reaches(frame: &Plane, offset: &FrameOffset, columns: &Range<usize>, rows: &Range<usize>) -> bool {
    let read = |range: &Range<usize>, whole: i64, more: bool, n: usize| {
        let (start, end) = (range.start as i64 + whole, range.end as i64 + whole + i64::from(more));
        (start >= 0 && end <= n as i64).then_some(start as usize..end as usize)
    };
    let columns = read(columns, offset.whole_u, true, frame.width());
    let rows = read(rows, offset.whole_v, offset.part_v > 0.0, frame.height());
    columns.zip(rows).is_some_and(|(columns, rows)| frame.mask().is_none_or(|mask| !mask.touches(&columns, rows)))
}

#[derive(Debug, Default)]
pub struct BlurScratch(Aligned);

/// Rows blurred by the kernel whose centre and right half are `half`.
struct BlurRows<'a> {
    /// Begins a radius above and a radius and `skipped` columns to the left of the first pixel.
    from: &'a [f32],
    from_stride: usize,
    half: &'a [f32],
    /// Combined rows `band_stride` apart, beginning at the columns where `from` does.
    band: &'a mut [f32],
    band_stride: usize,
    skipped: usize,
    /// Rows `stride` apart, written in whole vectors.
    out: &'a mut [f32],
    stride: usize,
    columns: usize,
    rows: usize,
}

impl WithSimd for BlurRows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for first in (0..self.rows).step_by(TOGETHER) {
            // The last rows overlap the rows before them, so that all groups have one size.
            let first = first.min(self.rows - TOGETHER);
            let from = &self.from[first * self.from_stride..];
            for u in (0..self.band_stride).step_by(S::F32_LANES) {
                combine(simd, self.half, &from[u..], self.from_stride, &mut self.band[u..], self.band_stride);
            }
            for v in 0..TOGETHER {
                let line = &self.band[v * self.band_stride + self.skipped..];
                let out = &mut self.out[(first + v) * self.stride..];
                let mut u = 0;
                while u + S::F32_LANES < self.columns {
                    convolve::<S, 2>(simd, self.half, &line[u..], &mut out[u..]);
                    u += 2 * S::F32_LANES;
                }
                if u < self.columns {
                    convolve::<S, 1>(simd, self.half, &line[u..], &mut out[u..]);
                }
            }
        }
    }
}

/// Combines one vector of [`TOGETHER`] rows; `from` begins at the first row read.
#[inline(always)]
fn combine<S: Simd>(simd: S, half: &[f32], from: &[f32], stride: usize, out: &mut [f32], out_stride: usize) {
    let radius = half.len() - 1;
    let tap = simd.splat_f32s(half[0]);
    let (mut above, mut sums) = ([tap; TOGETHER], [tap; TOGETHER]);
    for i in 0..TOGETHER {
        above[i] = load::<S>(from, (radius + i) * stride);
        sums[i] = simd.mul_f32s(tap, above[i]);
    }
    let mut below = above;
    // One tap farther, the rows are those already loaded, shifted by one, and a new row.
    let mut distance = 1;
    macro_rules! step {
        () => {
            let tap = simd.splat_f32s(half[distance]);
            for i in (1..TOGETHER).rev() {
                above[i] = above[i - 1];
            }
            for i in 1..TOGETHER {
                below[i - 1] = below[i];
            }
            above[0] = load::<S>(from, (radius - distance) * stride);
            below[TOGETHER - 1] = load::<S>(from, (radius + distance + TOGETHER - 1) * stride);
            for i in 0..TOGETHER {
                sums[i] = simd.mul_add_f32s(tap, simd.add_f32s(above[i], below[i]), sums[i]);
            }
            distance += 1;
        };
    }
    // Four taps a turn: unrolled, the rotation of four rows needs no copies.
    while distance + 3 < half.len() {
        step!();
        step!();
        step!();
        step!();
    }
    while distance < half.len() {
        step!();
    }
    for (i, &sum) in sums.iter().enumerate() {
        store::<S>(out, i * out_stride, sum);
    }
}

/// Convolves `V` vectors with a symmetric kernel; `line` begins at the first value under the first tap.
#[inline(always)]
fn convolve<S: Simd, const V: usize>(simd: S, half: &[f32], line: &[f32], out: &mut [f32]) {
    let (radius, read) = (half.len() - 1, V * S::F32_LANES);
    let tap = simd.splat_f32s(half[0]);
    let mut sums = [tap; V];
    for (i, sum) in sums.iter_mut().enumerate() {
        *sum = simd.mul_f32s(tap, load::<S>(line, radius + i * S::F32_LANES));
    }
    // Iterators need no bounds checks.
    let before = line[..radius + read - 1].windows(read).rev();
    let after = line[radius + 1..2 * radius + read].windows(read);
    for ((before, after), &tap) in before.zip(after).zip(&half[1..]) {
        let tap = simd.splat_f32s(tap);
        for (i, sum) in sums.iter_mut().enumerate() {
            let at = i * S::F32_LANES;
            *sum = simd.mul_add_f32s(tap, simd.add_f32s(load::<S>(before, at), load::<S>(after, at)), *sum);
        }
    }
    for (i, &sum) in sums.iter().enumerate() {
        store::<S>(out, i * S::F32_LANES, sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Positions;
    use crate::detector::params::{Interpolation, Slope};
    use crate::detector::{scale_space::Base, stack::frame_offsets};
    use crate::kernel::patch::PatchScratch;
    use crate::plane::blur::gaussian_blur;

    #[test]
    fn patches_are_cut_from_the_stacked_image_and_repeat_its_border() {
        let frames = [0, 1, 2, 3]
            .map(|t| Plane::from_fn(97, 61, |u, v| ((u * 31 + v * 17 + t * 7 + (u * v) % 13) % 29) as f32 / 29.0));
        let frames: Vec<&Plane> = frames.iter().collect();
        let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
        for slope in [Slope::new(0.0, 0.0), Slope::new(1.3, 0.0), Slope::new(-0.6, 2.2)] {
            let offsets = frame_offsets(&Positions::even(4), slope, Interpolation::Linear);
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

    #[test]
    fn a_patch_is_blurred_as_the_whole_image_is() {
        let plane = Plane::from_fn(130, 90, |u, v| ((u * 31 + v * 17 + (u * v) % 13) % 29) as f32 / 29.0);
        let (mut raw, mut blurred) = (Patch::default(), Patch::default());
        for (sigma, (left, top), (width, height)) in
            [(0.0, (20, 20), (40, 7)), (1.2, (0, 3), (17, 30)), (2.7, (61, 50), (66, 36))]
        {
            let kernel = GaussianKernel::new(sigma);
            let whole = gaussian_blur(&plane, &kernel);
            let (columns, rows) = (left..left + width, top..top + height);
            // A little more than is needed, on one side even more.
            let reach = kernel.radius() as i64 + 1;
            let (wide, tall) = (columns.start - reach - 3..columns.end + reach, rows.start - reach..rows.end + reach);
            let middle = plane.at(((wide.start + wide.end) / 2) as usize, ((tall.start + tall.end) / 2) as usize);
            Base::Level(&plane).patch((130, 90), wide, tall, &mut PatchScratch::default(), &mut raw);
            raw.blurred(columns.clone(), rows.clone(), &kernel, &mut BlurScratch::default(), &mut blurred);
            for v in rows {
                for (u, value) in columns.clone().zip(blurred.row(v)) {
                    let expected = whole.at((u as usize).min(129), (v as usize).min(89)) - middle;
                    assert!(u > 129 || v > 89 || (value - expected).abs() < 1e-5, "({u}, {v}): {value} {expected}");
                }
            }
        }
    }
}
