//! The pass along the rows: all levels of a row, with each pixel loaded once.
//!
//! Two pixels at the same distance from the centre are added, then multiplied into all levels that reach that far. The
//! sums of up to [`MOST`] levels over [`BLOCK`](crate::kernel::gaussian_bank::lanes::BLOCK) columns stay in vector
//! registers.

use crate::kernel::gaussian_bank::edge::{Axis, Dense, Weights};
use crate::kernel::gaussian_bank::lanes::{BLOCK, VECTOR, load, store};
use pulp::Simd;
use std::ops::Range;

/// Levels computed at once; with more, vector registers run out.
pub(crate) const MOST: usize = 8;

/// Taps of some levels, interleaved.
#[derive(Debug)]
pub(crate) struct Packed {
    /// Range of the levels.
    pub levels: Range<usize>,
    /// `taps[distance·levels + level]`, zero beyond a level's radius.
    taps: Vec<f32>,
    /// Radius of each level; they never decrease.
    radii: Vec<usize>,
}

/// All levels of `axis`, in as few groups of (nearly) equal size as [`MOST`] allows.
pub(crate) fn packed(axis: &Axis) -> Vec<Packed> {
    let count = axis.levels.len();
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
    /// Index of column `column`.
    #[inline(always)]
    fn place(self, column: usize) -> usize {
        column / BLOCK * self.step + column % BLOCK
    }
}

/// Convolves one row: `line[reach + i]` is the pixel of output column `i`, with at least the radius to each side;
/// `out[level]` receives its blocks.
#[inline(always)]
pub(crate) fn convolve_row<S: Simd>(
    simd: S,
    group: &Packed,
    (line, reach): (&[f32], usize),
    blocks: Blocks,
    out: &mut [&mut [f32]],
) {
    let line = (line, reach);
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
        // For each distance, the pixels before and behind and the taps of all levels. Iterators need no bounds checks
        // in the loop.
        let before = line[at - radius..at + 2 * lanes - 1].windows(2 * lanes).rev();
        let behind = line[at + 1..at + 2 * lanes + radius].windows(2 * lanes);
        let mut distances = before.zip(behind).zip(group.taps[L..].chunks_exact(L));
        // The levels from `$first` on reach beyond the radius of the one before it.
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

/// Overwrites the columns of `columns` that lie near a border: `line[reach + i]` is column `columns.start + i`, and
/// `out` receives the blocks that begin there.
#[inline(always)]
pub(crate) fn edge_columns<S: Simd>(
    simd: S,
    level: &Weights,
    columns: &Range<usize>,
    line: (&[f32], usize),
    blocks: Blocks,
    out: &mut [f32],
) {
    for dense in [&level.head, &level.tail] {
        let mine = dense.outs.start.max(columns.start)..dense.outs.end.min(columns.end);
        if !mine.is_empty() {
            edge(simd, dense, &mine, columns, line, blocks, out);
        }
    }
}

#[inline(always)]
fn edge<S: Simd>(
    simd: S,
    dense: &Dense,
    mine: &Range<usize>,
    columns: &Range<usize>,
    (line, reach): (&[f32], usize),
    blocks: Blocks,
    out: &mut [f32],
) {
    let lanes = S::F32_LANES;
    let inputs = dense.inputs(mine);
    let pixels = &line[reach + inputs.start - columns.start..reach + inputs.end - columns.start];
    let weights = &dense.weights[(inputs.start - dense.ins.start) * dense.stride..][..pixels.len() * dense.stride];
    let first = dense.outs.start;
    for start in (0..dense.outs.len()).step_by(lanes) {
        let outs = first + start..(first + start + lanes).min(dense.outs.end);
        let part = outs.start.max(mine.start)..outs.end.min(mine.end);
        if part.is_empty() {
            continue;
        }
        // Two sums, so that neither waits for the other.
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
