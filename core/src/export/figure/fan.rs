//! Fans of the uncertainty of motions, as figures and the window draw them.

use std::f32::consts::{FRAC_PI_2, PI};

/// Opacity of fans.
pub const FAN_OPACITY: f32 = 0.16;
/// Smallest standard deviation that has a fan, pixels of the drawing.
const MIN_SIGMA_PX: f32 = 3.0;
const PIECES: usize = 16;

/// Outline of the fan of an arrow: from its `middle` around the circle of one standard deviation `sigma` at its `tip`,
/// pixels of the drawing; the circle alone where it holds the middle. `None` where `sigma` is too small, or unknown.
pub fn fan(middle: [f32; 2], tip: [f32; 2], sigma: f32) -> Option<Vec<[f32; 2]>> {
    if !(MIN_SIGMA_PX..1e9).contains(&sigma) {
        return None;
    }
    let (along_x, along_y) = (tip[0] - middle[0], tip[1] - middle[1]);
    let (length, angle) = (along_x.hypot(along_y), along_y.atan2(along_x));
    // Up to the tangents from the middle; within the circle there is nothing to point from.
    let (from, half) = if length > sigma { (middle, FRAC_PI_2 + (sigma / length).asin()) } else { (tip, PI) };
    let around = (0..=PIECES).map(|piece| {
        let (sin, cos) = (angle + half * (2.0 * piece as f32 / PIECES as f32 - 1.0)).sin_cos();
        [tip[0] + sigma * cos, tip[1] + sigma * sin]
    });
    Some(std::iter::once(from).chain(around).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fan_touches_the_circle_of_its_tip_and_a_large_one_is_that_circle() {
        let (middle, tip) = ([10.0, 20.0], [40.0, 20.0]);
        let points = fan(middle, tip, 10.0).expect("large enough");
        let bounds = |i: usize| {
            let along = || points.iter().map(|point| point[i]);
            (along().fold(f32::INFINITY, f32::min), along().fold(f32::NEG_INFINITY, f32::max))
        };
        let ((left, right), (top, bottom)) = (bounds(0), bounds(1));
        assert!((left - 10.0).abs() < 1e-3 && (right - 50.0).abs() < 1e-3, "{points:?}");
        assert!((9.0..=10.001).contains(&(0.5 * (bottom - top))), "{points:?}");
        let large = fan(middle, tip, 40.0).expect("large enough");
        let reach = |point: &[f32; 2]| (point[0] - tip[0]).hypot(point[1] - tip[1]);
        assert!(large[0] == tip && large[1..].iter().all(|point| (reach(point) - 40.0).abs() < 1e-3));
        for none in [0.0, 2.9, f32::INFINITY, f32::NAN] {
            assert_eq!(fan(middle, tip, none), None, "{none}");
        }
    }
}
