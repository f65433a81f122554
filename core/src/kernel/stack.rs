//! Rows of motion-stack images, for several slopes at once.
//!
//! The slopes of a group read the same rows of the same frames, a few columns apart, so each row comes from memory
//! once; slopes that agree in their vertical part share the mixing of two rows into one. Rows are made some at a time,
//! since setting up a sum takes long. Where every frame of a row covers the column and the next one, rows are weighted
//! sums of the frames' rows (`WeightedRows`). Each frame pixel adds to two pixels, its own place and one before: two
//! sums of the same loads are added, the second shifted by a pixel; one sum is enough where all fractions are alike. At
//! the sides frames are added in turn and divided by their number. Patches have the same bits.

use crate::kernel::machine::{MAX_VECTORS, WIDEST_VECTOR, in_vectors, load, store};
use crate::kernel::masked_rows::MaskedRows;
pub use crate::kernel::offset::FrameOffset;
use crate::plane::{Plane, memory::Aligned};
use multiversion::multiversion;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

#[derive(Debug)]
pub struct RowStacker<'a> {
    frames: &'a [&'a Plane],
    slopes: Vec<&'a [FrameOffset]>,
    groups: Vec<Group<'a>>,
    mixed: Aligned,
    counts: Vec<f32>,
    sums: WeightedRows,
    /// `None` where all samples are seen.
    masked: Option<MaskedRows>,
}

/// Slopes that read the same rows in the same proportions.
#[derive(Debug)]
struct Group<'a> {
    slopes: Range<usize>,
    run: Run<'a>,
}

/// Data shared by consecutive rows that the same frames cover.
#[derive(Debug, Default)]
struct Run<'a> {
    rows: Range<usize>,
    columns: Range<usize>,
    covering: Vec<usize>,
    /// Columns of the frames that any slope of the group reads.
    wide: Range<usize>,
    mixes: bool,
    /// For each slope the columns covered by all frames.
    inner: Vec<Range<usize>>,
    /// For each slope, unless rows are mixed, the terms of the sum inside the run's first row.
    taps: Vec<Vec<Tap<'a>>>,
}

/// Part of a row of one frame: its pixels from column `left` of the frame on.
struct Source<'s> {
    frame: usize,
    pixels: &'s [f32],
    left: usize,
}

impl<'a> Run<'a> {
    /// Run of rows from `v` on, columns `columns`, of `frames` at `slopes`, which form a group.
    fn new(frames: &'a [&'a Plane], slopes: &[&'a [FrameOffset]], v: usize, columns: Range<usize>) -> Self {
        let (width, height) = frames[0].size();
        let first = slopes[0];
        let covering: Vec<usize> = (0..frames.len()).filter(|&t| first[t].covers_rows(height).contains(&v)).collect();
        // A run ends where a frame begins or ceases to cover, so that all its rows have the same terms.
        let changes = first.iter().map(|offset| offset.covers_rows(height)).flat_map(|rows| [rows.start, rows.end]);
        // Rows above a frame are copies of its first row, so a run must not cross into the frame.
        let reads = covering.iter().map(|&t| usize::try_from(-first[t].whole_v).unwrap_or(0));
        let end = changes.chain(reads).filter(|&change| change > v).min().unwrap_or(height);
        let shifts = || slopes.iter().flat_map(|slope| slope.iter()).map(|offset| offset.whole_u);
        let wide_start = (columns.start as i64 + shifts().min().unwrap_or(0)).clamp(0, width as i64 - 1);
        let wide_end = (columns.end as i64 + shifts().max().unwrap_or(0) + 1).clamp(wide_start + 1, width as i64);
        let inner: Vec<Range<usize>> = slopes
            .iter()
            .map(|offsets| {
                let reads = covering.iter().map(|&frame| {
                    // One column more to the right, needed or not: taps read a pixel beyond.
                    FrameOffset::covered(offsets[frame].whole_u, 1.0, 0, width)
                });
                let inner = reads.fold(columns.clone(), |a, b| a.start.max(b.start)..a.end.min(b.end));
                if covering.is_empty() || inner.is_empty() { columns.start..columns.start } else { inner }
            })
            .collect();
        // Terms into the frames themselves serve all rows of the run; mixed rows exist only for a few rows at a time.
        let mixes = covering.iter().any(|&frame| first[frame].part_v > 0.0);
        let scale = 1.0 / covering.len() as f32;
        let taps = |(offsets, inner): (&&'a [FrameOffset], &Range<usize>)| -> Vec<Tap<'a>> {
            let tap = |&frame: &usize| {
                let (pixels, offset) = (frames[frame], &offsets[frame]);
                let (x, y) = (inner.start as i64 + offset.whole_u, (v as i64 + offset.whole_v).max(0));
                Tap::new(&pixels.data()[y as usize * width + x as usize..], scale, offset.part_u)
            };
            if inner.is_empty() { Vec::new() } else { covering.iter().map(tap).collect() }
        };
        let taps = if mixes { Vec::new() } else { slopes.iter().zip(&inner).map(taps).collect() };
        Self { rows: v..end, columns, wide: wide_start as usize..wide_end as usize, mixes, inner, taps, covering }
    }
}

impl<'a> RowStacker<'a> {
    /// Stacker for `frames` of one size in time order and their offsets for each slope.
    pub fn new(frames: &'a [&'a Plane], slopes: Vec<&'a [FrameOffset]>) -> Self {
        let vertical = |slope: &[FrameOffset]| -> Vec<(i64, f32, i64)> {
            slope.iter().map(|o| (o.whole_v, o.part_v, o.before_v)).collect()
        };
        let mut groups: Vec<Group<'_>> = Vec::new();
        for index in 0..slopes.len() {
            match groups.last_mut() {
                // Slopes alike along v share mixed rows; in the order of the grid they are neighbours.
                Some(Group { slopes: group, .. }) if vertical(slopes[group.start]) == vertical(slopes[index]) => {
                    group.end = index + 1;
                }
                _ => groups.push(Group { slopes: index..index + 1, run: Run::default() }),
            }
        }
        let (mixed, counts, sums) = (Aligned::default(), Vec::new(), WeightedRows::default());
        Self { frames, slopes, groups, mixed, counts, sums, masked: any_masked(frames).then(MaskedRows::default) }
    }

    /// Writes `rows` and `columns` of each slope's motion-stack image to its slice of `outs`, with rows `stride` apart.
    pub fn rows(&mut self, rows: Range<usize>, columns: &Range<usize>, outs: &mut [&mut [f32]], stride: usize) {
        for index in 0..self.groups.len() {
            let mut next = rows.start;
            while next < rows.end {
                let Group { slopes, run } = &mut self.groups[index];
                // Runs are kept between calls, since the next batch mostly continues one.
                if !run.rows.contains(&next) || run.columns != *columns {
                    *run = Run::new(self.frames, &self.slopes[slopes.clone()], next, columns.clone());
                }
                let part = next..rows.end.min(run.rows.end);
                next = part.end;
                self.group_rows(index, part.clone(), outs, (part.start - rows.start) * stride, stride);
            }
        }
        let Some(masked) = &mut self.masked else { return };
        for (offsets, out) in self.slopes.iter().zip(outs) {
            for (v, row) in rows.clone().zip(out.chunks_mut(stride)) {
                masked.mend(self.frames, offsets, v, columns, &mut row[..columns.len()]);
            }
        }
    }

    /// Writes `rows` of one run, from `first` on in each of `outs`.
    fn group_rows(&mut self, group: usize, rows: Range<usize>, outs: &mut [&mut [f32]], first: usize, stride: usize) {
        let Self { frames, slopes, groups, mixed, counts, sums, .. } = self;
        let Group { slopes: group, run } = &groups[group];
        let width = frames[0].width();
        let Run { columns, wide, covering, .. } = run;
        let upper = |frame: usize, v: usize| (v as i64 + slopes[group.start][frame].whole_v).max(0) as usize;
        // All rows of one frame, then of the next; each row begins a cache line.
        let mixed_stride = wide.len().next_multiple_of(WIDEST_VECTOR);
        // Rows are mixed once for all slopes of the group, which differ only along u.
        if run.mixes {
            mixed.grow(covering.len() * rows.len() * mixed_stride);
            for (&frame, mixed) in covering.iter().zip(mixed.chunks_exact_mut(rows.len() * mixed_stride)) {
                let y = upper(frame, rows.start);
                let from = &frames[frame].data()[y * width + wide.start..];
                mix(from, width, slopes[group.start][frame].part_v, wide.len(), mixed, mixed_stride);
            }
        }
        let mut taps: Vec<Tap<'_>> = Vec::with_capacity(if run.mixes { covering.len() } else { 0 });
        for (index, slope) in group.clone().enumerate() {
            let (offsets, out, inner) = (slopes[slope], &mut outs[slope][first..], &run.inner[index]);
            if inner.is_empty() {
                continue;
            }
            let here = &mut out[inner.start - columns.start..];
            if run.mixes {
                taps.clear();
                let mixed = mixed.chunks_exact(rows.len() * mixed_stride);
                taps.extend(covering.iter().zip(mixed).map(|(&frame, mixed)| {
                    let x = (inner.start as i64 + offsets[frame].whole_u) as usize - wide.start;
                    Tap::new(&mixed[x..], 1.0 / covering.len() as f32, offsets[frame].part_u)
                }));
                sums.make(&taps, mixed_stride, inner.len(), 0..rows.len(), here, stride);
            } else {
                let row = rows.start - run.rows.start;
                sums.make(&run.taps[index], width, inner.len(), row..row + rows.len(), here, stride);
            }
        }
        // The usual case: every frame covers all columns, and the sides are empty.
        if run.inner.iter().all(|inner| inner == columns) {
            return;
        }
        // At the sides the number of frames differs from column to column.
        for (row, v) in rows.clone().enumerate() {
            let mixed = |index: usize| &mixed[(index * rows.len() + row) * mixed_stride..][..wide.len()];
            let source = |(index, &frame): (usize, &usize)| match run.mixes {
                true => Source { frame, pixels: mixed(index), left: wide.start },
                false => Source { frame, pixels: frames[frame].row(upper(frame, v)), left: 0 },
            };
            let sources: Vec<Source<'_>> = covering.iter().enumerate().map(source).collect();
            for (slope, inner) in group.clone().zip(&run.inner) {
                let out = &mut outs[slope][first + row * stride..][..columns.len()];
                for side in [columns.start..inner.start, inner.end..columns.end] {
                    if !side.is_empty() {
                        let out = &mut out[side.start - columns.start..side.end - columns.start];
                        side_columns(frames, slopes[slope], &sources, v, &side, counts, out);
                    }
                }
            }
        }
    }
}

/// Rows `(1 − part)·upper + part·lower` of neighbouring rows of `from`, `width` apart: `columns` values each to rows of
/// `out`. Two terms are too few for [`WeightedRows`], whose setup would dominate.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn mix(from: &[f32], width: usize, part: f32, columns: usize, out: &mut [f32], stride: usize) {
    for (row, out) in out.chunks_exact_mut(stride).enumerate() {
        let (out, upper) = (&mut out[..columns], &from[row * width..][..columns]);
        // Without a part the row below is not needed, and may not exist.
        if part == 0.0 {
            out.copy_from_slice(upper);
            continue;
        }
        let lower = &from[(row + 1) * width..][..columns];
        for ((out, upper), lower) in out.iter_mut().zip(upper).zip(lower) {
            *out = part.mul_add(*lower, (1.0 - part) * upper);
        }
    }
}

/// Computes the columns `side` of row `v`, not covered by all `sources`.
fn side_columns(
    frames: &[&Plane],
    offsets: &[FrameOffset],
    sources: &[Source<'_>],
    v: usize,
    side: &Range<usize>,
    counts: &mut Vec<f32>,
    out: &mut [f32],
) {
    let width = frames[0].width();
    counts.clear();
    counts.resize(side.len(), 0.0);
    out.fill(0.0);
    for source in sources {
        let offset = &offsets[source.frame];
        let covered = offset.covers_columns(width);
        let reads = FrameOffset::covered(offset.whole_u, offset.part_u, 0, width);
        let (start, end) = (covered.start.max(side.start), covered.end.min(side.end));
        // Columns left of the frame, copies of its first column, precede the columns read.
        let first_read = reads.start.clamp(start, end.max(start));
        for u in start..first_read.min(end) {
            out[u - side.start] += source.pixels[0];
            counts[u - side.start] += 1.0;
        }
        let range = first_read..end.min(reads.end);
        if range.is_empty() {
            continue;
        }
        let x = (range.start as i64 + offset.whole_u) as usize - source.left;
        let here = range.start - side.start..range.end - side.start;
        let left = &source.pixels[x..x + range.len()];
        if offset.part_u > 0.0 {
            let right = &source.pixels[x + 1..x + 1 + range.len()];
            for ((out, a), b) in out[here.clone()].iter_mut().zip(left).zip(right) {
                *out += (1.0 - offset.part_u) * a + offset.part_u * b;
            }
        } else {
            out[here.clone()].iter_mut().zip(left).for_each(|(out, a)| *out += a);
        }
        counts[here].iter_mut().for_each(|count| *count += 1.0);
    }
    for ((out, count), u) in out.iter_mut().zip(counts).zip(side.clone()) {
        *out = if *count > 0.0 {
            *out / *count
        } else {
            // No frame covers the pixel: the clamped mean keeps the image continuous.
            let sum: f32 = frames.iter().zip(offsets).map(|(frame, offset)| sample_clamped(frame, offset, u, v)).sum();
            sum / frames.len() as f32
        };
    }
}

/// Pixels of one frame in a sum, from the first one that is read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tap<'a> {
    /// Pixels; rows as far apart as in the image.
    pub pixels: &'a [f32],
    /// Weights of a pixel at its own place and one pixel to the left.
    pub weights: [f32; 2],
}

impl<'a> Tap<'a> {
    /// `pixels` read a fraction `part_u` of a column to the right, with the weight `weight`.
    pub fn new(pixels: &'a [f32], weight: f32, part_u: f32) -> Self {
        Self { pixels, weights: [weight * (1.0 - part_u), weight * part_u] }
    }
}

/// Positions between columns at which the taps of a sum are read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Between {
    Never,
    /// One fraction for all frames, so that pixels are summed once; the weights of the taps.
    Alike([f32; 2]),
    Apart,
}

impl Between {
    fn of(taps: &[Tap<'_>]) -> Self {
        if taps.iter().all(|tap| tap.weights[1] == 0.0) {
            return Self::Never;
        }
        let weights = taps[0].weights;
        if taps.iter().all(|tap| tap.weights == weights) { Self::Alike(weights) } else { Self::Apart }
    }
}

/// Buffers for a row of both sums, and the processor's kind; reused from row to row.
#[derive(Debug, Default)]
pub(crate) struct WeightedRows {
    arch: Arch,
    sums: [Aligned; 2],
}

impl WeightedRows {
    /// Writes `rows` of the sum of `taps`, `columns` values each, to `out`, `stride` apart. Row 0 is the first of the
    /// taps' pixels, whose rows lie `width` apart and hold one pixel more than `columns`.
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
        here.grow(columns + WIDEST_VECTOR);
        shifted.grow(columns + WIDEST_VECTOR);
        let between = Between::of(taps);
        // Shorter than a vector; same operations in the same order, so the bits are those of long rows.
        if columns < WIDEST_VECTOR {
            for (out, v) in out.chunks_mut(stride).zip(rows) {
                short_row(taps, v * width, between, &mut out[..columns]);
            }
            return;
        }
        self.arch.dispatch(RowsJob { taps, width, columns, rows, between, here, shifted, out, stride });
    }
}

fn short_row(taps: &[Tap<'_>], row: usize, between: Between, out: &mut [f32]) {
    let plain = |i: usize| taps.iter().fold(0.0f32, |sum, tap| sum + tap.pixels[row + i]);
    let sum = |i: usize, which: usize| {
        taps.iter().fold(0.0f32, |sum, tap| tap.weights[which].mul_add(tap.pixels[row + i], sum))
    };
    for (i, out) in out.iter_mut().enumerate() {
        *out = match between {
            Between::Never => sum(i, 0),
            Between::Alike([here, shifted]) => shifted.mul_add(plain(i + 1), here * plain(i)),
            Between::Apart => sum(i, 0) + sum(i + 1, 1),
        };
    }
}

struct RowsJob<'a> {
    taps: &'a [Tap<'a>],
    width: usize,
    /// At least [`WIDEST_VECTOR`].
    columns: usize,
    rows: std::ops::Range<usize>,
    between: Between,
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
            match self.between {
                Between::Apart => {
                    // The shifted sum needs one value more.
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
                }
                Between::Alike(weights) => {
                    in_vectors!(S, self.columns + 1, |V, places| {
                        let sums = one_sum::<S, V, false>(simd, self.taps, row, places);
                        for i in 0..V {
                            store::<S>(self.here, places[i], sums[i]);
                        }
                    });
                    let weights = weights.map(|weight| simd.splat_f32s(weight));
                    in_vectors!(S, self.columns, |V, places| {
                        for at in places {
                            let first = simd.mul_f32s(weights[0], load::<S>(self.here, at));
                            let sum = simd.mul_add_f32s(weights[1], load::<S>(self.here, at + 1), first);
                            store::<S>(out, at, sum);
                        }
                    });
                }
                // Whole-pixel slopes need neither a second sum nor fractions.
                Between::Never => {
                    in_vectors!(S, self.columns, |V, places| {
                        let sums = one_sum::<S, V, true>(simd, self.taps, row, places);
                        for i in 0..V {
                            store::<S>(out, places[i], sums[i]);
                        }
                    });
                }
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
        // Pixels are loaded once for both sums; the second is shifted by a column afterwards.
        for i in 0..V {
            let pixels = load::<S>(pixels, places[i]);
            sums[0][i] = simd.mul_add_f32s(weights[0], pixels, sums[0][i]);
            sums[1][i] = simd.mul_add_f32s(weights[1], pixels, sums[1][i]);
        }
    }
    sums
}

#[inline(always)]
fn one_sum<S: Simd, const V: usize, const WEIGHTED: bool>(
    simd: S,
    taps: &[Tap<'_>],
    row: usize,
    places: [usize; V],
) -> [S::f32s; V] {
    let mut sums = [simd.splat_f32s(0.0); V];
    for tap in taps {
        let weight = simd.splat_f32s(if WEIGHTED { tap.weights[0] } else { 1.0 });
        let pixels = &tap.pixels[row..];
        for i in 0..V {
            sums[i] = simd.mul_add_f32s(weight, load::<S>(pixels, places[i]), sums[i]);
        }
    }
    sums
}

pub(crate) fn any_masked(frames: &[&Plane]) -> bool {
    frames.iter().any(|frame| frame.mask().is_some())
}

/// Bilinear sample of `frame` for pixel (u, v); the nearest pixel beyond the frame.
pub(crate) fn sample_clamped(frame: &Plane, offset: &FrameOffset, u: usize, v: usize) -> f32 {
    let (width, height) = frame.size();
    let at = |du: i64, dv: i64| {
        let x = (u as i64 + offset.whole_u + du).clamp(0, width as i64 - 1);
        let y = (v as i64 + offset.whole_v + dv).clamp(0, height as i64 - 1);
        frame.data()[y as usize * width + x as usize]
    };
    let upper = (1.0 - offset.part_u) * at(0, 0) + offset.part_u * at(1, 0);
    let lower = (1.0 - offset.part_u) * at(0, 1) + offset.part_u * at(1, 1);
    (1.0 - offset.part_v) * upper + offset.part_v * lower
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
                    short_row(&taps, (v + 1) * 133, Between::of(&taps), &mut expected);
                    assert_eq!(row[..columns], expected, "{parts:?} {columns}");
                    // No other values are written.
                    assert!(row[columns..].iter().all(|x| x.is_nan()), "{parts:?} {columns}");
                }
            }
        }
    }
}
