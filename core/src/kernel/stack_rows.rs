//! Rows of motion-stack images, for several slopes at once.
//!
//! The slopes of a group read the same rows of the same frames, a few columns apart; made together, each row comes from
//! memory once. Slopes that also agree in their vertical part share the mixing of two rows into one.
//!
//! Inside, where every frame of a row covers the column and the next one, rows are [weighted
//! sums](crate::kernel::weighted_rows) of the frames' rows; the pixels that belong together and their weights are the
//! same for all rows that the same frames cover, so they are computed once. At the sides, where fewer and fewer frames
//! cover the columns, frames are added one after the other and divided by their number.

use super::offset::FrameOffset;
use super::weighted_sum::{sample_clamped, weighted_sum};
use crate::kernel::weighted_rows::{Tap, WeightedRows};
use crate::plane::Plane;
use std::ops::Range;

/// Makes rows of the motion-stack images of some frames at some slopes.
#[derive(Debug)]
pub struct RowStacker<'a> {
    frames: &'a [&'a Plane],
    /// Offsets of the frames for each slope.
    slopes: Vec<&'a [FrameOffset]>,
    groups: Vec<Group<'a>>,
    mixed: Vec<f32>,
    counts: Vec<f32>,
    sums: WeightedRows,
}

/// Slopes that read the same rows in the same proportions.
#[derive(Debug)]
struct Group<'a> {
    slopes: Range<usize>,
    run: Run<'a>,
}

/// Data shared by the rows that the same frames cover.
#[derive(Debug, Default)]
struct Run<'a> {
    rows: Range<usize>,
    columns: Range<usize>,
    /// Indices of the frames that cover them.
    covering: Vec<usize>,
    /// The columns of the frames that any slope of the group reads.
    wide: Range<usize>,
    /// Whether any of the frames is read between its rows.
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
    /// The rows from `v` on, columns `columns`, of `frames` at `slopes`, which form a group.
    fn new(frames: &'a [&'a Plane], slopes: &[&'a [FrameOffset]], v: usize, columns: Range<usize>) -> Self {
        let (width, height) = frames[0].size();
        let first = slopes[0];
        let covering: Vec<usize> = (0..frames.len()).filter(|&t| first[t].covers_row(v, height)).collect();
        let changes = first.iter().map(|offset| offset.covers_rows(height)).flat_map(|rows| [rows.start, rows.end]);
        // Rows before the frame's first one that count as it are all copies of it.
        let reads = covering.iter().map(|&t| usize::try_from(-first[t].whole_v).unwrap_or(0));
        let end = changes.chain(reads).filter(|&change| change > v).min().unwrap_or(height);
        let shifts = || slopes.iter().flat_map(|slope| slope.iter()).map(|offset| offset.whole_u);
        let wide_start = (columns.start as i64 + shifts().min().unwrap_or(0)).clamp(0, width as i64 - 1);
        let wide_end = (columns.end as i64 + shifts().max().unwrap_or(0) + 1).clamp(wide_start + 1, width as i64);
        let inner: Vec<Range<usize>> = slopes
            .iter()
            .map(|offsets| {
                let reads = covering.iter().map(|&frame| offsets[frame].reads_next_columns(width));
                let inner = reads.fold(columns.clone(), |a, b| a.start.max(b.start)..a.end.min(b.end));
                if covering.is_empty() || inner.is_empty() { columns.start..columns.start } else { inner }
            })
            .collect();
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
    /// Stacker for `frames` of one size in time order and, for each slope, their
    /// [`crate::detector::stack::offsets::frame_offsets`].
    pub fn new(frames: &'a [&'a Plane], slopes: Vec<&'a [FrameOffset]>) -> Self {
        let vertical = |slope: &[FrameOffset]| -> Vec<(i64, f32, i64)> {
            slope.iter().map(|o| (o.whole_v, o.part_v, o.before_v)).collect()
        };
        let mut groups: Vec<Group<'_>> = Vec::new();
        for index in 0..slopes.len() {
            match groups.last_mut() {
                Some(Group { slopes: group, .. }) if vertical(slopes[group.start]) == vertical(slopes[index]) => {
                    group.end = index + 1;
                }
                _ => groups.push(Group { slopes: index..index + 1, run: Run::default() }),
            }
        }
        let (mixed, counts, sums) = (Vec::new(), Vec::new(), WeightedRows::default());
        Self { frames, slopes, groups, mixed, counts, sums }
    }

    /// Writes row `v`, columns `columns`, of each slope's motion-stack image to its slice of `outs`, one value for each
    /// column.
    pub fn row(&mut self, v: usize, columns: Range<usize>, outs: &mut [&mut [f32]]) {
        for index in 0..self.groups.len() {
            let Group { slopes, run } = &mut self.groups[index];
            if !run.rows.contains(&v) || run.columns != columns {
                *run = Run::new(self.frames, &self.slopes[slopes.clone()], v, columns.clone());
            }
            self.group_row(index, v, outs);
        }
    }

    fn group_row(&mut self, group: usize, v: usize, outs: &mut [&mut [f32]]) {
        let Self { frames, slopes, groups, mixed, counts, sums } = self;
        let Group { slopes: group, run } = &groups[group];
        let width = frames[0].width();
        let columns = &run.columns;
        let sided = run.inner.iter().any(|inner| inner != columns);
        let sources = if run.mixes || sided { sources(frames, slopes[group.start], run, v, mixed) } else { Vec::new() };
        let mut taps: Vec<Tap<'_>> = Vec::with_capacity(if run.mixes { sources.len() } else { 0 });
        for (index, slope) in group.clone().enumerate() {
            let (offsets, out, inner) = (slopes[slope], &mut *outs[slope], &run.inner[index]);
            let here = &mut out[inner.start - columns.start..inner.end - columns.start];
            if run.mixes && !inner.is_empty() {
                taps.clear();
                taps.extend(sources.iter().map(|source| {
                    let offset = &offsets[source.frame];
                    let x = (inner.start as i64 + offset.whole_u) as usize - source.left;
                    Tap::new(&source.pixels[x..], 1.0 / sources.len() as f32, offset.part_u)
                }));
                sums.make(&taps, 0, inner.len(), 0..1, here, inner.len());
            } else if !inner.is_empty() {
                let row = v - run.rows.start;
                sums.make(&run.taps[index], width, inner.len(), row..row + 1, here, inner.len());
            }
            for side in [columns.start..inner.start, inner.end..columns.end] {
                if !side.is_empty() {
                    let out = &mut out[side.start - columns.start..side.end - columns.start];
                    side_columns(frames, offsets, &sources, v, &side, counts, out);
                }
            }
        }
    }
}

/// The sources of row `v` of `run` from the frames that cover it, at the vertical parts of `offsets`; two rows that are
/// read together are mixed into one in `mixed`.
fn sources<'s>(
    frames: &[&'s Plane],
    offsets: &[FrameOffset],
    run: &Run<'_>,
    v: usize,
    mixed: &'s mut Vec<f32>,
) -> Vec<Source<'s>> {
    let wide = &run.wide;
    mixed.resize(run.covering.len() * wide.len(), 0.0);
    let source = |(&frame, mixed): (&usize, &'s mut [f32])| {
        let (offset, pixels) = (&offsets[frame], frames[frame]);
        let y = (v as i64 + offset.whole_v).max(0) as usize;
        if offset.part_v == 0.0 {
            return Source { frame, pixels: pixels.row(y), left: 0 };
        }
        let upper = (&pixels.row(y)[wide.clone()], 1.0 - offset.part_v);
        let lower = (&pixels.row(y + 1)[wide.clone()], offset.part_v);
        weighted_sum(&[upper, lower], 1.0, mixed);
        Source { frame, pixels: mixed, left: wide.start }
    };
    run.covering.iter().zip(mixed.chunks_mut(wide.len())).map(source).collect()
}

/// Computes the columns `side` of row `v`, which not all `sources` cover.
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
        let reads = offset.reads_columns(width);
        let (start, end) = (covered.start.max(side.start), covered.end.min(side.end));
        // Columns that count as the frame's first one precede those that it reads.
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
            let sum: f32 = frames.iter().zip(offsets).map(|(frame, offset)| sample_clamped(frame, offset, u, v)).sum();
            sum / frames.len() as f32
        };
    }
}
