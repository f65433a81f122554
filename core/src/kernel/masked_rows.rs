//! Rows of a motion-stack image where masks hide a part of the frames: the mean of the samples that are seen.
//!
//! Where no frame sees a place, the filled values are averaged, since a hidden sample keeps a small weight.

use crate::plane::mask::{HIDDEN_WEIGHT, join};
use crate::{kernel::offset::FrameOffset, plane::Plane};
use multiversion::multiversion;
use std::ops::Range;

/// Sums of weighted samples and of their weights, by column; reused from row to row.
#[derive(Debug, Default)]
pub(super) struct MaskedRows {
    samples: Vec<f32>,
    weights: Vec<f32>,
    mixed: [Vec<f32>; 2],
}

impl MaskedRows {
    /// Writes row `v` of the mean of the seen samples to `out`, which holds `columns` of the mean of all samples.
    pub fn mend(&mut self, frames: &[&Plane], at: &[FrameOffset], v: usize, columns: &Range<usize>, out: &mut [f32]) {
        let (width, height) = frames[0].size();
        let covering = frames.iter().zip(at).filter(|(_, offset)| offset.covers_rows(height).contains(&v));
        let rows = |offset: &FrameOffset| {
            let upper = (v as i64 + offset.whole_v).max(0) as usize;
            upper..upper + 1 + usize::from(offset.part_v > 0.0)
        };
        let hidden = covering.clone().flat_map(|(frame, offset)| {
            // A sample is read a column before its own too where the frame is read between its columns.
            let before = offset.before_u + i64::from(offset.part_u > 0.0);
            let spans = rows(offset).flat_map(|y| frame.mask().map_or(&[][..], |mask| mask.spans(y)));
            spans.map(move |span| span.start as i64 - before - offset.whole_u..span.end as i64 - offset.whole_u)
        });
        // Only columns that read a hidden sample are made again: elsewhere the mean of all is right.
        let mut hidden: Vec<Range<i64>> = hidden.collect();
        hidden.sort_unstable_by_key(|range| range.start);
        let inside = |at: i64| at.clamp(columns.start as i64, columns.end as i64) as usize;
        for hidden in join(hidden) {
            let hidden = inside(hidden.start)..inside(hidden.end);
            for sums in [&mut self.samples, &mut self.weights] {
                sums.clear();
                sums.resize(hidden.len(), 0.0);
            }
            for (frame, offset) in covering.clone() {
                let covered = offset.covers_columns(width);
                let (start, end) = (covered.start.max(hidden.start), covered.end.min(hidden.end));
                if start >= end {
                    continue;
                }
                // Columns before the frame's first one that count as that column begin a column too far left.
                let left = start as i64 + offset.whole_u;
                let (skipped, left) = (usize::try_from(-left).unwrap_or(0), left.max(0) as usize);
                let read = left..(left + end - start + usize::from(offset.part_u > 0.0)).min(width);
                let lines = [rows(offset).start, rows(offset).end - 1];
                let values = lines.map(|y| &frame.row(y)[read.clone()]);
                let weights = lines.map(|y| frame.mask().map(|mask| &mask.weights().row(y)[read.clone()]));
                mix(values, weights, offset.part_v, &mut self.mixed);
                let [samples, weights] = &self.mixed;
                if skipped > 0 {
                    self.samples[start - hidden.start] += samples[0];
                    self.weights[start - hidden.start] += weights[0];
                }
                let here = start + skipped - hidden.start..end - hidden.start;
                add(samples, offset.part_u, &mut self.samples[here.clone()]);
                add(weights, offset.part_u, &mut self.weights[here]);
            }
            let out = &mut out[hidden.start - columns.start..hidden.end - columns.start];
            let sums = self.samples.iter().zip(&self.weights);
            for (out, (samples, weights)) in out.iter_mut().zip(sums) {
                if *weights > 0.0 {
                    *out = samples / weights;
                }
            }
        }
    }
}

/// Mixes two rows, `part` of the way to the second: their weighted samples, and their weights.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn mix(values: [&[f32]; 2], weights: [Option<&[f32]>; 2], part: f32, mixed: &mut [Vec<f32>; 2]) {
    let count = values[0].len();
    let [samples, sums] = mixed;
    for out in [&mut *samples, &mut *sums] {
        out.clear();
        out.resize(count, 0.0);
    }
    for ((values, weights), share) in values.into_iter().zip(weights).zip([1.0 - part, part]) {
        match weights {
            None => {
                samples.iter_mut().zip(values).for_each(|(sum, value)| *sum += share * value);
                sums.iter_mut().for_each(|sum| *sum += share);
            }
            Some(weights) => {
                for (((samples, sum), value), weight) in samples.iter_mut().zip(&mut *sums).zip(values).zip(weights) {
                    let weight = share * weight.max(HIDDEN_WEIGHT);
                    *samples += weight * value;
                    *sum += weight;
                }
            }
        }
    }
}

/// Adds `from`, read `part` of a column to the right, to `sums`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn add(from: &[f32], part: f32, sums: &mut [f32]) {
    if part == 0.0 {
        return sums.iter_mut().zip(from).for_each(|(sum, x)| *sum += x);
    }
    for ((sum, left), right) in sums.iter_mut().zip(from).zip(&from[1..]) {
        *sum += (1.0 - part) * left + part * right;
    }
}
