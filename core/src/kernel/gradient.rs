//! Gradients around a feature, a vector at a time, and the Gaussian windows that weight them.
//!
//! Orientation and descriptor compute the gradients that they need on the spot; nothing is stored. Everything here is
//! branch-free arithmetic, so that it runs in vector lanes of any function it is inlined into.

use crate::kernel::patch::{LANES, Patch, inside};
use std::f32::consts::{LN_2, LOG2_E};
use std::ops::Range;

/// Eighths of a turn in a radian.
const EIGHTHS: f32 = 4.0 / std::f32::consts::PI;

pub(crate) type Lane = [f32; LANES];

/// Smaller of two numbers, neither NaN: unlike [`f32::min`] a single instruction.
#[inline(always)]
pub(crate) fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(crate) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn polynomial<const N: usize>(coefficients: [f32; N], x: f32) -> f32 {
    let mut sum = coefficients[0];
    for &coefficient in &coefficients[1..] {
        sum = sum.mul_add(x, coefficient);
    }
    sum
}

/// Length (to 2·10⁻⁶) and direction (eighths of a turn in [0, 8), to 3·10⁻⁶) by minimax polynomials.
#[inline(always)]
fn polar(gu: f32, gv: f32) -> (f32, f32) {
    let (x, y) = (gu.abs(), gv.abs());
    let (small, large) = (min(x, y), max(x, y));
    let a = small / max(large, f32::MIN_POSITIVE);
    let s = a * a;
    const ROOT: [f32; 6] = [0.005_171_558, -0.023_276_972, 0.056_170_046, -0.123_759_41, 0.499_908_78, 1.000_001_1];
    const ARCTANGENT: [f32; 6] = [-0.011_721_2, 0.052_653_32, -0.116_432_87, 0.193_543_46, -0.332_623_47, 0.999_977_26];
    // Octant by octant: the arctangent of the smaller ratio, mirrored into place.
    let mut r = polynomial(ARCTANGENT, s) * (a * EIGHTHS);
    r = if y > x { 2.0 - r } else { r };
    r = if gu < 0.0 { 4.0 - r } else { r };
    r = if gv < 0.0 { 8.0 - r } else { r };
    (large * polynomial(ROOT, s), if r >= 8.0 { 0.0 } else { r })
}

/// exp(x) for x ≤ 0, to 2·10⁻⁷ of its value; 0 below −87.
#[inline(always)]
fn exp_of_negative(x: f32) -> f32 {
    let doublings = max((x * LOG2_E + 0.5).floor(), -127.0);
    // The remainder is within ±ln 2 / 2.
    let rest = max(x - doublings * LN_2, -LN_2);
    let series = polynomial([1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0], rest);
    series * f32::from_bits(whole(doublings + 127.0) << 23)
}

/// exp(−d²/(2·sigma²)) of the distances of `range` from `centre`, and at least one vector more.
#[inline(always)]
pub(crate) fn window(range: Range<i64>, centre: f32, sigma: f32, out: &mut Vec<f32>) {
    let scale = -0.5 / (sigma * sigma);
    let first = range.start as f32 - centre;
    out.resize(range.count().next_multiple_of(LANES) + LANES, 0.0);
    for (block, out) in out.chunks_exact_mut(LANES).enumerate() {
        let start = first + (block * LANES) as f32;
        for (i, out) in out.iter_mut().enumerate() {
            let d = start + i as f32;
            *out = exp_of_negative(scale * d * d);
        }
    }
}

#[inline(always)]
pub(crate) fn vector_of(values: &[f32], at: usize) -> &Lane {
    values[at..at + LANES].try_into().expect("a vector")
}

/// Neighbours on four sides of part of a row of a Gaussian level; each slice begins at the first pixel's.
pub(crate) struct GradientRow<'a> {
    before: &'a [f32],
    after: &'a [f32],
    above: &'a [f32],
    below: &'a [f32],
}

impl<'a> GradientRow<'a> {
    /// Row `v` of `level` from column `u` on; the level holds its neighbours.
    #[inline(always)]
    pub(crate) fn new(level: &'a Patch, u: i64, v: i64) -> Self {
        let row = level.values(u - 1, v);
        Self { before: row, after: &row[2..], above: level.values(u, v - 1), below: level.values(u, v + 1) }
    }

    /// Magnitudes and directions (eighths of a turn in [0, 8), from +u towards +v), from the row's pixel `at` on.
    #[inline(always)]
    pub(crate) fn vector(&self, at: usize) -> (Lane, Lane) {
        let (before, after) = (vector_of(self.before, at), vector_of(self.after, at));
        let (above, below) = (vector_of(self.above, at), vector_of(self.below, at));
        let (mut magnitude, mut eighths) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let (gu, gv) = (0.5 * (after[i] - before[i]), 0.5 * (below[i] - above[i]));
            (magnitude[i], eighths[i]) = polar(gu, gv);
        }
        (magnitude, eighths)
    }
}

/// Columns (or rows) of an octave of `n`, within `radius` of the pixel at `centre`, without the image's rim.
pub(crate) fn reach(centre: f32, radius: i64, n: usize) -> Range<i64> {
    let centre = (centre + 0.5) as i64;
    let wanted = centre - radius..centre + radius + 1;
    if n < 3 || wanted.end <= 1 || wanted.start >= n as i64 - 1 {
        return 0..0;
    }
    let inner = inside(&wanted, n);
    inner.start.max(1) as i64..inner.end.min(n - 1) as i64
}

/// Converts a whole number from 0 to 2²² to an integer, without the checks that a conversion of any number needs.
#[inline(always)]
pub(crate) fn whole(x: f32) -> u32 {
    // From 2²³ on a number's last bit is worth 1.
    (x + 8_388_608.0).to_bits() & 0x7f_ffff
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    #[test]
    fn polar_coordinates_are_exact_to_a_few_millionths() {
        for i in 0..10_000 {
            let angle = i as f32 / 10_000.0 * TAU;
            let (length, eighths) = polar(0.01 * angle.cos(), 0.01 * angle.sin());
            let d = (eighths / 8.0 * TAU - angle).rem_euclid(TAU);
            assert!(d.min(TAU - d) < 4e-6, "{angle}: {eighths}");
            assert!((length / 0.01 - 1.0).abs() < 3e-6, "{angle}: {length}");
        }
        assert_eq!(polar(0.0, 0.0), (0.0, 0.0));
        assert!(polar(1.0, -1e-30).1 < 8.0);
    }

    #[test]
    fn windows_are_gaussian() {
        let mut found = Vec::new();
        window(-30..31, 0.3, 7.0, &mut found);
        for (i, value) in (-30..31).zip(&found) {
            let expected = (-0.5 * ((f64::from(i) - 0.3) / 7.0).powi(2)).exp();
            assert!((f64::from(*value) / expected - 1.0).abs() < 1e-5, "{i}: {value} {expected}");
        }
        assert_eq!(exp_of_negative(0.0), 1.0);
        assert!(exp_of_negative(-80.0) > 0.0 && exp_of_negative(-1e6) == 0.0);
    }
}
