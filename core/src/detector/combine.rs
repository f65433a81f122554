//! Ways to combine the shifted frames at a slope: the mean, which the detector uses, and others, which show what is in
//! some frames only.
//!
//! The frames' rows are read at their offsets into a buffer of one row for each frame. A network of comparisons sorts
//! the buffer column by column; every comparison is a loop over a row, so that it runs in vectors. Where not all frames
//! cover a column, its few values are sorted one by one. The mean is that of [`motion_stack`], to the bit.

use super::stack::{frame_offsets, motion_stack};
use crate::detector::params::Interpolation;
use crate::detector::params::slope_grid::Slope;
use crate::kernel::stack::{FrameOffset, sample_clamped};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A way to combine the values that the frames have at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Combine {
    /// Mean.
    #[default]
    Mean,
    /// Median; of an even number of values the mean of the two in the middle.
    Median,
    /// Mean of the values within [`CLIP_SIGMAS`] standard deviations of the median. The standard deviation is that of a
    /// normal distribution with the same quartiles.
    ClippedMean,
    /// Largest value.
    Max,
    /// Smallest value.
    Min,
    /// Standard deviation around the mean; 0 for one value.
    Deviation,
    /// Mean minus median: above 0 where some frames are brighter than most.
    MeanMinusMedian,
}

/// Standard deviations from the median within which values count for the clipped mean.
pub const CLIP_SIGMAS: f32 = 2.5;
/// Columns whose sums are kept at hand while the rows are added.
const BLOCK: usize = 64;
/// Distance of the quartiles of a normal distribution, in standard deviations.
const QUARTILES: f32 = 1.348_98;

impl Combine {
    /// All ways.
    pub const ALL: [Self; 7] =
        [Self::Mean, Self::Median, Self::ClippedMean, Self::Max, Self::Min, Self::Deviation, Self::MeanMinusMedian];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Median => "median",
            Self::ClippedMean => "clipped-mean",
            Self::Max => "max",
            Self::Min => "min",
            Self::Deviation => "deviation",
            Self::MeanMinusMedian => "mean-minus-median",
        }
    }

    /// The combination of sorted values; at least one.
    fn of_sorted(self, sorted: &[f32]) -> f32 {
        let n = sorted.len();
        let mean = || sorted.iter().sum::<f32>() / n as f32;
        let median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
        match self {
            Self::Mean => mean(),
            Self::Median => median,
            Self::ClippedMean => {
                let limit = clip_limit(sorted[n / 4], sorted[n - 1 - n / 4]);
                let near = sorted.iter().filter(|x| (**x - median).abs() <= limit);
                let (sum, count) = near.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
                if count > 0.0 { sum / count } else { median }
            }
            Self::Max => sorted[n - 1],
            Self::Min => sorted[0],
            Self::Deviation => {
                let mean = mean();
                (sorted.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / (n.max(2) - 1) as f32).sqrt()
            }
            Self::MeanMinusMedian => mean() - median,
        }
    }
}

/// Largest distance from the median of values that count for the clipped mean, from the quartiles.
fn clip_limit(low: f32, high: f32) -> f32 {
    CLIP_SIGMAS / QUARTILES * (high - low)
}

/// Comparisons that sort `n` values (K. E. Batcher's odd-even merge sort, for any number).
fn sorting_network(n: usize) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    let mut p = 1;
    while p < n {
        let mut k = p;
        while k >= 1 {
            for j in (k % p..n.saturating_sub(k)).step_by(2 * k) {
                for i in 0..k.min(n - j - k) {
                    if (i + j) / (2 * p) == (i + j + k) / (2 * p) {
                        pairs.push((i + j, i + j + k));
                    }
                }
            }
            k /= 2;
        }
        p *= 2;
    }
    pairs
}

/// Combines `frames` (one size, in time order) at `slope`: of each pixel x the values F_t(x + (t − t0)·λ) of the frames
/// that cover it, as [`motion_stack`] takes their mean. Size and unit are those of the frames. Rows in parallel.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn combined_stack(
    frames: &[&Plane],
    slope: Slope,
    interpolation: Interpolation,
    combine: Combine,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    if combine == Combine::Mean {
        return motion_stack(frames, slope, interpolation, monitor);
    }
    let (width, height) = frames[0].size();
    let offsets = frame_offsets(frames.len(), slope, interpolation);
    let mut out = Plane::zeros(width, height);
    let network = sorting_network(frames.len());
    out.data_mut().par_chunks_mut(width.max(1)).enumerate().try_for_each_init(
        || (vec![0.0f32; frames.len() * width], Vec::with_capacity(frames.len())),
        |(rows, values), (v, out)| {
            monitor.check()?;
            combined_row((frames, &offsets), (v, &network), combine, (rows, values), out);
            Ok(())
        },
    )?;
    Ok(out)
}

/// Combines row `v`; `rows` has room for a row of each frame, `values` for a value of each.
fn combined_row(
    (frames, offsets): (&[&Plane], &[FrameOffset]),
    (v, network): (usize, &[(usize, usize)]),
    combine: Combine,
    (rows, values): (&mut [f32], &mut Vec<f32>),
    out: &mut [f32],
) {
    let (width, height) = frames[0].size();
    // Columns that all frames cover; none where a frame does not cover the row.
    let all_cover = offsets.iter().all(|offset| offset.covers_row(v, height));
    let inner = offsets
        .iter()
        .map(|offset| offset.covers_columns(width))
        .fold(0..width, |a, b| a.start.max(b.start)..a.end.min(b.end));
    let inner = if all_cover && inner.start < inner.end { inner } else { 0..0 };
    if !inner.is_empty() {
        let length = inner.len();
        for (t, (frame, offset)) in frames.iter().zip(offsets).enumerate() {
            shifted_row(frame, offset, v, inner.start, &mut rows[t * length..(t + 1) * length]);
        }
        let rows = &mut rows[..frames.len() * length];
        combine_rows(rows, network, combine, &mut out[inner.clone()]);
    }
    for u in (0..inner.start).chain(inner.end..width) {
        let covers = |offset: &FrameOffset| offset.covers(u, v, (width, height));
        values.clear();
        let covering = frames.iter().zip(offsets).filter(|(_, offset)| covers(offset));
        values.extend(covering.map(|(frame, offset)| sample_clamped(frame, offset, u, v)));
        if values.is_empty() {
            values.extend(frames.iter().zip(offsets).map(|(frame, offset)| sample_clamped(frame, offset, u, v)));
        }
        values.sort_unstable_by(f32::total_cmp);
        out[u] = combine.of_sorted(values);
    }
}

/// Reads the row `v` of the image from column `first` on in a frame at its offset.
fn shifted_row(frame: &Plane, offset: &FrameOffset, v: usize, first: usize, out: &mut [f32]) {
    let (width, height) = frame.size();
    let row = |dv: i64| frame.row((v as i64 + offset.whole_v + dv).clamp(0, height as i64 - 1) as usize);
    let start = first as i64 + offset.whole_u;
    let fits = start >= 0 && start as usize + out.len() < width;
    if !fits {
        for (i, value) in out.iter_mut().enumerate() {
            *value = sample_clamped(frame, offset, first + i, v);
        }
        return;
    }
    let range = start as usize..start as usize + out.len() + 1;
    mixed_row(&row(0)[range.clone()], &row(1)[range], (offset.part_u, offset.part_v), out);
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn mixed_row(upper: &[f32], lower: &[f32], (part_u, part_v): (f32, f32), out: &mut [f32]) {
    let n = out.len();
    let (upper, lower) = (&upper[..n + 1], &lower[..n + 1]);
    for i in 0..n {
        let above = (1.0 - part_u) * upper[i] + part_u * upper[i + 1];
        let below = (1.0 - part_u) * lower[i] + part_u * lower[i + 1];
        out[i] = (1.0 - part_v) * above + part_v * below;
    }
}

/// Combines rows of equal length, which lie behind one another, into `out`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn combine_rows(rows: &mut [f32], network: &[(usize, usize)], combine: Combine, out: &mut [f32]) {
    let length = out.len();
    let n = rows.len() / length;
    let needs_order = matches!(combine, Combine::Median | Combine::ClippedMean | Combine::MeanMinusMedian);
    if needs_order {
        for &(low, high) in network {
            let (before, after) = rows.split_at_mut(high * length);
            let (a, b) = (&mut before[low * length..(low + 1) * length], &mut after[..length]);
            for i in 0..length {
                let (x, y) = (a[i], b[i]);
                a[i] = if x < y { x } else { y };
                b[i] = if x < y { y } else { x };
            }
        }
    }
    let row = |t: usize| &rows[t * length..(t + 1) * length];
    let (lower, upper) = (row((n - 1) / 2), row(n / 2));
    match combine {
        Combine::Median => {
            for i in 0..length {
                out[i] = 0.5 * (lower[i] + upper[i]);
            }
        }
        Combine::Max | Combine::Min => {
            let is_max = combine == Combine::Max;
            out.copy_from_slice(row(0));
            for t in 1..n {
                let row = row(t);
                for i in 0..length {
                    out[i] = if (row[i] > out[i]) == is_max { row[i] } else { out[i] };
                }
            }
        }
        Combine::ClippedMean => {
            let (low, high) = (row(n / 4), row(n - 1 - n / 4));
            for first in (0..length).step_by(BLOCK) {
                let (mut sum, mut count) = ([0.0f32; BLOCK], [0.0f32; BLOCK]);
                let columns = first..length.min(first + BLOCK);
                for t in 0..n {
                    let values = &row(t)[columns.clone()];
                    let middle = lower[columns.clone()].iter().zip(&upper[columns.clone()]);
                    let ends = low[columns.clone()].iter().zip(&high[columns.clone()]);
                    let sums = sum.iter_mut().zip(&mut count);
                    for ((&x, (a, b)), ((low, high), (sum, count))) in values.iter().zip(middle).zip(ends.zip(sums)) {
                        let counts = if (x - 0.5 * (a + b)).abs() <= clip_limit(*low, *high) { 1.0 } else { 0.0 };
                        *sum += counts * x;
                        *count += counts;
                    }
                }
                for (i, out) in out[columns].iter_mut().enumerate() {
                    let median = 0.5 * (lower[first + i] + upper[first + i]);
                    *out = if count[i] > 0.0 { sum[i] / count[i] } else { median };
                }
            }
        }
        Combine::Mean | Combine::MeanMinusMedian | Combine::Deviation => {
            out.fill(0.0);
            for t in 0..n {
                let row = row(t);
                for i in 0..length {
                    out[i] += row[i];
                }
            }
            out.iter_mut().for_each(|x| *x /= n as f32);
            if combine == Combine::MeanMinusMedian {
                for i in 0..length {
                    out[i] -= 0.5 * (lower[i] + upper[i]);
                }
            } else if combine == Combine::Deviation {
                for first in (0..length).step_by(BLOCK) {
                    let mut squares = [0.0f32; BLOCK];
                    let columns = first..length.min(first + BLOCK);
                    for t in 0..n {
                        let values = row(t)[columns.clone()].iter().zip(&out[columns.clone()]);
                        for ((x, mean), sum) in values.zip(&mut squares) {
                            *sum += (x - mean) * (x - mean);
                        }
                    }
                    for (out, sum) in out[columns].iter_mut().zip(&squares) {
                        *out = (sum / (n.max(2) - 1) as f32).sqrt();
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_network_sorts_any_number() {
        for n in 1..40 {
            let network = sorting_network(n);
            // A network that sorts all sequences of zeros and ones sorts everything; here a few hundred of them.
            for seed in 0..400u64 {
                let mut values: Vec<u64> = (0..n as u64)
                    .map(|i| ((seed.wrapping_mul(0x9e37_79b9) >> (i % 31)) & 1) ^ (i * seed % 3 / 2))
                    .collect();
                for &(a, b) in &network {
                    if values[a] > values[b] {
                        values.swap(a, b);
                    }
                }
                assert!(values.is_sorted(), "{n}: {values:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn every_way_is_its_definition(
            n in 1usize..9, u in -4.0f32..4.0, v in -4.0f32..4.0, whole in any::<bool>(), how in 1usize..7,
        ) {
            let slope = if whole { Slope::new(u.round(), v.round()) } else { Slope::new(u, v) };
            let frames: Vec<Plane> =
                (0..n).map(|t| Plane::from_fn(37, 23, |u, v| ((u * 31 + v * 17 + t * 41) % 29) as f32 / 29.0)).collect();
            let frames: Vec<&Plane> = frames.iter().collect();
            let combine = Combine::ALL[how];
            let fast = combined_stack(&frames, slope, Interpolation::Linear, combine, &Monitor::default()).expect("done");
            let offsets = frame_offsets(n, slope, Interpolation::Linear);
            for row in 0..23 {
                for column in 0..37 {
                    let of = |all: bool| -> Vec<f32> {
                        let pairs = frames.iter().zip(&offsets);
                        pairs.filter(|(_, o)| all || o.covers(column, row, (37, 23)))
                            .map(|(f, o)| sample_clamped(f, o, column, row)).collect()
                    };
                    let mut values = of(false);
                    if values.is_empty() {
                        values = of(true);
                    }
                    values.sort_unstable_by(f32::total_cmp);
                    let slow = combine.of_sorted(&values);
                    // A value at the limit of the clipped mean may be rounded to either side.
                    let tolerance = if combine == Combine::ClippedMean { 0.2 } else { 1e-5 };
                    prop_assert!((fast.at(column, row) - slow).abs() < tolerance, "{combine:?} {column} {row}");
                }
            }
        }
    }

    #[test]
    fn what_is_in_one_frame_only_stands_out_from_mean_minus_median() {
        let frame =
            |t: usize| Plane::from_fn(40, 30, |u, v| 0.2 + if t == 3 && (u, v) == (20, 15) { 0.7 } else { 0.0 });
        let frames: Vec<Plane> = (0..8).map(frame).collect();
        let frames: Vec<&Plane> = frames.iter().collect();
        let at = |combine| {
            combined_stack(&frames, Slope::default(), Interpolation::Linear, combine, &Monitor::default())
                .expect("not cancelled")
                .at(20, 15)
        };
        let near = |value: f32, should: f32| assert!((value - should).abs() < 1e-5, "{value} {should}");
        near(at(Combine::Median), 0.2);
        near(at(Combine::ClippedMean), 0.2);
        near(at(Combine::Max), 0.9);
        near(at(Combine::Min), 0.2);
        near(at(Combine::MeanMinusMedian), 0.7 / 8.0);
        near(at(Combine::Deviation), 0.7 / 8f32.sqrt());
    }
}
