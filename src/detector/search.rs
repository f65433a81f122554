//! The joint extrema: samples of D that beat their neighbours in space, scale and slope.
//!
//! The tests come in METHOD's order and each rejection is counted. Thresholds come first because they are cheapest and reject nearly
//! everything, together with the eight neighbours in the image: both are tested for a whole row at once, in vector lanes.

use super::feature::{Tally, Test};
use super::octave::DogStrip;
use multiversion::multiversion;
use std::ops::Range;

/// A sample that is an extremum in space and scale at its own slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Column, octave pixels.
    pub x: usize,
    /// Row, octave pixels.
    pub y: usize,
    /// Index of its DoG level: 1 is level 0.
    pub level_index: usize,
    /// D there.
    pub value: f32,
}

/// The least |D| that a sample must have, by DoG level index.
#[derive(Debug, Clone)]
pub struct Thresholds {
    /// The peak threshold's first test, the same for all levels.
    pub peak: f32,
    /// The noise gate where all frames cover, by DoG level index.
    pub gate: Vec<f32>,
}

/// How many values of `row` lie below `limit` in magnitude.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn count_below(row: &[f32], limit: f32) -> u32 {
    row.iter().map(|x| u32::from(x.abs() < limit)).sum()
}

/// Marks with 1 the inner columns (`marks[i]` is column `i + 1`) of a row whose value reaches `limit` in magnitude and is above, or below, all
/// its eight neighbours. The rows are those above, at and below.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn mark_extrema(above: &[f32], row: &[f32], below: &[f32], limit: f32, marks: &mut [u8]) {
    let n = marks.len();
    let (a, b, c) = (&above[..n], &above[1..=n], &above[2..n + 2]);
    let (d, e, f) = (&row[..n], &row[1..=n], &row[2..n + 2]);
    let (g, h, i) = (&below[..n], &below[1..=n], &below[2..n + 2]);
    let larger = |x: f32, y: f32| if x > y { x } else { y };
    let smaller = |x: f32, y: f32| if x < y { x } else { y };
    for u in 0..n {
        let most =
            larger(larger(larger(a[u], b[u]), larger(c[u], d[u])), larger(larger(f[u], g[u]), larger(h[u], i[u])));
        let least = smaller(
            smaller(smaller(a[u], b[u]), smaller(c[u], d[u])),
            smaller(smaller(f[u], g[u]), smaller(h[u], i[u])),
        );
        let high = (e[u] > most) & (e[u] >= limit);
        let low = (e[u] < least) & (e[u] <= -limit);
        marks[u] = u8::from(high | low);
    }
}

/// Whether `value` beats the three samples around column `x` of `row`.
#[inline]
fn beats_three(value: f32, row: &[f32], x: usize) -> bool {
    let (a, b, c) = (row[x - 1], row[x], row[x + 1]);
    if value > 0.0 { value > a && value > b && value > c } else { value < a && value < b && value < c }
}

/// Whether `value` beats the 3×3×3 samples around (x, y, level index) of `dog`: the test against another slope. `or_equals` lets it stand when it only
/// equals them: of two slopes with the same D, which a motion half-way between them gives, exactly one must stay.
pub fn beats_all_27(value: f32, dog: &DogStrip, x: usize, y: usize, level_index: usize, or_equals: bool) -> bool {
    let sign = value.signum();
    let limit = sign * value;
    dog.levels[level_index - 1..=level_index + 1].iter().all(|level| {
        (y - 1..=y + 1).all(|v| {
            level.row(v)[x - 1..=x + 1].iter().all(|&other| {
                let other = sign * other;
                other < limit || (or_equals && other == limit)
            })
        })
    })
}

/// Whether the sample beats its neighbours at the levels above and below.
fn is_scale_extremum(value: f32, dog: &DogStrip, x: usize, y: usize, level_index: usize) -> bool {
    [&dog.levels[level_index - 1], &dog.levels[level_index + 1]]
        .iter()
        .all(|level| (y - 1..=y + 1).all(|v| beats_three(value, level.row(v), x)))
}

/// Appends the samples of rows `rows` that pass the thresholds and are extrema at their own slope, and counts the others.
/// `size` is the octave's; `dog` holds at least one row more on each side, inside the image.
pub fn own_slope_extrema(
    dog: &DogStrip,
    rows: &Range<usize>,
    size: (usize, usize),
    thresholds: &Thresholds,
    tally: &mut Tally,
    out: &mut Vec<Candidate>,
) {
    let (width, height) = size;
    let mut marks = vec![0u8; width - 2];
    for level_index in 1..dog.levels.len() - 1 {
        // A sample of exactly 0 is no extremum, whatever the thresholds.
        let limit = thresholds.peak.max(thresholds.gate[level_index]).max(f32::MIN_POSITIVE);
        let own = &dog.levels[level_index];
        for y in rows.start.max(1)..rows.end.min(height - 1) {
            let row = own.row(y);
            let inner = &row[1..width - 1];
            let below_peak = u64::from(count_below(inner, thresholds.peak));
            let below_any = u64::from(count_below(inner, limit));
            let above = inner.len() as u64 - below_any;
            tally.samples += inner.len() as u64;
            tally.reject(Test::PeakThreshold, below_peak);
            tally.reject(Test::NoiseGate, below_any - below_peak);
            if above == 0 {
                continue;
            }
            mark_extrema(own.row(y - 1), row, own.row(y + 1), limit, &mut marks);
            let mut extrema = 0;
            for (chunk_index, chunk) in marks.chunks(8).enumerate() {
                if chunk.iter().fold(0, |any, mark| any | mark) == 0 {
                    continue;
                }
                for (i, _) in chunk.iter().enumerate().filter(|(_, mark)| **mark != 0) {
                    extrema += 1;
                    let x = 1 + chunk_index * 8 + i;
                    let value = row[x];
                    if is_scale_extremum(value, dog, x, y, level_index) {
                        out.push(Candidate { x, y, level_index, value });
                    } else {
                        tally.reject(Test::ScaleExtremum, 1);
                    }
                }
            }
            tally.reject(Test::SpaceExtremum, above - extrema);
        }
    }
}
