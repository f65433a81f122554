//! Patches: the pixels around one feature at one slope.
//!
//! The search leaves nothing behind but keypoints; localisation and description make the little that they need of a feature's own motion-stack image
//! again, from the frames or from the octave's stored first level. A patch always holds the whole rectangle asked for: beyond the octave's border the
//! nearest pixel is repeated, as everywhere, so that nothing that reads a patch needs to know about borders.

use super::hat::PixelView;
use super::octave::Base;
use super::stack_patch::stack_patch;
use super::weighted_rows::WeightedRows;
use crate::plane::aligned::Aligned;
use std::ops::Range;

/// Values that one vector instruction takes. Loops over a patch's rows take whole vectors; what lies beyond the row's end is computed and dropped.
pub(super) const LANES: usize = 16;

/// A rectangle of pixels of an octave, at its place. The buffer keeps its capacity when it is reset.
#[derive(Debug, Default)]
pub struct Patch {
    columns: Range<i64>,
    rows: Range<i64>,
    /// Values from row to row, a multiple of [`LANES`].
    stride: usize,
    data: Aligned,
}

/// Space that making patches needs; reused from patch to patch.
#[derive(Debug, Default)]
pub struct PatchScratch {
    narrow: Patch,
    row: Vec<f32>,
    sums: WeightedRows,
}

/// The pixels within `radius` of the one in which `place` lies.
pub(super) fn around(place: f32, radius: usize) -> Range<i64> {
    let (middle, radius) = ((place + 0.5).floor() as i64, radius as i64);
    middle - radius..middle + radius + 1
}

/// The part of `range` inside an octave of `n` pixels, which it must touch.
pub(super) fn inside(range: &Range<i64>, n: usize) -> Range<usize> {
    debug_assert!(range.start < n as i64 && range.end > 0, "a patch touches its octave");
    range.start.max(0) as usize..range.end.min(n as i64) as usize
}

impl Patch {
    /// Makes this the given columns and rows. The contents are unspecified until written.
    pub fn reset(&mut self, columns: Range<i64>, rows: Range<i64>) {
        self.stride = columns.clone().count().next_multiple_of(LANES);
        // Vectors may begin at any pixel of a row and at the one after it.
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

    /// The pixels and where they lie.
    pub fn pixels(&self) -> PixelView<'_> {
        let size = (self.columns.clone().count(), self.rows.clone().count());
        PixelView { data: &self.data, stride: self.stride, size, left: self.columns.start, top: self.rows.start }
    }

    /// Values from one row to the next.
    pub(super) fn stride(&self) -> usize {
        self.stride
    }

    /// All values from pixel (u, v) on: the rest of its row, what fills it up to whole vectors, and the rows below; at least a vector from any held pixel.
    ///
    /// # Panics
    /// When the pixel is not held.
    #[inline(always)]
    pub(super) fn values(&self, u: i64, v: i64) -> &[f32] {
        assert!(self.columns.contains(&u) && self.rows.contains(&v), "({u}, {v}) is not held");
        let at = (v - self.rows.start) as usize * self.stride + (u - self.columns.start) as usize;
        &self.data[at..]
    }

    /// The same, to be written.
    pub(super) fn values_mut(&mut self, u: i64, v: i64) -> &mut [f32] {
        assert!(self.columns.contains(&u) && self.rows.contains(&v), "({u}, {v}) is not held");
        let at = (v - self.rows.start) as usize * self.stride + (u - self.columns.start) as usize;
        &mut self.data[at..]
    }

    /// Row `v`, one value a held column.
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

    /// Writes what lies beyond the octave of `size`, given what lies inside.
    fn repeat_border(&mut self, size: (usize, usize)) {
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

    /// Subtracts the value in the middle: only differences matter around a feature, and small numbers round less.
    fn centre(&mut self) {
        let (columns, rows) = (self.columns(), self.rows());
        let middle = self.values((columns.start + columns.end) / 2, (rows.start + rows.end) / 2)[0];
        let held = self.stride * rows.count();
        self.data[..held].iter_mut().for_each(|x| *x -= middle);
    }
}

impl Base<'_> {
    /// Columns `columns` and rows `rows` of the octave of `size` as they are before any blur of this octave, less the value in the middle, into `patch`. The
    /// rectangle must touch the octave.
    pub fn patch(
        &self,
        size: (usize, usize),
        columns: Range<i64>,
        rows: Range<i64>,
        scratch: &mut PatchScratch,
        patch: &mut Patch,
    ) {
        match self {
            Self::Level(level) => {
                patch.reset(columns.clone(), rows.clone());
                let columns = inside(&columns, size.0);
                for v in inside(&rows, size.1) {
                    let from = &level.row(v)[columns.clone()];
                    patch.values_mut(columns.start as i64, v as i64)[..from.len()].copy_from_slice(from);
                }
                patch.repeat_border(size);
            }
            Self::Frames { frames, offsets, octave: 0 } => {
                patch.reset(columns, rows);
                stack_patch(frames, offsets, patch, &mut scratch.sums);
                patch.repeat_border(size);
            }
            Self::Frames { frames, offsets, octave: -1 } => {
                // The pixels between which those of the doubled image lie. Repeated ones double to repeated ones.
                let narrow = |range: &Range<i64>| range.start.div_euclid(2)..(range.end - 1).div_euclid(2) + 2;
                scratch.narrow.reset(narrow(&columns), narrow(&rows));
                stack_patch(frames, offsets, &mut scratch.narrow, &mut scratch.sums);
                scratch.narrow.repeat_border(frames[0].size());
                patch.reset(columns, rows);
                patch.double(&scratch.narrow, &mut scratch.row);
            }
            Self::Frames { .. } => {
                patch.reset(columns.clone(), rows.clone());
                let columns = inside(&columns, size.0);
                self.raw_rows(inside(&rows, size.1), columns.clone(), &mut scratch.row, |v, row| {
                    patch.values_mut(columns.start as i64, v as i64)[..row.len()].copy_from_slice(row);
                });
                patch.repeat_border(size);
            }
        }
        patch.centre();
    }
}

impl Patch {
    /// Fills this from `narrow` doubled by linear interpolation: pixel (2i, 2j) is pixel (i, j).
    fn double(&mut self, narrow: &Self, row: &mut Vec<f32>) {
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
