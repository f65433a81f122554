//! Extrema: samples of D that beat their neighbours in space and scale at their own slope and, for the joint rule, at
//! the slopes around. Thresholds and the eight neighbours in the image reject nearly all, so they run in vector lanes.

use crate::detector::feature::{Tally, Test};
use crate::detector::scale_space::DogTile;
use crate::plane::tile::{Region, Tile};
use multiversion::multiversion;

/// A sample, octave pixels, that is an extremum in space and scale at its own slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    pub x: usize,
    pub y: usize,
    /// Index 1 is DoG level 0.
    pub level_index: usize,
    pub value: f32,
}

/// Lower limits of |D| of a sample.
#[derive(Debug, Clone)]
pub struct Thresholds {
    /// Limit of the peak threshold's first test, for all levels.
    pub peak: f32,
    /// Noise gate where all frames cover, by DoG level index.
    pub gate: Vec<f32>,
    /// Factor of a sample that is compared with the adjacent levels: see [`scale_ease`].
    pub scale_ease: f32,
}

/// Factor of a sample that is compared with the adjacent levels. In an octave that [ascends](super::ascends), a sample
/// nearly as strong as its neighbours passes too: the ascent finds the exact scale.
pub fn scale_ease(ascends: bool) -> f32 {
    if ascends { 1.03 } else { 1.0 }
}

/// Number of columns that are skipped together when none of them reaches the thresholds.
const RUN: usize = 64;

#[derive(Debug, Default, Clone, Copy)]
struct Counts {
    below_peak: u32,
    /// Below the peak threshold or the noise gate.
    below_any: u32,
}

/// Appends to `found` the inner columns (0 is the second one) of `row` whose value reaches `limit` in magnitude and is
/// above, or below, its eight neighbours in `above`, `row` and `below`; counts the samples below the thresholds.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn space_extrema(above: &[f32], row: &[f32], below: &[f32], peak: f32, limit: f32, found: &mut Vec<u32>) -> Counts {
    let mut counts = Counts::default();
    let total = row.len() - 2;
    let mut marks = [0u8; RUN];
    let mut start = 0;
    while start < total {
        let n = RUN.min(total - start);
        let (a, b, c) = (&above[start..][..n], &above[start + 1..][..n], &above[start + 2..][..n]);
        let (d, e, f) = (&row[start..][..n], &row[start + 1..][..n], &row[start + 2..][..n]);
        let (g, h, i) = (&below[start..][..n], &below[start + 1..][..n], &below[start + 2..][..n]);
        let (mut below_peak, mut below_any) = (0u32, 0u32);
        // Counted even where the run is skipped: the tally reports the rejections of each test.
        for value in e {
            below_peak += u32::from(value.abs() < peak);
            below_any += u32::from(value.abs() < limit);
        }
        counts.below_peak += below_peak;
        counts.below_any += below_any;
        if below_any < n as u32 {
            let marks = &mut marks[..n];
            for u in 0..n {
                let (mut max, mut min) = (a[u], a[u]);
                for x in [b[u], c[u], d[u], f[u], g[u], h[u], i[u]] {
                    max = if x > max { x } else { max };
                    min = if x < min { x } else { min };
                }
                // `&` and `|` instead of `&&` and `||`: without branches the loop stays in vector lanes.
                let high = (e[u] > max) & (e[u] >= limit);
                let low = (e[u] < min) & (e[u] <= -limit);
                marks[u] = u8::from(high | low);
            }
            append_marked(marks, start as u32, found);
        }
        start += n;
    }
    counts
}

/// Appends `first` plus the index of each mark that is not 0: eight at a time, since few are.
#[inline(always)]
fn append_marked(marks: &[u8], first: u32, found: &mut Vec<u32>) {
    let (words, rest) = marks.as_chunks::<8>();
    for (place, word) in words.iter().enumerate() {
        let mut word = u64::from_le_bytes(*word);
        while word != 0 {
            found.push(first + 8 * place as u32 + word.trailing_zeros() / 8);
            word &= word - 1;
        }
    }
    let end = first + 8 * words.len() as u32;
    found.extend(rest.iter().zip(end..).filter(|(mark, _)| **mark != 0).map(|(_, at)| at));
}

/// Whether `value` beats the 3×3×3 samples around (x, y, level index) of another slope's `dog`. With `or_equals` it may
/// also equal them: of two slopes with equal D, as by a motion half-way between them, exactly one must stay.
pub fn beats_all_27(value: f32, dog: &DogTile, x: usize, y: usize, level_index: usize, or_equals: bool) -> bool {
    let sign = value.signum();
    let limit = sign * value;
    dog.levels[level_index - 1..=level_index + 1].iter().all(|level| {
        (y - 1..=y + 1).all(|v| {
            around(level, x, v).iter().all(|&other| {
                let other = sign * other;
                other < limit || (or_equals && other == limit)
            })
        })
    })
}

#[inline]
fn around(level: &Tile, x: usize, v: usize) -> &[f32] {
    let first = x - 1 - level.region().columns.start;
    &level.row(v)[first..first + 3]
}

fn is_scale_extremum(value: f32, levels: &[Tile], x: usize, y: usize, level_index: usize) -> bool {
    let beats = |other: &f32| if value > 0.0 { value > *other } else { value < *other };
    [&levels[level_index - 1], &levels[level_index + 1]]
        .iter()
        .all(|level| (y - 1..=y + 1).all(|v| around(level, x, v).iter().all(beats)))
}

/// Appends the samples of `region` that pass the thresholds and are extrema at their own slope, and counts the others.
/// The tiles of D hold at least one pixel more on each side of the region, inside the octave of `size`.
pub fn own_slope_extrema(
    levels: &[Tile],
    region: &Region,
    size: (usize, usize),
    thresholds: &Thresholds,
    tally: &mut Tally,
    out: &mut Vec<Candidate>,
) {
    let mut found = Vec::with_capacity(region.columns.len() / 2);
    // The first and the last level have only one neighbour in scale.
    for level_index in 1..levels.len() - 1 {
        level_extrema(levels, level_index, region, size, thresholds, tally, &mut found, out);
    }
}

/// Appends the extrema of one level, given by its index, and counts the other samples. `found` is a reusable buffer.
fn level_extrema(
    levels: &[Tile],
    level_index: usize,
    region: &Region,
    (width, height): (usize, usize),
    thresholds: &Thresholds,
    tally: &mut Tally,
    found: &mut Vec<u32>,
    out: &mut Vec<Candidate>,
) {
    let (first, end) = (region.columns.start.max(1), region.columns.end.min(width - 1));
    if first >= end {
        return;
    }
    let count = end - first;
    // A sample of exactly 0 is no extremum, whatever the thresholds.
    let limit = thresholds.peak.max(thresholds.gate[level_index]).max(f32::MIN_POSITIVE);
    let own = &levels[level_index];
    let left = first - 1 - own.region().columns.start;
    let line = |v: usize| &own.row(v)[left..left + count + 2];
    for y in region.rows.start.max(1)..region.rows.end.min(height - 1) {
        found.clear();
        let counts = space_extrema(line(y - 1), line(y), line(y + 1), thresholds.peak, limit, found);
        let (below_peak, below_any) = (u64::from(counts.below_peak), u64::from(counts.below_any));
        tally.samples += count as u64;
        tally.reject(Test::PeakThreshold, below_peak);
        tally.reject(Test::NoiseGate, below_any - below_peak);
        // The adjacent levels are read only for the few samples that are extrema in the image.
        for &column in found.iter() {
            let x = first + column as usize;
            let value = own.at(x, y);
            if is_scale_extremum(thresholds.scale_ease * value, levels, x, y, level_index) {
                out.push(Candidate { x, y, level_index, value });
            } else {
                tally.reject(Test::ScaleExtremum, 1);
            }
        }
        let extrema = found.len() as u64;
        // Each sample is rejected by one test: the rest after the thresholds failed in space.
        tally.reject(Test::SpaceExtremum, count as u64 - below_any - extrema);
    }
}

/// The candidate at (x, y) and `level_index`, or the test at its own slope that rejects it. `None` for a sample on the
/// octave's border, which the search does not examine. The tiles must hold the sample and a pixel around it.
pub fn own_slope_verdict(
    levels: &[Tile],
    (x, y, level_index): (usize, usize, usize),
    size: (usize, usize),
    thresholds: &Thresholds,
) -> Option<Result<Candidate, Test>> {
    // The search's own code on a region of one sample, so that both agree.
    let sample = Region { columns: x..x + 1, rows: y..y + 1 };
    let (mut tally, mut out) = (Tally::default(), Vec::new());
    level_extrema(levels, level_index, &sample, size, thresholds, &mut tally, &mut Vec::new(), &mut out);
    let rejected = Test::ALL.into_iter().find(|test| tally.rejected_by(*test) > 0);
    (tally.samples > 0).then(|| out.first().copied().ok_or_else(|| rejected.expect("it passes or it is rejected")))
}
