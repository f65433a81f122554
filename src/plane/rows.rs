//! A horizontal strip of an image: some of its rows, at their place.
//!
//! Blurs work strip by strip so that memory stays bounded and data stays in the cache. A [`Rows`] knows which rows
//! of the image it holds; its buffer is reused.

use std::ops::Range;

/// Rows `first … first + len` of an image of `width` columns. The buffer keeps its capacity when it is reset.
#[derive(Debug, Default, Clone)]
pub struct Rows {
    first: usize,
    width: usize,
    len: usize,
    data: Vec<f32>,
}

impl Rows {
    /// Makes this the rows `range` of an image of `width` columns. The contents are unspecified until written.
    pub fn reset(&mut self, width: usize, range: Range<usize>) {
        self.first = range.start;
        self.width = width;
        self.len = range.len();
        let needed = width * range.len();
        if self.data.len() < needed {
            self.data.resize(needed, 0.0);
        }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The rows of the image that are held.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.len
    }

    /// Row `v` of the image.
    ///
    /// # Panics
    /// When `v` is not held.
    pub fn row(&self, v: usize) -> &[f32] {
        let start = (v - self.first) * self.width;
        &self.data[..self.len * self.width][start..start + self.width]
    }

    /// Row `v` of the image, to be written.
    ///
    /// # Panics
    /// When `v` is not held.
    pub fn row_mut(&mut self, v: usize) -> &mut [f32] {
        let start = (v - self.first) * self.width;
        &mut self.data[..self.len * self.width][start..start + self.width]
    }

    /// All held rows, one after the other.
    pub fn data(&self) -> &[f32] {
        &self.data[..self.len * self.width]
    }
}

/// Where rows are read from: a whole [`super::Plane`] or a strip.
pub trait RowSource: Sync {
    /// Row `v` of the image.
    fn source_row(&self, v: usize) -> &[f32];
}

impl RowSource for Rows {
    fn source_row(&self, v: usize) -> &[f32] {
        self.row(v)
    }
}

impl RowSource for super::Plane {
    fn source_row(&self, v: usize) -> &[f32] {
        self.row(v)
    }
}
