//! The pass along the columns: a few rows of one level at once, and their difference from the level before.
//!
//! The rows above and below that belong to the next distance from the centre are mostly those that already lie in registers, one place further; each
//! step loads only two. Columns are taken a block at a time, so that all rows which a batch reads there stay in the first cache.

use super::edge::Dense;
use super::lanes::{BLOCK, load, store};
use pulp::Simd;

/// The rows of one level that the pass reads: a ring, in which row `v` of the image is row `v % rows` of the data.
#[derive(Clone, Copy)]
pub(super) struct Band<'a> {
    pub data: &'a [f32],
    pub rows: usize,
    pub stride: usize,
}

impl Band<'_> {
    #[inline(always)]
    fn before(&self, place: usize) -> usize {
        if place == 0 { self.rows - 1 } else { place - 1 }
    }

    #[inline(always)]
    fn after(&self, place: usize) -> usize {
        if place + 1 == self.rows { 0 } else { place + 1 }
    }
}

/// Where a few finished rows of a block of columns go.
pub(super) struct Sink<'a> {
    /// The level's rows, [`BLOCK`] apart; before, those of the level before it.
    pub level: &'a mut [f32],
    /// The rows of their difference, for all levels but the first; as far apart as the band's.
    pub difference: Option<&'a mut [f32]>,
}

impl Sink<'_> {
    /// Column `within` of the block and `column` of the tile, in row `row`.
    #[inline(always)]
    fn put<S: Simd>(&mut self, simd: S, row: usize, (column, within): (usize, usize), stride: usize, value: S::f32s) {
        let at = row * BLOCK + within;
        if let Some(difference) = self.difference.as_deref_mut() {
            store::<S>(difference, row * stride + column, simd.sub_f32s(value, load::<S>(self.level, at)));
        }
        store::<S>(self.level, at, value);
    }
}

/// `ROWS` rows away from the borders, from row `first` on; the block of columns that begins at `block`.
#[inline(always)]
pub(super) fn inner_rows<S: Simd, const ROWS: usize>(
    simd: S,
    half: &[f32],
    band: Band<'_>,
    first: usize,
    block: usize,
    sink: &mut Sink<'_>,
) {
    let middle = simd.splat_f32s(half[0]);
    let (stride, data) = (band.stride, band.data);
    let first = first % band.rows;
    for within in (0..BLOCK).step_by(S::F32_LANES) {
        let column = block + within;
        let mut above = [middle; ROWS];
        let mut acc = [middle; ROWS];
        let (mut upper, mut lower) = (first, first);
        for i in 0..ROWS {
            if i > 0 {
                lower = band.after(lower);
            }
            above[i] = load::<S>(data, lower * stride + column);
            acc[i] = simd.mul_f32s(middle, above[i]);
        }
        let mut below = above;
        let mut distance = 1;
        macro_rules! step {
            () => {
                let tap = simd.splat_f32s(half[distance]);
                for i in (1..ROWS).rev() {
                    above[i] = above[i - 1];
                }
                upper = band.before(upper);
                above[0] = load::<S>(data, upper * stride + column);
                for i in 1..ROWS {
                    below[i - 1] = below[i];
                }
                lower = band.after(lower);
                below[ROWS - 1] = load::<S>(data, lower * stride + column);
                for i in 0..ROWS {
                    acc[i] = simd.mul_add_f32s(tap, simd.add_f32s(above[i], below[i]), acc[i]);
                }
                distance += 1;
            };
        }
        while distance + 3 < half.len() {
            step!();
            step!();
            step!();
            step!();
        }
        while distance < half.len() {
            step!();
        }
        for (i, &value) in acc.iter().enumerate() {
            sink.put(simd, i, (column, within), stride, value);
        }
    }
}

/// `ROWS` rows near a border, from row `first` on; the block of columns that begins at `block`.
#[inline(always)]
pub(super) fn edge_rows<S: Simd, const ROWS: usize>(
    simd: S,
    dense: &Dense,
    band: Band<'_>,
    first: usize,
    block: usize,
    sink: &mut Sink<'_>,
) {
    let (stride, data) = (band.stride, band.data);
    let inputs = dense.inputs(&(first..first + ROWS));
    let out = first - dense.outs.start;
    for within in (0..BLOCK).step_by(S::F32_LANES) {
        let column = block + within;
        let mut acc = [simd.splat_f32s(0.0); ROWS];
        let mut place = inputs.start % band.rows;
        for input in inputs.clone() {
            let value = load::<S>(data, place * stride + column);
            place = band.after(place);
            let weights: &[f32; ROWS] = dense.row(input)[out..out + ROWS].try_into().expect("one weight a row");
            for i in 0..ROWS {
                acc[i] = simd.mul_add_f32s(value, simd.splat_f32s(weights[i]), acc[i]);
            }
        }
        for (i, &value) in acc.iter().enumerate() {
            sink.put(simd, i, (column, within), stride, value);
        }
    }
}
