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
