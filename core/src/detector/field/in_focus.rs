//! All in focus: every place of a burst stacked at its own motion.

use super::MotionField;
use crate::detector::params::slope_grid::Slope;
use crate::detector::stack::FrameTimes;
use crate::plane::mask::HIDDEN_WEIGHT;
use crate::plane::sample::bilinear;
use crate::plane::{Mask, Plane};
use rayon::prelude::*;
use std::sync::Arc;

/// Largest difference of motions across which they are interpolated, pixels of smear: borders stay sharp.
const SAME_SMEAR_PX: f32 = 2.0;

impl MotionField {
    /// Motion at the place (`u`, `v`), linear between the cells where these move alike, otherwise that of the nearest.
    fn smooth_at(&self, u: f32, v: f32, same_px_per_frame: f32) -> Slope {
        let along = |x: f32, count: usize| {
            let x = ((x + 0.5) / self.cell_px as f32 - 0.5).clamp(0.0, count as f32 - 1.0);
            let below = (x as usize).min(count.saturating_sub(2));
            (below, (below + 1).min(count - 1), x - below as f32)
        };
        let ((i, i_next, x), (j, j_next, y)) = (along(u, self.size.0), along(v, self.size.1));
        let slope = |i: usize, j: usize| self.motions[j * self.size.0 + i].slope;
        let corners = [slope(i, j), slope(i_next, j), slope(i, j_next), slope(i_next, j_next)];
        let nearest = corners[2 * usize::from(y >= 0.5) + usize::from(x >= 0.5)];
        // A mean of different motions would be the motion of nothing: a border stays a border.
        if corners.iter().any(|c| (c.u - nearest.u).hypot(c.v - nearest.v) > same_px_per_frame) {
            return nearest;
        }
        let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
        let mean = |of: fn(&Slope) -> f32| corners.iter().zip(weights).map(|(c, weight)| weight * of(c)).sum();
        Slope::new(mean(|c| c.u), mean(|c| c.v))
    }
}

/// Mean of `frames`, taken at `times`, with every place shifted by its own motion in `field`: all depths are sharp at
/// once, with the frames' size and values. Frames that do not see a place are left out unless none sees it.
pub fn in_focus(frames: &[&Plane], times: &FrameTimes, field: &MotionField) -> Plane {
    let Some(first) = frames.first() else { return Plane::zeros(0, 0) };
    let (width, height) = first.size();
    let same = SAME_SMEAR_PX / times.positions.span().max(1.0) as f32;
    let times = times.from_middle();
    let row = |v: usize| {
        let at = |u: usize| {
            let slope = field.smooth_at(u as f32, v as f32, same);
            let read = frames.iter().zip(&times).filter_map(|(frame, time)| {
                let (moved_u, moved_v) = slope.displacement(*time);
                let (u, v) = (u as f32 + moved_u, v as f32 + moved_v);
                let weight = |mask: &Arc<Mask>| bilinear(mask.weights(), u, v).map(|weight| weight.max(HIDDEN_WEIGHT));
                Some((bilinear(frame, u, v)?, frame.mask().map_or(Some(1.0), weight)?))
            });
            let (sum, weights) = read.fold((0.0, 0.0), |(sum, all), (x, weight)| (sum + weight * x, all + weight));
            if weights > 0.0 { sum / weights } else { 0.0 }
        };
        (0..width).map(at).collect::<Vec<f32>>()
    };
    let rows: Vec<Vec<f32>> = (0..height).into_par_iter().map(row).collect();
    Plane::from_vec(width, height, rows.concat())
}
