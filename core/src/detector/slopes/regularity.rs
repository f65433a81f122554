//! Irregularities in the motion of a burst: of time ([`super::event`]), and of place.
//!
//! Where the picture turns or grows, slopes change linearly with place, so an affine map from place to slope is fitted
//! robustly. Its antisymmetric part is a turn, its mean diagonal growth; shear, as of slanted planes, must be smaller.

use super::evidence::{Steps, is_clear};
use super::{Size, SlopeEvidence};
use serde::Serialize;

/// Irregularity of the motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionWarning {
    /// Kind of irregularity, on which the unit of `number` depends.
    pub kind: MotionWarningKind,
    /// Frames out of order, late, copied or before a gap, counted from the first one used; none for turns and growth.
    pub frames: Vec<usize>,
    /// Size of the effect: number of frames, frame intervals late, degrees from +u towards +v, or percent, by `kind`.
    pub number: f32,
    /// Finding in one sentence, ready to be shown.
    pub text: String,
}

/// Irregularity of a burst: of the times of its frames, or of the motion over the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionWarningKind {
    /// In another order the frames would move uniformly.
    OutOfOrder,
    /// Frames are missing between others.
    MissingFrames,
    /// A frame was taken late or early.
    Late,
    /// Frames are copies of those before.
    Doubled,
    /// The picture turns.
    Turns,
    /// The picture grows or shrinks.
    Grows,
}

const MIN_WINDOWS: usize = 8;
const FITS: usize = 8;
/// Distance from the fit, in its typical distance, beyond which a window does not count.
const FAR: f64 = 4.0;
/// Share of the spread of slopes that may remain beside an affine map.
const LEFT: f64 = 0.5;
/// Minimum ratio of turn or growth to shear.
const OVER_SHEAR: f64 = 2.0;

/// Irregularities of windows whose slopes differ by place: a picture that turns or grows.
pub(super) fn of_places(evidence: &[SlopeEvidence], steps: Steps, size: Size) -> Vec<MotionWarning> {
    let clear: Vec<&SlopeEvidence> = evidence.iter().filter(|e| is_clear(e, steps)).collect();
    let Some((map, left)) = affine(&clear, size, 0.25 * steps.same) else {
        return Vec::new();
    };
    let [[uu, uv], [vu, vv]] = map;
    let (turn, growth) = (0.5 * (vu - uv), 0.5 * (uu + vv));
    let shear = (0.5 * (uu - vv)).abs().max(0.5 * (uv + vu).abs());
    // Motion of the picture's corners over the burst.
    let corner = 0.5 * (size.pixels.0 as f64).hypot(size.pixels.1 as f64) * size.gaps;
    let counts = |x: f64| left < LEFT && x.abs() * corner > 2.0 * super::SAME_SMEAR_PX && x.abs() > OVER_SHEAR * shear;
    let warning = |kind, number: f64, text| MotionWarning { kind, frames: Vec::new(), number: number as f32, text };
    let turns = counts(turn).then(|| {
        let degrees = (turn * size.gaps).to_degrees();
        let text = format!(
            "the frames turn by {:.1}° over the burst, so the slopes differ from place to place; use fewer frames",
            degrees.abs()
        );
        warning(MotionWarningKind::Turns, degrees, text)
    });
    let grows = counts(growth).then(|| {
        let percent = 100.0 * growth * size.gaps;
        let grows = if percent > 0.0 { "grows" } else { "shrinks" };
        let text = format!(
            "the picture {grows} by {:.1} % over the burst, so the slopes differ from place to place; use fewer frames",
            percent.abs()
        );
        warning(MotionWarningKind::Grows, percent, text)
    });
    [turns, grows].into_iter().flatten().collect()
}

/// Change of the slope (u, v) with place (u, v), per pixel and frame, and the share of the windows' spread of slopes
/// that it leaves; `error` is a slope's least error. `None` for too few windows, or if these lie on a line.
fn affine(evidence: &[&SlopeEvidence], size: Size, error: f64) -> Option<([[f64; 2]; 2], f64)> {
    if evidence.len() < MIN_WINDOWS {
        return None;
    }
    let middle = [size.pixels.0, size.pixels.1].map(|n| 0.5 * (n as f64 - 1.0));
    let unit = 0.5 * (size.pixels.0 + size.pixels.1) as f64;
    let at: Vec<[f64; 3]> = evidence
        .iter()
        .map(|e| [1.0, (f64::from(e.centre[0]) - middle[0]) / unit, (f64::from(e.centre[1]) - middle[1]) / unit])
        .collect();
    let slopes = evidence.iter().map(|e| [e.slope.u, e.slope.v].map(f64::from)).collect();
    let errors = evidence.iter().map(|e| f64::from(e.uncertainty).max(error)).collect();
    let windows = Windows { at, slopes, errors };
    let all = vec![true; evidence.len()];
    let (fit, mean) = windows.fits(&all)?;
    let left = windows.left(&fit, &mean, &all);
    // Things with motions of their own may fit a map too, but a map of three quarters then misses the fourth.
    let mut foretold: f64 = 0.0;
    for quarter in 0..4 {
        let is_there = |x: &[f64; 3]| usize::from(x[1] > 0.0) + 2 * usize::from(x[2] > 0.0) == quarter;
        let there: Vec<bool> = windows.at.iter().map(is_there).collect();
        if there.contains(&true) {
            let (fit, mean) = windows.fits(&there.iter().map(|is_there| !is_there).collect::<Vec<_>>())?;
            foretold = foretold.max(windows.left(&fit, &mean, &there));
        }
    }
    Some((fit.map(|[_, u, v]| [u / unit, v / unit]), left.max(foretold)))
}

/// Coefficients of each axis of a slope at (1, u, v).
type Map = [[f64; 3]; 2];

struct Windows {
    at: Vec<[f64; 3]>,
    slopes: Vec<[f64; 2]>,
    errors: Vec<f64>,
}

impl Windows {
    /// Map that fits the windows that `counts` names, and their mean; `None` where they do not determine a map.
    fn fits(&self, counts: &[bool]) -> Option<(Map, Map)> {
        let plain: Vec<f64> =
            self.errors.iter().zip(counts).map(|(e, counts)| if *counts { 1.0 / (e * e) } else { 0.0 }).collect();
        let (mut weights, mut fit) = (plain.clone(), Map::default());
        for _ in 0..FITS {
            fit = [solve(&self.at, &self.slopes, &weights, 0)?, solve(&self.at, &self.slopes, &weights, 1)?];
            let off: Vec<f64> = self.off(&fit).collect();
            // A floor keeps an exact fit from rejecting windows for their rounding.
            let typical = median(off.iter().zip(counts).filter(|(_, counts)| **counts).map(|(d, _)| *d)).max(0.2);
            // Tukey's biweight: a thing that moves by itself ends with no weight at all.
            for ((weight, plain), off) in weights.iter_mut().zip(&plain).zip(off) {
                *weight = plain * (1.0 - (off / (FAR * typical)).min(1.0).powi(2)).powi(2);
            }
        }
        let total: f64 = plain.iter().sum();
        let mean = |axis: usize| self.slopes.iter().zip(&plain).map(|(s, w)| s[axis] * w).sum::<f64>() / total;
        Some((fit, [[mean(0), 0.0, 0.0], [mean(1), 0.0, 0.0]]))
    }

    /// Distance of each window's slope from a map, in its error.
    fn off<'a>(&'a self, map: &'a Map) -> impl Iterator<Item = f64> + 'a {
        self.at.iter().zip(&self.slopes).zip(&self.errors).map(|((x, slope), error)| {
            let of = |axis: usize| slope[axis] - (0..3).map(|i| map[axis][i] * x[i]).sum::<f64>();
            of(0).hypot(of(1)) / error
        })
    }

    /// Share of the typical distance from `mean` that those windows that count have from `map`.
    fn left(&self, map: &Map, mean: &Map, counts: &[bool]) -> f64 {
        let typical = |map: &Map| median(self.off(map).zip(counts).filter(|(_, counts)| **counts).map(|(d, _)| d));
        typical(map).max(0.2) / typical(mean).max(f64::MIN_POSITIVE)
    }
}

/// Median of at least one value; of an even number of values, the upper of the middle two.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Coefficients of the weighted least squares of `slopes[…][axis]` over `at`; `None` where they are not determined.
fn solve(at: &[[f64; 3]], slopes: &[[f64; 2]], weights: &[f64], axis: usize) -> Option<[f64; 3]> {
    let mut rows = [[0.0f64; 4]; 3];
    for ((x, slope), weight) in at.iter().zip(slopes).zip(weights) {
        for (i, row) in rows.iter_mut().enumerate() {
            (0..3).for_each(|j| row[j] += weight * x[i] * x[j]);
            row[3] += weight * x[i] * slope[axis];
        }
    }
    // Elimination without exchange of rows: the matrix is positive definite, or the places lie on a line.
    for i in 0..3 {
        if rows[i][i] <= 1e-6 * rows[0][0] {
            return None;
        }
        for k in (0..3).filter(|k| *k != i) {
            let factor = rows[k][i] / rows[i][i];
            (0..4).for_each(|j| rows[k][j] -= factor * rows[i][j]);
        }
    }
    Some([0, 1, 2].map(|i| rows[i][3] / rows[i][i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::params::Slope;

    const SIZE: Size = Size { gaps: 9.0, pixels: (640, 480) };
    const STEPS: Steps = Steps { search: 0.4, same: 0.4 };

    /// Evidence of slopes that are `slope` of the place, in pixels from the middle.
    fn evidence(slope: impl Fn(f64, f64) -> (f64, f64)) -> Vec<SlopeEvidence> {
        let window = |i: usize| {
            let (u, v) = ((i % 6) as f64 * 100.0 + 60.0, (i / 6) as f64 * 90.0 + 60.0);
            let (along_u, along_v) = slope(u - 319.5, v - 239.5);
            super::super::evidence::tests::window(Slope::new(along_u as f32, along_v as f32), [u as f32, v as f32])
        };
        (0..30).map(window).collect()
    }

    #[test]
    fn parallax_and_uniform_motion_neither_turn_nor_grow() {
        assert_eq!(of_places(&evidence(|_, _| (2.0, 0.0)), STEPS, SIZE), []);
        assert_eq!(of_places(&evidence(|_, v| (2.0 + 0.004 * v, 0.0)), STEPS, SIZE), [], "a floor, seen at an angle");
        assert_eq!(of_places(&evidence(|u, _| (if u > 0.0 { 3.0 } else { 1.0 }, 0.0)), STEPS, SIZE), [], "two depths");
        assert_eq!(of_places(&evidence(|_, _| (2.0, 0.0))[..5], STEPS, SIZE), []);
    }
}
