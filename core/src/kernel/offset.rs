//! Offset at which a frame is read for a motion stack, the pixels that it covers there, and how many of them are seen.

use crate::plane::Plane;
use std::ops::Range;

/// Offset of one frame: whole pixels and a fraction in [0, 1) in each direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameOffset {
    pub whole_u: i64,
    pub whole_v: i64,
    pub part_u: f32,
    pub part_v: f32,
    /// Columns and rows before the first one that still count as the first, 0 or 1: see `Interpolation::Truncated`.
    pub before_u: i64,
    pub before_v: i64,
}

impl FrameOffset {
    pub(crate) fn covers_columns(&self, width: usize) -> Range<usize> {
        Self::covered(self.whole_u, self.part_u, self.before_u, width)
    }

    pub(crate) fn covers_rows(&self, height: usize) -> Range<usize> {
        Self::covered(self.whole_v, self.part_v, self.before_v, height)
    }

    /// Positions `0 … n−1` that stay inside at an offset; `before` positions before 0 count too.
    pub(super) fn covered(whole: i64, part: f32, before: i64, n: usize) -> Range<usize> {
        let reach = i64::from(part > 0.0);
        let start = (-whole - before).clamp(0, n as i64);
        let end = (n as i64 - whole - reach).clamp(start, n as i64);
        start as usize..end as usize
    }

    pub fn covers(&self, u: usize, v: usize, size: (usize, usize)) -> bool {
        self.covers_columns(size.0).contains(&u) && self.covers_rows(size.1).contains(&v)
    }

    /// Whether `frame` covers the pixel (u, v) and its sample there is seen.
    pub fn sees(&self, frame: &Plane, u: usize, v: usize) -> bool {
        self.covers(u, v, frame.size()) && self.weight(frame, (u, v), 0.0) >= 0.5
    }

    /// Mean weight (0 … 1) of the samples of `frame` read up to `radius` pixels around pixel (u, v), which it covers.
    pub fn weight(&self, frame: &Plane, (u, v): (usize, usize), radius: f32) -> f32 {
        let Some(mask) = frame.mask() else { return 1.0 };
        let (x, y) = ((u as i64 + self.whole_u) as f32 + self.part_u, (v as i64 + self.whole_v) as f32 + self.part_v);
        let (steps, size) = ((radius.ceil() as i32).min(DISC_STEPS), frame.size());
        let around = |at: f32, n: usize| n.min((at - radius) as usize)..n.min((at + radius) as usize + 2);
        if !mask.touches(&around(x, size.0), around(y, size.1)) {
            return 1.0;
        }
        let (mut sum, mut count) = (0.0, 0.0);
        for (i, j) in (-steps..=steps).flat_map(|j| (-steps..=steps).map(move |i| (i, j))) {
            // A large disc is sampled, not summed.
            let away = |step: i32| step as f32 * radius / steps.max(1) as f32;
            let (x, y) = ((x + away(i)).round().max(0.0) as usize, (y + away(j)).round().max(0.0) as usize);
            if i * i + j * j <= steps * steps && x < size.0 && y < size.1 {
                (sum, count) = (sum + mask.weights().at(x, y), count + 1.0);
            }
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }
}

/// Steps in a radius at most, over which a weight is averaged.
const DISC_STEPS: i32 = 5;
