//! The joint extrema: samples of D that beat their neighbours in space, scale and slope.
//!
//! The tests come in METHOD's order and each rejection is counted. Thresholds come first because they are cheapest and reject nearly
//! everything: a row is scanned in blocks, and only blocks that hold a large enough |D| are looked at sample by sample.

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

const BLOCK: usize = 64;

/// How many values of `row` lie below `limit` in magnitude.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn count_below(row: &[f32], limit: f32) -> u32 {
    row.iter().map(|x| u32::from(x.abs() < limit)).sum()
}

/// Whether a value of the block reaches `limit` in magnitude.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn any_reaches(block: &[f32], limit: f32) -> bool {
    block.iter().fold(0u32, |hits, x| hits | u32::from(x.abs() >= limit)) != 0
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

/// Why the sample is not an extremum at its own slope, if it is not.
fn own_slope_test(value: f32, dog: &DogStrip, x: usize, y: usize, level_index: usize) -> Option<Test> {
    let own = &dog.levels[level_index];
    let row = own.row(y);
    let beside =
        if value > 0.0 { value > row[x - 1] && value > row[x + 1] } else { value < row[x - 1] && value < row[x + 1] };
    if !(beside && beats_three(value, own.row(y - 1), x) && beats_three(value, own.row(y + 1), x)) {
        return Some(Test::SpaceExtremum);
    }
    for level in [&dog.levels[level_index - 1], &dog.levels[level_index + 1]] {
        if !(y - 1..=y + 1).all(|v| beats_three(value, level.row(v), x)) {
            return Some(Test::ScaleExtremum);
        }
    }
    None
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
    for level_index in 1..dog.levels.len() - 1 {
        let limit = thresholds.peak.max(thresholds.gate[level_index]);
        for y in rows.start.max(1)..rows.end.min(height - 1) {
            let row = dog.levels[level_index].row(y);
            let inner = &row[1..width - 1];
            let below_peak = u64::from(count_below(inner, thresholds.peak));
            let below_any = u64::from(count_below(inner, limit));
            tally.samples += inner.len() as u64;
            tally.reject(Test::PeakThreshold, below_peak);
            tally.reject(Test::NoiseGate, below_any - below_peak);
            if below_any == inner.len() as u64 {
                continue;
            }
            for (block_index, block) in inner.chunks(BLOCK).enumerate() {
                if !any_reaches(block, limit) {
                    continue;
                }
                for (i, &value) in block.iter().enumerate() {
                    if value.abs() < limit {
                        continue;
                    }
                    let x = 1 + block_index * BLOCK + i;
                    match own_slope_test(value, dog, x, y, level_index) {
                        Some(test) => tally.reject(test, 1),
                        None => out.push(Candidate { x, y, level_index, value }),
                    }
                }
            }
        }
    }
}
