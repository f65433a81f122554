//! Irregularities of a burst that its motion shows.
//!
//! Order: the path of the picture gives each frame a position. If the frames, sorted by it, are equally far apart but
//! not in their own order, they are out of order; if they are in order and a few distances are multiples of the others,
//! frames are missing there. Turning and growing: slopes then change linearly with place, so an affine map from place
//! to slope is fitted robustly. Its antisymmetric part is a turn, the mean of its diagonal growth; the rest is shear,
//! as a plane seen at an angle makes it, and must be smaller.

use super::evidence::{Steps, is_clear};
use super::{Size, SlopeEvidence};
use serde::Serialize;

/// Irregularity of the motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionWarning {
    /// Kind of irregularity.
    pub kind: MotionWarningKind,
    /// Those out of order, or after which frames are missing, counted from the first one used.
    pub frames: Vec<usize>,
    /// Size of the effect: number of frames out of order or missing, degrees from +u towards +v, or percent.
    pub number: f32,
    /// Finding and remedy, in one sentence.
    pub text: String,
}

/// Kinds of irregularities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionWarningKind {
    /// In another order the frames would move uniformly.
    OutOfOrder,
    /// Frames are missing between others.
    MissingFrames,
    /// The picture turns.
    Turns,
    /// The picture grows or shrinks.
    Grows,
}

const MIN_FRAMES: usize = 4;
/// Difference from a whole number of steps, in steps, up to which a distance is regular.
const REGULAR: f64 = 0.3;
/// Minimum step, in errors of the path.
const MIN_STEP: f64 = 3.0;
/// Share of the distances that may be longer than the others.
const MAX_LONGER: f64 = 0.34;

/// Irregularity of the order of frames that lie at `way`, with the error `noise`, both in pixels.
pub(super) fn of_order(way: &[[f64; 2]], noise: f64) -> Option<MotionWarning> {
    if way.len() < MIN_FRAMES {
        return None;
    }
    let (along, across) = main_axis(way);
    let mut order: Vec<usize> = (0..way.len()).collect();
    order.sort_by(|&a, &b| along[a].total_cmp(&along[b]));
    // Of both directions that in which more pairs of frames are in order.
    let in_order = |order: &[usize]| order.windows(2).filter(|w| w[0] < w[1]).count();
    let reversed: Vec<usize> = order.iter().rev().copied().collect();
    if in_order(&reversed) > in_order(&order) {
        order = reversed;
    }
    let distances: Vec<f64> = order.windows(2).map(|w| (along[w[1]] - along[w[0]]).abs()).collect();
    let step = median(distances.clone());
    if step <= MIN_STEP * noise || across.iter().any(|off| off.abs() > REGULAR * step) {
        return None;
    }
    let steps = |distance: f64| {
        let steps = (distance / step).round();
        ((distance / step - steps).abs() <= REGULAR && steps >= 1.0).then_some(steps as usize)
    };
    let steps: Vec<usize> = distances.iter().map(|d| steps(*d)).collect::<Option<_>>()?;
    let wrong: Vec<usize> = (0..order.len()).filter(|&i| order[i] != i).collect();
    let longer: Vec<usize> = (0..steps.len()).filter(|&i| steps[i] > 1).collect();
    match (wrong.is_empty(), longer.is_empty()) {
        (false, true) => Some(out_of_order(wrong, &order)),
        (true, false) if longer.len() as f64 <= MAX_LONGER * steps.len() as f64 => {
            let missing = longer.iter().map(|&i| steps[i] - 1).sum();
            Some(missing_frames(longer, missing))
        }
        _ => None,
    }
}

fn out_of_order(frames: Vec<usize>, order: &[usize]) -> MotionWarning {
    let list = |frames: &[usize]| frames.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    let text = match frames[..] {
        [a, b] => {
            format!("frames {a} and {b}, counted from 0, are exchanged: the other way round the motion is uniform")
        }
        _ => format!(
            "frames {} are out of order: the motion is uniform in the order {}, counted from 0; give them in that order",
            list(&frames),
            list(order)
        ),
    };
    MotionWarning { kind: MotionWarningKind::OutOfOrder, number: frames.len() as f32, frames, text }
}

fn missing_frames(after: Vec<usize>, missing: usize) -> MotionWarning {
    let places: Vec<String> = after.iter().map(|t| format!("{t} and {}", t + 1)).collect();
    let (frames, are) = if missing == 1 { ("frame", "is") } else { ("frames", "are") };
    let text = format!(
        "{missing} {frames} {are} missing between frames {}, counted from 0: the picture moves there by as many more steps; give all \
         frames, or only those on one side",
        places.join(", ")
    );
    MotionWarning { kind: MotionWarningKind::MissingFrames, number: missing as f32, frames: after, text }
}

fn main_axis(way: &[[f64; 2]]) -> (Vec<f64>, Vec<f64>) {
    let mean = |axis: usize| way.iter().map(|x| x[axis]).sum::<f64>() / way.len() as f64;
    let mean = [mean(0), mean(1)];
    let moment = |a: usize, b: usize| way.iter().map(|x| (x[a] - mean[a]) * (x[b] - mean[b])).sum::<f64>();
    let (sin, cos) = (0.5 * (2.0 * moment(0, 1)).atan2(moment(0, 0) - moment(1, 1))).sin_cos();
    let turned = |x: &[f64; 2]| {
        let (u, v) = (x[0] - mean[0], x[1] - mean[1]);
        (u * cos + v * sin, v * cos - u * sin)
    };
    way.iter().map(turned).unzip()
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
    let mut warnings = Vec::new();
    let mut warn = |kind, number: f64, text| {
        warnings.push(MotionWarning { kind, frames: Vec::new(), number: number as f32, text });
    };
    if counts(turn) {
        let degrees = (turn * size.gaps).to_degrees();
        let text = format!(
            "the frames turn by {:.1}° over the burst, so the slopes differ from place to place; use fewer frames",
            degrees.abs()
        );
        warn(MotionWarningKind::Turns, degrees, text);
    }
    if counts(growth) {
        let percent = 100.0 * growth * size.gaps;
        let grows = if percent > 0.0 { "grows" } else { "shrinks" };
        let text = format!(
            "the picture {grows} by {:.1} % over the burst, so the slopes differ from place to place; use fewer frames",
            percent.abs()
        );
        warn(MotionWarningKind::Grows, percent, text);
    }
    warnings
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
    let slopes: Vec<[f64; 2]> = evidence.iter().map(|e| [e.slope.u, e.slope.v].map(f64::from)).collect();
    let errors: Vec<f64> = evidence.iter().map(|e| f64::from(e.uncertainty).max(error)).collect();
    let plain: Vec<f64> = errors.iter().map(|e| 1.0 / (e * e)).collect();
    let mut weights = plain.clone();
    let (mut fit, mut typical) = ([[0.0; 3]; 2], f64::INFINITY);
    for _ in 0..FITS {
        fit = [solve(&at, &slopes, &weights, 0)?, solve(&at, &slopes, &weights, 1)?];
        let off: Vec<f64> = distances(&at, &slopes, &fit).zip(&errors).map(|(d, e)| d / e).collect();
        typical = median(off.clone()).max(0.2);
        for ((weight, plain), off) in weights.iter_mut().zip(&plain).zip(off) {
            *weight = plain * (1.0 - (off / (FAR * typical)).min(1.0).powi(2)).powi(2);
        }
    }
    // The same without a change by place.
    let total: f64 = plain.iter().sum();
    let mean = |axis: usize| slopes.iter().zip(&plain).map(|(s, w)| s[axis] * w).sum::<f64>() / total;
    let none = [[mean(0), 0.0, 0.0], [mean(1), 0.0, 0.0]];
    let before = median(distances(&at, &slopes, &none).zip(&errors).map(|(d, e)| d / e).collect());
    let left = typical / before.max(f64::MIN_POSITIVE);
    Some((fit.map(|[_, u, v]| [u / unit, v / unit]), left))
}

/// The upper one of two; of at least one value.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn distances<'a>(at: &'a [[f64; 3]], slopes: &'a [[f64; 2]], fit: &'a [[f64; 3]; 2]) -> impl Iterator<Item = f64> + 'a {
    at.iter().zip(slopes).map(|(x, slope)| {
        let of = |axis: usize| slope[axis] - (0..3).map(|i| fit[axis][i] * x[i]).sum::<f64>();
        of(0).hypot(of(1))
    })
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

    fn way(positions: &[f64]) -> Vec<[f64; 2]> {
        positions.iter().enumerate().map(|(t, x)| [1.6 * x + 0.05 * (t % 2) as f64, -1.2 * x]).collect()
    }

    fn order(positions: &[f64]) -> Option<(MotionWarningKind, Vec<usize>, f32)> {
        of_order(&way(positions), 0.05).map(|w| (w.kind, w.frames, w.number))
    }

    #[test]
    fn frames_out_of_order_are_told_from_missing_ones() {
        use MotionWarningKind::*;
        assert_eq!(order(&[0.0, 1.0, 2.0, 4.0, 3.0, 5.0]), Some((OutOfOrder, vec![3, 4], 2.0)));
        assert_eq!(order(&[0.0, 3.0, 2.0, 1.0, 4.0, 5.0, 6.0]), Some((OutOfOrder, vec![1, 3], 2.0)));
        // Of ten frames, frame_10 was sorted after frame_1.
        assert_eq!(order(&[0.0, 9.0, 1.0, 2.0, 3.0, 4.0]), None, "there is no frame between 4 and 9");
        assert_eq!(order(&[0.0, 5.0, 1.0, 2.0, 3.0, 4.0]).map(|w| w.0), Some(OutOfOrder));
        assert_eq!(order(&[0.0, 1.0, 2.0, 4.0, 5.0, 6.0]), Some((MissingFrames, vec![2], 1.0)));
        assert_eq!(order(&[0.0, 1.0, 2.0, 3.0, 6.0, 7.0, 8.0]), Some((MissingFrames, vec![3], 2.0)));
        let warning = of_order(&way(&[0.0, 1.0, 2.0, 4.0, 3.0, 5.0]), 0.05).expect("exchanged");
        assert!(warning.text.starts_with("frames 3 and 4, counted from 0, are exchanged"), "{}", warning.text);
        let warning = of_order(&way(&[0.0, 1.0, 2.0, 4.0, 5.0, 6.0]), 0.05).expect("missing");
        assert!(warning.text.starts_with("1 frame is missing between frames 2 and 3"), "{}", warning.text);
    }

    #[test]
    fn a_uniform_a_bent_and_a_still_way_are_in_order() {
        assert_eq!(order(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), None);
        assert_eq!(order(&[0.0, -1.0, -2.0, -3.0, -4.0]), None);
        assert_eq!(order(&[0.0, 1.0, 2.2, 3.7, 5.5, 7.6]), None, "it speeds up");
        assert_eq!(order(&[0.0, 1.0, 2.0, 1.5, 0.4, -0.7]), None, "it turns back");
        assert_eq!(order(&[0.0, 0.01, 0.0, 0.02, 0.01]), None);
        assert_eq!(order(&[0.0, 2.0, 1.0]), None, "there are too few frames");
    }

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
    fn a_turn_and_growth_are_named_with_their_size() {
        let turn = 1.2f64.to_radians() / 9.0;
        let grow = -0.015 / 9.0;
        let warnings = of_places(&evidence(|u, v| (2.0 + grow * u, 0.5 + grow * v)), STEPS, SIZE);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].text.contains("shrinks by 1.5 %"), "{warnings:?}");
        // An object that moves by itself changes nothing.
        let with_object = |u: f64, v: f64| if u.abs() < 100.0 { (-3.0, 1.0) } else { (1.0 - turn * v, turn * u) };
        let warnings = of_places(&evidence(with_object), STEPS, SIZE);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!((warnings[0].number - 1.2).abs() < 0.01 && warnings[0].text.contains("turn by 1.2°"), "{warnings:?}");
    }

    #[test]
    fn parallax_and_uniform_motion_neither_turn_nor_grow() {
        assert_eq!(of_places(&evidence(|_, _| (2.0, 0.0)), STEPS, SIZE), []);
        assert_eq!(of_places(&evidence(|_, v| (2.0 + 0.004 * v, 0.0)), STEPS, SIZE), [], "a floor, seen at an angle");
        assert_eq!(of_places(&evidence(|u, _| (if u > 0.0 { 3.0 } else { 1.0 }, 0.0)), STEPS, SIZE), [], "two depths");
        assert_eq!(of_places(&evidence(|_, _| (2.0, 0.0))[..5], STEPS, SIZE), []);
    }
}
