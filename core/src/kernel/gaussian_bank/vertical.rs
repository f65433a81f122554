//! The pass along the columns: a few rows of one level at once, and their difference from the previous level.
//!
//! From one distance from the centre to the next, most of the rows above and below are already in registers, one place
//! further; each step loads only two. Columns are taken a block at a time, so that all rows which a batch reads there
//! stay in the first cache.

use crate::kernel::gaussian_bank::band::Row;
use crate::kernel::gaussian_bank::edge::Dense;
use crate::kernel::gaussian_bank::lanes::{BLOCK, load, store};
use pulp::Simd;

/// Destination of a few finished rows of a block of columns.
pub(crate) struct Sink<'a> {
    /// Rows of the level, [`BLOCK`] apart; before they are written, those of the previous level.
    pub level: &'a mut [f32],
    /// Rows of the difference of the two, `stride` apart; `None` for the first level.
    pub difference: Option<&'a mut [f32]>,
}

impl Sink<'_> {
    /// Writes column `within` of the block and `column` of the tile, in row `row`.
    #[inline(always)]
    fn put<S: Simd>(&mut self, simd: S, row: usize, (column, within): (usize, usize), stride: usize, value: S::f32s) {
        let at = row * BLOCK + within;
        if let Some(difference) = self.difference.as_deref_mut() {
            store::<S>(difference, row * stride + column, simd.sub_f32s(value, load::<S>(self.level, at)));
        }
        store::<S>(self.level, at, value);
    }
}

/// Computes `ROWS` rows away from the borders; the first one is row `radius` of `rows`, which holds the kernel's radius
/// more on both sides. `column` is the block's first one in the tile.
#[inline(always)]
pub(crate) fn inner_rows<S: Simd, const ROWS: usize>(
    simd: S,
    half: &[f32],
    rows: &[Row],
    column: usize,
    stride: usize,
    sink: &mut Sink<'_>,
) {
    let radius = half.len() - 1;
    let middle: &[Row; ROWS] = rows[radius..radius + ROWS].try_into().expect("as many rows as are made");
    // Sorted by distance from the first and from the last of the rows.
    let (upper, lower) = (&rows[..radius], &rows[radius + ROWS..][..radius]);
    let (upper_rest, upper) = upper.as_rchunks::<4>();
    let (lower, lower_rest) = lower.as_chunks::<4>();
    let (taps, taps_rest) = half[1..].as_chunks::<4>();
    for part in 0..BLOCK / S::F32_LANES {
        let tap = simd.splat_f32s(half[0]);
        let (mut above, mut acc) = ([tap; ROWS], [tap; ROWS]);
        for i in 0..ROWS {
            above[i] = S::as_simd_f32s(&middle[i]).0[part];
            acc[i] = simd.mul_f32s(tap, above[i]);
        }
        let mut below = above;
        // A macro, since a closure would not be compiled for the processor's features.
        macro_rules! step {
            ($tap:expr, $upper:expr, $lower:expr) => {
                // One tap farther, the rows needed are those already loaded, shifted by one, and a new one.
                let tap = simd.splat_f32s($tap);
                for i in (1..ROWS).rev() {
                    above[i] = above[i - 1];
                }
                above[0] = S::as_simd_f32s($upper).0[part];
                for i in 1..ROWS {
                    below[i - 1] = below[i];
                }
                below[ROWS - 1] = S::as_simd_f32s($lower).0[part];
                for i in 0..ROWS {
                    acc[i] = simd.mul_add_f32s(tap, simd.add_f32s(above[i], below[i]), acc[i]);
                }
            };
        }
        for ((taps, upper), lower) in taps.iter().zip(upper.iter().rev()).zip(lower) {
            step!(taps[0], &upper[3], &lower[0]);
            step!(taps[1], &upper[2], &lower[1]);
            step!(taps[2], &upper[1], &lower[2]);
            step!(taps[3], &upper[0], &lower[3]);
        }
        for ((&tap, upper), lower) in taps_rest.iter().zip(upper_rest.iter().rev()).zip(lower_rest) {
            step!(tap, upper, lower);
        }
        let within = part * S::F32_LANES;
        for (i, &value) in acc.iter().enumerate() {
            sink.put(simd, i, (column + within, within), stride, value);
        }
    }
}

/// Computes `ROWS` rows near a border, from row `first` on, of a block of columns whose first one in the tile is
/// `column`. `rows` are those of the band, which begins at row `top`.
#[inline(always)]
pub(crate) fn edge_rows<S: Simd, const ROWS: usize>(
    simd: S,
    dense: &Dense,
    (rows, top): (&[Row], usize),
    first: usize,
    column: usize,
    stride: usize,
    sink: &mut Sink<'_>,
) {
    let inputs = dense.inputs(&(first..first + ROWS));
    let out = first - dense.outs.start;
    for part in 0..BLOCK / S::F32_LANES {
        let mut acc = [simd.splat_f32s(0.0); ROWS];
        for (input, row) in inputs.clone().zip(&rows[inputs.start - top..]) {
            let value = S::as_simd_f32s(row).0[part];
            let weights: &[f32; ROWS] = dense.row(input)[out..out + ROWS].try_into().expect("one weight a row");
            for i in 0..ROWS {
                acc[i] = simd.mul_add_f32s(value, simd.splat_f32s(weights[i]), acc[i]);
            }
        }
        let within = part * S::F32_LANES;
        for (i, &value) in acc.iter().enumerate() {
            sink.put(simd, i, (column + within, within), stride, value);
        }
    }
}
