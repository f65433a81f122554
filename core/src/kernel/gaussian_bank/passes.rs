//! The two passes of the filters over a tile, and the rows that are stored between them.
//!
//! Along the rows, two pixels at the same distance from the centre are added, then multiplied into all levels that
//! reach that far; the sums of up to [`MOST`] levels over [`BLOCK`] columns stay in registers. Between the passes rows
//! are stored in blocks of columns ([`Band`]), each contiguous, so that they stay in the first cache and loops over
//! them need no bounds checks. Along the columns a few rows of one level are made at once, and their difference from
//! the previous level: each step outwards loads only two rows, the others are in registers already, one place further.

pub(crate) use crate::kernel::machine::{BLOCK_COLUMNS as BLOCK, WIDEST_VECTOR as VECTOR};

use crate::kernel::gaussian_bank::weights::{Axis, Dense, Weights};
use crate::kernel::machine::{load, store};
use crate::plane::memory::Aligned;
use pulp::Simd;
use std::ops::Range;

/// Levels computed at once; with more, vector registers run out.
pub(crate) const MOST: usize = 8;

/// Taps of some levels, interleaved.
#[derive(Debug)]
pub(crate) struct Packed {
    pub levels: Range<usize>,
    /// `taps[distance·levels + level]`, zero beyond a level's radius.
    taps: Vec<f32>,
    /// Radius of each level; they never decrease.
    radii: Vec<usize>,
}

/// All levels of `axis`, in as few groups of (nearly) equal size as [`MOST`] allows.
pub(crate) fn packed(axis: &Axis) -> Vec<Packed> {
    let count = axis.levels.len();
    // Groups of even size: a small rest would load the pixels for few levels.
    let size = count.div_ceil(count.div_ceil(MOST).max(1)).max(1);
    (0..count)
        .step_by(size)
        .map(|first| {
            let levels = first..(first + size).min(count);
            let kernels: Vec<&[f32]> = axis.levels[levels.clone()].iter().map(|level| &level.half[..]).collect();
            let radii: Vec<usize> = kernels.iter().map(|half| half.len() - 1).collect();
            let radius = radii.iter().copied().max().unwrap_or(0);
            let tap = |distance: usize| kernels.iter().map(move |half| half.get(distance).copied().unwrap_or(0.0));
            Packed { taps: (0..=radius).flat_map(tap).collect(), radii, levels }
        })
        .collect()
}

/// Layout of a row's values: `columns` of them, a whole number of blocks, which begin `step` apart.
#[derive(Clone, Copy)]
pub(crate) struct Blocks {
    pub columns: usize,
    pub step: usize,
}

impl Blocks {
    #[inline(always)]
    fn place(self, column: usize) -> usize {
        column / BLOCK * self.step + column % BLOCK
    }
}

/// Makes one row of a group's levels. `line[reach + i]` is the pixel of output column `i`.
#[inline(always)]
pub(crate) fn convolve_row<S: Simd>(
    simd: S,
    group: &Packed,
    line: (&[f32], usize),
    blocks: Blocks,
    out: &mut [&mut [f32]],
) {
    // The number of levels is a constant of each version, so that all sums stay in registers.
    match group.levels.len() {
        1 => convolve::<S, 1>(simd, group, line, blocks, out),
        2 => convolve::<S, 2>(simd, group, line, blocks, out),
        3 => convolve::<S, 3>(simd, group, line, blocks, out),
        4 => convolve::<S, 4>(simd, group, line, blocks, out),
        5 => convolve::<S, 5>(simd, group, line, blocks, out),
        6 => convolve::<S, 6>(simd, group, line, blocks, out),
        7 => convolve::<S, 7>(simd, group, line, blocks, out),
        _ => convolve::<S, MOST>(simd, group, line, blocks, out),
    }
}

#[inline(always)]
fn convolve<S: Simd, const L: usize>(
    simd: S,
    group: &Packed,
    (line, reach): (&[f32], usize),
    blocks: Blocks,
    out: &mut [&mut [f32]],
) {
    let out: &mut [&mut [f32]; L] = out.try_into().expect("as many rows as levels");
    let radii: &[usize; L] = group.radii[..].try_into().expect("as many radii as levels");
    let lanes = S::F32_LANES;
    for start in (0..blocks.columns).step_by(2 * lanes) {
        let at = reach + start;
        let radius = radii[L - 1];
        let mut acc = [[simd.splat_f32s(0.0); 2]; L];
        let centre = [load::<S>(line, at), load::<S>(line, at + lanes)];
        for (acc, &tap) in acc.iter_mut().zip(&group.taps[..L]) {
            let tap = simd.splat_f32s(tap);
            *acc = [simd.mul_f32s(tap, centre[0]), simd.mul_f32s(tap, centre[1])];
        }
        // For each distance, the pixels before and behind and all levels' taps. Iterators need no bounds checks.
        let before = line[at - radius..at + 2 * lanes - 1].windows(2 * lanes).rev();
        let behind = line[at + 1..at + 2 * lanes + radius].windows(2 * lanes);
        // Levels are sorted by radius: each distance is multiplied only into the levels that reach it.
        let mut distances = before.zip(behind).zip(group.taps[L..].chunks_exact(L));
        // The levels from `$first` on reach beyond the radius of the level before.
        macro_rules! until_radius_of {
            ($($first:literal)*) => {$(
                if $first < L {
                    let count = radii[$first] - if $first == 0 { 0 } else { radii[$first.max(1) - 1] };
                    for ((before, behind), taps) in distances.by_ref().take(count) {
                        let sum = [
                            simd.add_f32s(load::<S>(before, 0), load::<S>(behind, 0)),
                            simd.add_f32s(load::<S>(before, lanes), load::<S>(behind, lanes)),
                        ];
                        let taps: &[f32; L] = taps.try_into().expect("one tap a level");
                        for level in $first..L {
                            let tap = simd.splat_f32s(taps[level]);
                            acc[level][0] = simd.mul_add_f32s(tap, sum[0], acc[level][0]);
                            acc[level][1] = simd.mul_add_f32s(tap, sum[1], acc[level][1]);
                        }
                    }
                }
            )*};
        }
        until_radius_of!(0 1 2 3 4 5 6 7);
        // Both vectors belong to one block.
        let place = blocks.place(start);
        for level in 0..L {
            let out = &mut out[level][place..place + 2 * lanes];
            store::<S>(out, 0, acc[level][0]);
            store::<S>(out, lanes, acc[level][1]);
        }
    }
}

/// Overwrites the columns that lie near a border; `line[reach + i]` is column `columns.start + i`.
#[inline(always)]
pub(crate) fn edge_columns<S: Simd>(
    simd: S,
    level: &Weights,
    columns: &Range<usize>,
    (line, reach): (&[f32], usize),
    blocks: Blocks,
    out: &mut [f32],
) {
    let lanes = S::F32_LANES;
    for dense in [&level.head, &level.tail] {
        let mine = dense.outs.start.max(columns.start)..dense.outs.end.min(columns.end);
        if mine.is_empty() {
            continue;
        }
        let inputs = dense.inputs(&mine);
        let pixels = &line[reach + inputs.start - columns.start..reach + inputs.end - columns.start];
        let weights = &dense.weights[(inputs.start - dense.ins.start) * dense.stride..][..pixels.len() * dense.stride];
        let first = dense.outs.start;
        for start in (0..dense.outs.len()).step_by(lanes) {
            let outs = first + start..(first + start + lanes).min(dense.outs.end);
            let part = outs.start.max(mine.start)..outs.end.min(mine.end);
            if part.is_empty() {
                continue;
            }
            // Two sums, so that neither waits for the other's latency.
            let mut acc = [simd.splat_f32s(0.0); 2];
            let (mut row, mut input) = (start, 0);
            while input + 1 < pixels.len() {
                for (i, acc) in acc.iter_mut().enumerate() {
                    let weights = load::<S>(weights, row + i * dense.stride);
                    *acc = simd.mul_add_f32s(simd.splat_f32s(pixels[input + i]), weights, *acc);
                }
                (row, input) = (row + 2 * dense.stride, input + 2);
            }
            if let Some(&pixel) = pixels.get(input) {
                acc[0] = simd.mul_add_f32s(simd.splat_f32s(pixel), load::<S>(weights, row), acc[0]);
            }
            let mut made = [0.0f32; VECTOR];
            store::<S>(&mut made, 0, simd.add_f32s(acc[0], acc[1]));
            for (output, value) in part.clone().zip(&made[part.start - outs.start..]) {
                out[blocks.place(output - columns.start)] = *value;
            }
        }
    }
}

/// Destination of some finished rows of a block of columns.
pub(crate) struct Sink<'a> {
    /// Rows of the level, [`BLOCK`] apart; they hold the previous level's until they are written.
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

/// Computes `ROWS` rows away from the borders; the first one is row `radius` of `rows`.
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
                // One tap farther, the rows are those already loaded, shifted by one, and a new row.
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

/// Computes `ROWS` rows near a border, from row `first` on; `rows` are those of the band from row `top` on.
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
    // Weights differ from row to row here, so that rows share loads but no sums.
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

pub(crate) type Row = [f32; BLOCK];

#[derive(Debug, Default)]
pub(crate) struct Band {
    data: Aligned,
    blocks: usize,
    room: usize,
}

impl Band {
    pub fn reset(&mut self, blocks: usize, room: usize) {
        self.data.grow(blocks * room * BLOCK);
        (self.blocks, self.room) = (blocks, room);
    }

    /// Values from a block's row to the same row of the next block.
    pub fn step(&self) -> usize {
        self.room * BLOCK
    }

    #[inline(always)]
    pub fn block(&self, block: usize) -> &[Row] {
        self.data[block * self.step()..(block + 1) * self.step()].as_chunks().0
    }

    /// Row `row` of the first block; the same row of each other block lies [`Band::step`] values further.
    #[inline(always)]
    pub fn row_mut(&mut self, row: usize) -> &mut [f32] {
        let end = self.blocks * self.step();
        &mut self.data[row * BLOCK..end]
    }

    pub fn move_rows(&mut self, rows: std::ops::Range<usize>, to: usize) {
        for block in 0..self.blocks {
            let start = block * self.room;
            let from = (start + rows.start) * BLOCK..(start + rows.end) * BLOCK;
            self.data.copy_within(from, (start + to) * BLOCK);
        }
    }
}
