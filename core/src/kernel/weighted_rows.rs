//! Rows of weighted sums of frames that are read between their columns.
//!
//! Each frame pixel adds to two pixels of the sum, the one at its place and the one before, in proportion to the
//! frame's fraction of a column. So two sums are made of the frames, both from the same loads and in registers, and
//! finally added, the second one shifted by a pixel. Where no frame has a fraction there is one sum. The search and the
//! patches around its features both use this, so a pixel has the same bits in either.

use crate::kernel::vectors::{MAX_VECTORS, in_vectors, load, store};
use crate::plane::aligned::Aligned;
use pulp::{Arch, Simd, WithSimd};

/// Maximum number of values in a vector of any processor.
const LONGEST: usize = 16;

/// Pixels of one frame in a sum, from the first one that is read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tap<'a> {
    /// Pixels; rows as far apart as in the image.
    pub pixels: &'a [f32],
    /// Weights of the pixels at their own place and a pixel to the left.
    pub weights: [f32; 2],
}

impl<'a> Tap<'a> {
    /// `pixels` read a fraction `part_u` of a column to the right, with the weight `weight`.
    pub fn new(pixels: &'a [f32], weight: f32, part_u: f32) -> Self {
        Self { pixels, weights: [weight * (1.0 - part_u), weight * part_u] }
    }
}

/// Buffers for a row of both sums, and the processor's kind; reused from row to row.
#[derive(Debug)]
pub(crate) struct WeightedRows {
    arch: Arch,
    sums: [Aligned; 2],
}

impl Default for WeightedRows {
    fn default() -> Self {
        Self { arch: Arch::new(), sums: Default::default() }
    }
}

impl WeightedRows {
    /// Writes rows `rows` of the sum of `taps`, `columns` values each, to `out`, where rows lie `stride` apart. Row 0
    /// is the first one of the taps' pixels; the taps' rows lie `width` apart, and each holds a pixel more than
    /// `columns`.
    pub fn make(
        &mut self,
        taps: &[Tap<'_>],
        width: usize,
        columns: usize,
        rows: std::ops::Range<usize>,
        out: &mut [f32],
        stride: usize,
    ) {
        let [here, shifted] = &mut self.sums;
        here.grow(columns + LONGEST);
        shifted.grow(columns + LONGEST);
        let between = taps.iter().any(|tap| tap.weights[1] != 0.0);
        if columns < LONGEST {
            for (out, v) in out.chunks_mut(stride).zip(rows) {
                short_row(taps, v * width, between, &mut out[..columns]);
            }
            return;
        }
        self.arch.dispatch(RowsJob { taps, width, columns, rows, between, here, shifted, out, stride });
    }
}

/// Computes a row too short for vectors.
fn short_row(taps: &[Tap<'_>], row: usize, between: bool, out: &mut [f32]) {
    let sum = |i: usize, which: usize| {
        taps.iter().fold(0.0f32, |sum, tap| tap.weights[which].mul_add(tap.pixels[row + i], sum))
    };
    for (i, out) in out.iter_mut().enumerate() {
        *out = if between { sum(i, 0) + sum(i + 1, 1) } else { sum(i, 0) };
    }
}

struct RowsJob<'a> {
    taps: &'a [Tap<'a>],
    width: usize,
    /// At least [`LONGEST`].
    columns: usize,
    rows: std::ops::Range<usize>,
    /// Whether a second sum is needed.
    between: bool,
    here: &'a mut [f32],
    shifted: &'a mut [f32],
    out: &'a mut [f32],
    stride: usize,
}

impl WithSimd for RowsJob<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (index, v) in self.rows.enumerate() {
            let (out, row) = (&mut self.out[index * self.stride..][..self.columns], v * self.width);
            if self.between {
                // The second sum needs one value more.
                in_vectors!(S, self.columns + 1, |V, places| {
                    let sums = two_sums::<S, V>(simd, self.taps, row, places);
                    for i in 0..V {
                        store::<S>(self.here, places[i], sums[0][i]);
                        store::<S>(self.shifted, places[i], sums[1][i]);
                    }
                });
                in_vectors!(S, self.columns, |V, places| {
                    for at in places {
                        let sum = simd.add_f32s(load::<S>(self.here, at), load::<S>(self.shifted, at + 1));
                        store::<S>(out, at, sum);
                    }
                });
            } else {
                in_vectors!(S, self.columns, |V, places| {
                    let sums = one_sum::<S, V>(simd, self.taps, row, places);
                    for i in 0..V {
                        store::<S>(out, places[i], sums[i]);
                    }
                });
            }
        }
    }
}

/// Vectors of both sums at `places` of the row that begins `row` values after the taps.
#[inline(always)]
fn two_sums<S: Simd, const V: usize>(simd: S, taps: &[Tap<'_>], row: usize, places: [usize; V]) -> [[S::f32s; V]; 2] {
    let mut sums = [[simd.splat_f32s(0.0); V]; 2];
    for tap in taps {
        let weights = tap.weights.map(|weight| simd.splat_f32s(weight));
        let pixels = &tap.pixels[row..];
        for i in 0..V {
            let pixels = load::<S>(pixels, places[i]);
            sums[0][i] = simd.mul_add_f32s(weights[0], pixels, sums[0][i]);
            sums[1][i] = simd.mul_add_f32s(weights[1], pixels, sums[1][i]);
        }
    }
    sums
}

/// Vectors of the first sum alone at `places`.
#[inline(always)]
fn one_sum<S: Simd, const V: usize>(simd: S, taps: &[Tap<'_>], row: usize, places: [usize; V]) -> [S::f32s; V] {
    let mut sums = [simd.splat_f32s(0.0); V];
    for tap in taps {
        let (weight, pixels) = (simd.splat_f32s(tap.weights[0]), &tap.pixels[row..]);
        for i in 0..V {
            sums[i] = simd.mul_add_f32s(weight, load::<S>(pixels, places[i]), sums[i]);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_any_length_have_the_bits_of_short_ones() {
        let frames: Vec<Vec<f32>> =
            (0..3).map(|t| (0..400).map(|i| ((i * 31 + t * 7 + i * i % 11) % 29) as f32 / 29.0).collect()).collect();
        let mut maker = WeightedRows::default();
        for parts in [[0.0, 0.0, 0.0], [0.5, 0.5, 0.5], [0.0, 0.3, 0.9]] {
            let taps: Vec<Tap<'_>> =
                frames.iter().zip(parts).map(|(frame, part)| Tap::new(&frame[3..], 1.0 / 3.0, part)).collect();
            for columns in [1, 15, 16, 17, 33, 100, 129] {
                let mut out = vec![f32::NAN; 2 * 131];
                maker.make(&taps, 133, columns, 1..3, &mut out, 131);
                for (v, row) in out.chunks(131).enumerate() {
                    let mut expected = vec![0.0; columns];
                    short_row(&taps, (v + 1) * 133, parts.iter().any(|&part| part > 0.0), &mut expected);
                    assert_eq!(row[..columns], expected, "{parts:?} {columns}");
                    // No other values are written.
                    assert!(row[columns..].iter().all(|x| x.is_nan()), "{parts:?} {columns}");
                }
            }
        }
    }
}
