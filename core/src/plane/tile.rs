//! A rectangular part of an image, with its place.
//!
//! The search works tile by tile so that its memory stays bounded and its data stays in the cache. A [`Tile`] knows
//! which columns and rows of the image it holds; its buffer is reused from slope to slope.

use super::{Plane, memory::Aligned};
use std::ops::Range;

/// Part of an image: columns × rows.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Region {
    /// Columns of the image, from the first one held to the one after the last.
    pub columns: Range<usize>,
    /// Rows of the image, alike.
    pub rows: Range<usize>,
}

impl Region {
    /// Region of all pixels of a plane.
    pub fn whole(plane: &Plane) -> Self {
        Self { columns: 0..plane.width(), rows: 0..plane.height() }
    }

    /// Region of the pixel nearest to `place` (u, v), with `by` more on each side, inside an image of `size`.
    pub fn around(place: [f32; 2], by: usize, size: (usize, usize)) -> Self {
        let pixel = |at: f32, n: usize| (at.round().max(0.0) as usize).min(n - 1);
        let (u, v) = (pixel(place[0], size.0), pixel(place[1], size.1));
        Self { columns: u..u + 1, rows: v..v + 1 }.widened(by, size)
    }

    /// Part of this region inside `plane`; may be empty.
    #[must_use]
    pub fn within(&self, plane: &Plane) -> Self {
        let cut = |r: &Range<usize>, size: usize| r.start.min(size)..r.end.min(size).max(r.start.min(size));
        Self { columns: cut(&self.columns, plane.width()), rows: cut(&self.rows, plane.height()) }
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// Whether the region holds no pixel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// This region with `by` more pixels on each side, inside an image of `size`.
    pub fn widened(&self, by: usize, size: (usize, usize)) -> Self {
        let wider = |range: &Range<usize>, n: usize| range.start.saturating_sub(by)..(range.end + by).min(n);
        Self { columns: wider(&self.columns, size.0), rows: wider(&self.rows, size.1) }
    }
}

/// Values of a [`Region`]. Rows lie `stride` apart, so that they can begin and end with whole vectors.
#[derive(Debug, Default, Clone)]
pub struct Tile {
    region: Region,
    stride: usize,
    data: Aligned,
}

impl Tile {
    /// `stride` is at least the region's width. The contents are unspecified until written.
    pub fn reset(&mut self, region: &Region, stride: usize) {
        debug_assert!(stride >= region.columns.len(), "rows do not overlap");
        self.region = region.clone();
        self.stride = stride;
        self.data.grow(stride * region.rows.len());
    }

    pub fn region(&self) -> &Region {
        &self.region
    }

    #[inline]
    pub fn row(&self, v: usize) -> &[f32] {
        let start = (v - self.region.rows.start) * self.stride;
        &self.data[start..start + self.region.columns.len()]
    }

    /// The held columns of row `v` of the image, and the padding up to the next row.
    pub(crate) fn padded_row(&self, v: usize) -> &[f32] {
        let start = (v - self.region.rows.start) * self.stride;
        &self.data[start..start + self.stride]
    }

    #[inline]
    pub fn at(&self, u: usize, v: usize) -> f32 {
        self.row(v)[u - self.region.columns.start]
    }

    /// `count` rows from row `v` of the image on, with the padding between them; mutable.
    pub(crate) fn rows_from_mut(&mut self, v: usize, count: usize) -> &mut [f32] {
        let start = (v - self.region.rows.start) * self.stride;
        &mut self.data[start..start + count * self.stride]
    }

    pub fn row_mut(&mut self, v: usize) -> &mut [f32] {
        let width = self.region.columns.len();
        &mut self.rows_from_mut(v, 1)[..width]
    }
}

/// `n` pixels cut into as few nearly equal parts of at most `max` as possible; all but the last end at even places.
pub fn cuts(n: usize, max: usize) -> Vec<Range<usize>> {
    let count = n.div_ceil(max.max(2)).max(1);
    // Rounded up, so that no part grows by more than the one before it shrinks.
    let cut = |i: usize| if i == count { n } else { (n * i / count).next_multiple_of(2).min(n) };
    (0..count).map(|i| cut(i)..cut(i + 1)).collect()
}

/// Rows of `plane` cut at `columns` and `rows`: for each part, row by row of parts, its pieces of rows.
pub fn split_mut<'p>(plane: &'p mut Plane, columns: &[Range<usize>], rows: &[Range<usize>]) -> Vec<Vec<&'p mut [f32]>> {
    let width = plane.width();
    let mut parts: Vec<Vec<&mut [f32]>> = Vec::with_capacity(columns.len() * rows.len());
    let mut lines = plane.data_mut().chunks_mut(width.max(1));
    for band in rows {
        let first = parts.len();
        parts.extend(columns.iter().map(|_| Vec::with_capacity(band.len())));
        // By reference: the next band goes on where this one ends.
        for line in lines.by_ref().take(band.len()) {
            let mut rest = line;
            for (part, range) in parts[first..].iter_mut().zip(columns) {
                let (mine, others) = rest.split_at_mut(range.len());
                part.push(mine);
                rest = others;
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_cover_everything_once_and_split_planes() {
        let region = Region { columns: 10..13, rows: 5..7 };
        assert_eq!(region.widened(6, (14, 9)), Region { columns: 4..14, rows: 0..9 });
        assert_eq!(Region::around([10.6, -3.0], 2, (14, 9)), Region { columns: 9..14, rows: 0..3 });
        for n in [1, 2, 7, 16, 99, 148, 149, 1600] {
            for max in [2, 8, 148] {
                let parts = cuts(n, max);
                assert_eq!(parts.iter().cloned().flatten().collect::<Vec<_>>(), (0..n).collect::<Vec<_>>());
                assert!(parts.iter().all(|p| p.start % 2 == 0 && p.len() <= max + 1), "{n} {max}");
            }
        }
        let mut plane = Plane::zeros(21, 13);
        let (columns, rows) = (cuts(21, 8), cuts(13, 6));
        let parts = split_mut(&mut plane, &columns, &rows);
        assert_eq!(parts.len(), columns.len() * rows.len());
        for (index, part) in parts.into_iter().enumerate() {
            part.into_iter().for_each(|row| row.fill(index as f32 + 1.0));
        }
        for v in 0..13 {
            for u in 0..21 {
                let at = |parts: &[Range<usize>], x: usize| parts.iter().position(|p| p.contains(&x)).expect("covered");
                assert_eq!(plane.at(u, v), (at(&rows, v) * columns.len() + at(&columns, u) + 1) as f32);
            }
        }
    }
}
