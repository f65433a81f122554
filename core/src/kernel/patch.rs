//! Patches: the pixels around one feature at one slope.
//!
//! The search stores only keypoints; localisation and description compute again the small part that they need of a
//! feature's own motion-stack image, from the frames or from the octave's stored first level. A patch always holds the
//! whole rectangle asked for: beyond the octave's border the nearest pixel is repeated, as everywhere, so that code
//! that reads a patch needs no cases for borders.

use crate::kernel::compact_kernel::PixelView;
use crate::kernel::weighted_rows::WeightedRows;
use crate::plane::aligned::Aligned;
use std::ops::Range;

/// Number of values in a vector. Loops over a patch's rows take whole vectors; values beyond the row's end are computed
/// and dropped.
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

/// Buffers for making patches; reused from patch to patch.
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

    /// Columns of the octave that are held, some perhaps beyond its border.
    pub fn columns(&self) -> Range<i64> {
        self.columns.clone()
    }

    /// Rows of the octave that are held, some perhaps beyond its border.
    pub fn rows(&self) -> Range<i64> {
        self.rows.clone()
    }

    /// View of the pixels.
    pub fn pixels(&self) -> PixelView<'_> {
        let size = (self.columns.clone().count(), self.rows.clone().count());
        PixelView { data: &self.data, stride: self.stride, size, left: self.columns.start, top: self.rows.start }
    }

    /// Values from one row to the next.
    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    /// All values from pixel (u, v) on: the rest of its row, its padding to whole vectors, and the rows below; at least
    /// a vector from any held pixel.
    ///
    /// # Panics
    /// When the pixel is not held.
    #[inline(always)]
    pub(crate) fn values(&self, u: i64, v: i64) -> &[f32] {
        assert!(self.columns.contains(&u) && self.rows.contains(&v), "({u}, {v}) is not held");
        let at = (v - self.rows.start) as usize * self.stride + (u - self.columns.start) as usize;
        &self.data[at..]
    }

    /// All values from pixel (u, v) on, mutable.
    pub(crate) fn values_mut(&mut self, u: i64, v: i64) -> &mut [f32] {
        assert!(self.columns.contains(&u) && self.rows.contains(&v), "({u}, {v}) is not held");
        let at = (v - self.rows.start) as usize * self.stride + (u - self.columns.start) as usize;
        &mut self.data[at..]
    }

    /// Row `v`, one value for each held column.
    ///
    /// # Panics
    /// When the row is not held.
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
        let stride = self.stride;
        let (above, below) = (rows.start as i64 - self.rows.start, self.rows.end - rows.end as i64);
        let last = (rows.end as i64 - 1 - self.rows.start) as usize;
        let data = &mut *self.data;
        let first = above as usize;
        (0..first).for_each(|v| data.copy_within(first * stride..(first + 1) * stride, v * stride));
        (1..=below as usize).for_each(|v| data.copy_within(last * stride..(last + 1) * stride, (last + v) * stride));
    }

    /// Subtracts the value in the middle: only differences matter around a feature, and small numbers have smaller
    /// rounding errors.
    pub(crate) fn centre(&mut self) {
        let (columns, rows) = (self.columns(), self.rows());
        let middle = self.values((columns.start + columns.end) / 2, (rows.start + rows.end) / 2)[0];
        let held = self.stride * rows.count();
        self.data[..held].iter_mut().for_each(|x| *x -= middle);
    }
}

impl Patch {
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
            // The first pixel of the patch is the first narrow one or lies after it.
            let odd = left.rem_euclid(2) as usize;
            for (i, out) in self.row_mut(v).iter_mut().enumerate() {
                let at = (i + odd) / 2;
                *out = if (i + odd).is_multiple_of(2) { row[at] } else { 0.5 * (row[at] + row[at + 1]) };
            }
        }
    }
}
