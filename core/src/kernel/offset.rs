//! Offset at which a frame is read, in whole pixels and a fraction, and the pixels of an image that it covers there.

use std::ops::Range;

/// Offset of one frame: whole pixels and a fraction in [0, 1) in each direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameOffset {
    /// Whole columns.
    pub whole_u: i64,
    /// Whole rows.
    pub whole_v: i64,
    /// Fraction of a column.
    pub part_u: f32,
    /// Fraction of a row.
    pub part_v: f32,
    /// Number of columns before the first one that still count as it, 0 or 1: see
    /// [`crate::detector::Interpolation::Truncated`].
    pub before_u: i64,
    /// Number of rows before the first one that still count as it, 0 or 1.
    pub before_v: i64,
}

impl FrameOffset {
    /// Columns of an image `width` wide at which the frame has pixels of its own.
    pub(crate) fn reads_columns(&self, width: usize) -> Range<usize> {
        Self::covered(self.whole_u, self.part_u, 0, width)
    }

    /// Columns of an image `width` wide at which the frame counts.
    pub(crate) fn covers_columns(&self, width: usize) -> Range<usize> {
        Self::covered(self.whole_u, self.part_u, self.before_u, width)
    }

    /// Columns of an image `width` wide at which the frame has pixels of its own, and one more to the right, whether or
    /// not that is needed.
    pub(crate) fn reads_next_columns(&self, width: usize) -> Range<usize> {
        Self::covered(self.whole_u, 1.0, 0, width)
    }

    /// Rows of an image `height` high that the frame covers.
    pub(crate) fn covers_rows(&self, height: usize) -> Range<usize> {
        Self::covered(self.whole_v, self.part_v, self.before_v, height)
    }

    /// Whether the frame covers row `v` of an image `height` high.
    pub(crate) fn covers_row(&self, v: usize, height: usize) -> bool {
        self.covers_rows(height).contains(&v)
    }

    /// Positions `0 … n−1` that stay inside at whole offset `whole` and fraction `part`, as a half-open range; `before`
    /// positions before 0 count too.
    fn covered(whole: i64, part: f32, before: i64, n: usize) -> Range<usize> {
        let reach = i64::from(part > 0.0);
        let start = (-whole - before).clamp(0, n as i64);
        let end = (n as i64 - whole - reach).clamp(start, n as i64);
        start as usize..end as usize
    }

    /// Whether the frame covers the pixel (u, v) of an image of `size`.
    pub fn covers(&self, u: usize, v: usize, size: (usize, usize)) -> bool {
        self.covers_columns(size.0).contains(&u) && self.covers_row(v, size.1)
    }
}
