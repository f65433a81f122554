//! The motion stack: frames shifted by a slope and averaged.

use super::params::Interpolation;
use super::slope_grid::Slope;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;

/// The motion-stack image of `frames` (one size, in time order) at `slope`: the mean over the frames that cover a pixel of
/// `F_t(x + (t − t0)·λ)`, with `t0 = (N − 1)/2`. Same size as the frames, same unit.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
///
/// # Panics
/// When there is no frame or the sizes differ.
pub fn motion_stack(
    frames: &[&Plane],
    slope: Slope,
    interpolation: Interpolation,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let (width, height) = frames[0].size();
    let t0 = (frames.len() as f32 - 1.0) / 2.0;
    let mut out = Plane::zeros(width, height);
    for v in 0..height {
        monitor.check()?;
        for u in 0..width {
            let (mut sum, mut count) = (0.0, 0.0f32);
            for (t, frame) in frames.iter().enumerate() {
                let mut x = u as f32 + (t as f32 - t0) * slope.u;
                let mut y = v as f32 + (t as f32 - t0) * slope.v;
                if interpolation == Interpolation::Nearest {
                    (x, y) = (x.round(), y.round());
                }
                if x >= 0.0 && y >= 0.0 && x <= (width - 1) as f32 && y <= (height - 1) as f32 {
                    let (x0, y0) = (x.floor() as usize, y.floor() as usize);
                    let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
                    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
                    sum += (1.0 - fy) * ((1.0 - fx) * frame.at(x0, y0) + fx * frame.at(x1, y0))
                        + fy * ((1.0 - fx) * frame.at(x0, y1) + fx * frame.at(x1, y1));
                    count += 1.0;
                }
            }
            out.row_mut(v)[u] = sum / count.max(1.0);
        }
    }
    Ok(out)
}
