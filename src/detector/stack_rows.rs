//! Rows of motion-stack images, for several slopes at once.
//!
//! The slopes of a group read the same rows of the same frames, a few columns apart; made together, each row comes from memory once. Slopes
//! that also agree in their vertical part share the mixing of two rows into one, so that each needs at most two products per frame and pixel.
//!
//! Inside, where every frame of a row covers the column, sums stay in registers. At the sides, where fewer and fewer frames do, frames are added one after the
//! other and divided by their number.

use super::motion::{FrameOffset, sample_clamped, weighted_sum};
use crate::plane::Plane;
use std::ops::Range;

/// Makes rows of the motion-stack images of some frames at some slopes.
#[derive(Debug)]
pub struct RowStacker<'a> {
    frames: &'a [&'a Plane],
    /// For each slope, where its frames are read.
    slopes: Vec<&'a [FrameOffset]>,
    /// Runs of slopes that read the same rows in the same proportions.
    groups: Vec<Range<usize>>,
    mixed: Vec<f32>,
    counts: Vec<f32>,
}

/// One frame's part of a row: its pixels from column `left` on, and where a slope's pixel finds its own.
struct Source<'s> {
    frame: usize,
    pixels: &'s [f32],
    left: usize,
}

impl<'a> RowStacker<'a> {
    /// For `frames` of one size in time order and, for each slope, their [`super::motion::frame_offsets`].
    pub fn new(frames: &'a [&'a Plane], slopes: Vec<&'a [FrameOffset]>) -> Self {
        let vertical = |slope: &[FrameOffset]| -> Vec<(i64, f32, i64)> {
            slope.iter().map(|o| (o.whole_v, o.part_v, o.before_v)).collect()
        };
        let mut groups: Vec<Range<usize>> = Vec::new();
        for index in 0..slopes.len() {
            match groups.last_mut() {
                Some(group) if vertical(slopes[group.start]) == vertical(slopes[index]) => group.end = index + 1,
                _ => groups.push(index..index + 1),
            }
        }
        Self { frames, slopes, groups, mixed: Vec::new(), counts: Vec::new() }
    }

    /// Row `v`, columns `columns`, of each slope's motion-stack image into its `outs`, one value a column.
    pub fn row(&mut self, v: usize, columns: Range<usize>, outs: &mut [&mut [f32]]) {
        for index in 0..self.groups.len() {
            self.group_row(index, v, &columns, outs);
        }
    }

    fn group_row(&mut self, group: usize, v: usize, columns: &Range<usize>, outs: &mut [&mut [f32]]) {
        let group = self.groups[group].clone();
        let (width, height) = self.frames[0].size();
        let first = self.slopes[group.start];
        let covering: Vec<usize> = (0..self.frames.len()).filter(|&t| first[t].covers_row(v, height)).collect();
        // The columns of the frames that any slope of the group reads.
        let shifts = || group.clone().flat_map(|s| self.slopes[s]).map(|o| o.whole_u);
        let start = (columns.start as i64 + shifts().min().unwrap_or(0)).clamp(0, width as i64 - 1) as usize;
        let end = (columns.end as i64 + shifts().max().unwrap_or(0) + 1).clamp(start as i64 + 1, width as i64) as usize;
        let wide = start..end;
        self.mixed.resize(covering.len() * wide.len(), 0.0);
        let mut sources: Vec<Source<'_>> = Vec::with_capacity(covering.len());
        for (&frame, mixed) in covering.iter().zip(self.mixed.chunks_mut(wide.len())) {
            let offset = &first[frame];
            let y = (v as i64 + offset.whole_v).max(0) as usize;
            let pixels = self.frames[frame];
            if offset.part_v > 0.0 {
                let upper = (&pixels.row(y)[wide.clone()], 1.0 - offset.part_v);
                let lower = (&pixels.row(y + 1)[wide.clone()], offset.part_v);
                weighted_sum(&[upper, lower], 1.0, mixed);
                sources.push(Source { frame, pixels: mixed, left: wide.start });
            } else {
                sources.push(Source { frame, pixels: pixels.row(y), left: 0 });
            }
        }
        let mut taps: Vec<(&[f32], f32)> = Vec::with_capacity(2 * sources.len());
        for slope in group {
            let (offsets, out) = (self.slopes[slope], &mut *outs[slope]);
            let mut inner = columns.clone();
            for source in &sources {
                let reads = offsets[source.frame].reads_columns(width);
                inner = inner.start.max(reads.start)..inner.end.min(reads.end);
            }
            if sources.is_empty() || inner.is_empty() {
                inner = columns.start..columns.start;
            } else {
                taps.clear();
                for source in &sources {
                    let offset = &offsets[source.frame];
                    let x = (inner.start as i64 + offset.whole_u) as usize - source.left;
                    taps.push((&source.pixels[x..x + inner.len()], 1.0 - offset.part_u));
                    if offset.part_u > 0.0 {
                        taps.push((&source.pixels[x + 1..x + 1 + inner.len()], offset.part_u));
                    }
                }
                let here = inner.start - columns.start..inner.end - columns.start;
                weighted_sum(&taps, 1.0 / sources.len() as f32, &mut out[here]);
            }
            for side in [columns.start..inner.start, inner.end..columns.end] {
                if !side.is_empty() {
                    let out = &mut out[side.start - columns.start..side.end - columns.start];
                    side_columns(self.frames, offsets, &sources, v, &side, &mut self.counts, out);
                }
            }
        }
    }
}

/// The columns `side` of row `v`, where not all `sources` reach.
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
        // Columns that count as the frame's first one come before those that it reads.
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
