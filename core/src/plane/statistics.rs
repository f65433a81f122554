//! Statistics of the values of a plane or of a rectangle of it: range, mean, percentiles, histogram.
//!
//! Values that are not finite are counted but otherwise left out. All functions work in parallel over rows and take a
//! few milliseconds for a camera picture, so that a window can ask while the user drags.

pub use super::tile::Region;

use super::Plane;
use crate::monitor::{Cancelled, Monitor};
use rayon::prelude::*;

fn rows<'a>(plane: &'a Plane, region: &Region) -> impl IndexedParallelIterator<Item = &'a [f32]> {
    let Region { columns, rows } = region.within(plane);
    rows.into_par_iter().with_min_len(16).map(move |v| &plane.row(v)[columns.clone()])
}

/// Median of `values`, of an even number of them the upper of the middle two; `None` where there are none.
pub(crate) fn upper_median(mut values: Vec<f32>) -> Option<f32> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// Count, range and mean of the finite values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Number of finite values.
    pub count: usize,
    /// Number of values that are NaN or infinite.
    pub not_finite: usize,
    /// Smallest finite value; +∞ when there is none.
    pub min: f32,
    /// Largest finite value; −∞ when there is none.
    pub max: f32,
    /// Mean of the finite values; NaN when there is none.
    pub mean: f64,
}

impl Summary {
    /// Smallest and largest finite value; `None` when there is none.
    pub fn range(&self) -> Option<(f32, f32)> {
        (self.count > 0).then_some((self.min, self.max))
    }
}

/// Count, range and mean of the finite values of `region`. The same bits for any number of threads.
pub fn summary(plane: &Plane, region: &Region) -> Summary {
    // Sums of rows are added in order, so that the mean does not depend on the threads.
    let per_row: Vec<(usize, usize, f32, f32, f64)> = rows(plane, region)
        .map(|row| {
            row.iter().fold((0, 0, f32::INFINITY, f32::NEG_INFINITY, 0.0), |(n, bad, low, high, sum), &x| {
                if x.is_finite() {
                    (n + 1, bad, low.min(x), high.max(x), sum + f64::from(x))
                } else {
                    (n, bad + 1, low, high, sum)
                }
            })
        })
        .collect();
    let mut all = Summary { count: 0, not_finite: 0, min: f32::INFINITY, max: f32::NEG_INFINITY, mean: 0.0 };
    for (count, bad, low, high, sum) in per_row {
        all.count += count;
        all.not_finite += bad;
        all.min = all.min.min(low);
        all.max = all.max.max(high);
        all.mean += sum;
    }
    all.mean /= all.count as f64;
    all
}

/// Exact percentiles of the finite values of `region`, one for each of `percents` (0 … 100); `None` without any: values
/// of rank round(p/100·(n − 1)) among the n sorted ones. Found by counting the upper, then the lower half of an
/// order-preserving integer key: two passes over the data for each percentile.
pub fn percentiles(plane: &Plane, region: &Region, percents: &[f32]) -> Option<Vec<f32>> {
    percentiles_until(plane, region, percents, &Monitor::default()).ok().flatten()
}

/// Percentiles as by [`percentiles`], until `monitor` is cancelled: for work in the background.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn percentiles_until(
    plane: &Plane,
    region: &Region,
    percents: &[f32],
    monitor: &Monitor,
) -> Result<Option<Vec<f32>>, Cancelled> {
    let upper = count_keys(plane, region, |key| Some(key >> 16), monitor)?;
    let count: u64 = upper.iter().sum();
    if count == 0 {
        return Ok(None);
    }
    let find = |counts: &[u64], rank: u64| {
        let mut before = 0;
        for (i, &n) in counts.iter().enumerate() {
            if before + n > rank {
                return (i as u32, rank - before);
            }
            before += n;
        }
        unreachable!("a rank is smaller than the count")
    };
    // Lower halves are counted only among values with the found upper half: 65536 bins suffice twice.
    let percentile = |percent: &f32| {
        let fraction = f64::from(percent.clamp(0.0, 100.0)) / 100.0;
        let (high, rank) = find(&upper, (fraction * (count - 1) as f64).round() as u64);
        let lower = count_keys(plane, region, |key| (key >> 16 == high).then_some(key & 0xffff), monitor)?;
        Ok(value_of_key(high << 16 | find(&lower, rank).0))
    };
    percents.iter().map(percentile).collect::<Result<_, Cancelled>>().map(Some)
}

/// Counts the finite values of `region` by the bin of their keys (below 65536; `None` leaves out).
fn count_keys(
    plane: &Plane,
    region: &Region,
    bin: impl Fn(u32) -> Option<u32> + Sync,
    monitor: &Monitor,
) -> Result<Vec<u64>, Cancelled> {
    const BINS: usize = 1 << 16;
    let add = |mut a: Vec<u64>, b: Vec<u64>| {
        if a.is_empty() {
            return Ok(b);
        }
        a.iter_mut().zip(b).for_each(|(x, y)| *x += y);
        Ok(a)
    };
    let counts = rows(plane, region)
        .try_fold(Vec::new, |mut counts, row| {
            monitor.check()?;
            // Bins take half a megabyte: only a part that has rows makes them.
            if counts.is_empty() {
                counts = vec![0u64; BINS];
            }
            for bin in row.iter().filter(|x| x.is_finite()).filter_map(|&x| bin(key_of_value(x))) {
                counts[bin as usize] += 1;
            }
            Ok(counts)
        })
        .try_reduce(Vec::new, add)?;
    Ok(if counts.is_empty() { vec![0; BINS] } else { counts })
}

/// Integer that orders like the value.
fn key_of_value(value: f32) -> u32 {
    let bits = value.to_bits();
    // The bits of negative numbers order backwards, so they are flipped; others go above them.
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

fn value_of_key(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
}

/// Counts of values in equal bins over [min, max].
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// Lower end of the first bin.
    pub min: f32,
    /// Upper end of the last bin, which holds `max` itself too.
    pub max: f32,
    /// Number of values in each bin, from `min` on.
    pub counts: Vec<u64>,
    /// Values below `min`, −∞ included.
    pub below: u64,
    /// Values above `max`, +∞ included.
    pub above: u64,
    /// Values that are not a number.
    pub nan: u64,
}

impl Histogram {
    /// Lower and upper end of bin `i`.
    pub fn bin_range(&self, i: usize) -> (f32, f32) {
        let edge = |i: usize| self.min + (self.max - self.min) * i as f32 / self.counts.len() as f32;
        (edge(i), edge(i + 1))
    }
}

/// Histogram of the values of `region` in `bins` equal bins over [min, max].
///
/// # Panics
/// When `bins` is 0 or not `min < max`: a mistake of the caller.
pub fn histogram(plane: &Plane, region: &Region, min: f32, max: f32, bins: usize) -> Histogram {
    assert!(bins > 0 && min < max, "a histogram needs bins and a range");
    let scale = bins as f64 / (f64::from(max) - f64::from(min));
    let empty = || Histogram { min, max, counts: vec![0; bins], below: 0, above: 0, nan: 0 };
    rows(plane, region)
        .fold(empty, |mut histogram, row| {
            for &x in row {
                if x.is_nan() {
                    histogram.nan += 1;
                } else if x < min {
                    histogram.below += 1;
                } else if x > max {
                    histogram.above += 1;
                } else {
                    // `max` itself belongs to the last bin.
                    let bin = ((f64::from(x) - f64::from(min)) * scale) as usize;
                    histogram.counts[bin.min(bins - 1)] += 1;
                }
            }
            histogram
        })
        .reduce(empty, |mut a, b| {
            a.counts.iter_mut().zip(b.counts).for_each(|(x, y)| *x += y);
            (a.below, a.above, a.nan) = (a.below + b.below, a.above + b.above, a.nan + b.nan);
            a
        })
}
