//! Pyramids of means over squares of 2, 4, 8 … pixels: frames at the resolutions for measuring noise and brightness.

use crate::plane::Plane;
use multiversion::multiversion;
use std::ops::Range;

/// A frame's means over squares of 2, 4, 8 … pixels, without overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxPyramid {
    levels: Vec<Plane>,
}

impl BoxPyramid {
    /// Computes the means over squares of 2¹ … 2^`count` pixels, as far as both sides hold a whole square.
    pub fn new(frame: &Plane, count: usize) -> Self {
        if count == 0 || frame.width() < 2 || frame.height() < 2 {
            return Self { levels: Vec::new() };
        }
        Self::from_halved(halved(frame), count)
    }

    /// Computes the pyramid from the means over squares of 2×2 pixels.
    pub(super) fn from_halved(first: Plane, count: usize) -> Self {
        let mut levels = vec![first];
        while levels.len() < count {
            let finer = &levels[levels.len() - 1];
            if finer.width() < 2 || finer.height() < 2 {
                break;
            }
            levels.push(halved(finer));
        }
        Self { levels }
    }

    /// Means over squares of 2^`level` pixels, `level` from 1 on; the coarsest ones where the pyramid ends before.
    ///
    /// # Panics
    /// If the pyramid is empty: the frame is under 2×2 pixels, or no levels were made.
    pub fn level(&self, level: usize) -> &Plane {
        &self.levels[(level - 1).min(self.levels.len() - 1)]
    }

    /// Number of levels.
    pub fn len(&self) -> usize {
        self.levels.len()
    }

    /// Whether there are no levels, as for a frame under 2×2 pixels.
    pub fn is_empty(&self) -> bool {
        self.levels.is_empty()
    }
}

/// Means over squares of 2×2 pixels; a last odd column or row is left out.
fn halved(plane: &Plane) -> Plane {
    let mut out = Plane::zeros(plane.width() / 2, plane.height() / 2);
    halve_rows(plane, 0..plane.height(), out.data_mut());
    out
}

/// Writes the means over squares of 2×2 pixels of some rows of `plane`, from an even one on, into whole rows of `out`.
pub(super) fn halve_rows(plane: &Plane, rows: Range<usize>, out: &mut [f32]) {
    for (i, out) in out.chunks_exact_mut((plane.width() / 2).max(1)).take(rows.len() / 2).enumerate() {
        let v = rows.start + 2 * i;
        halve_pair(plane.row(v), plane.row(v + 1), out);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn halve_pair(upper: &[f32], lower: &[f32], out: &mut [f32]) {
    let pairs = upper.as_chunks::<2>().0.iter().zip(lower.as_chunks::<2>().0);
    for (out, (a, b)) in out.iter_mut().zip(pairs) {
        *out = 0.25 * ((a[0] + a[1]) + (b[0] + b[1]));
    }
}

/// Value of a pyramid's `plane`, whose pixels are squares of `square` image pixels, at the image's place (u, v):
/// bilinear between the centres of the squares, constant beyond the outermost.
pub fn sample_at(plane: &Plane, square: f32, u: f32, v: f32) -> f32 {
    let split = |x: f32, n: usize| {
        let at = ((x + 0.5) / square - 0.5).clamp(0.0, n as f32 - 1.0);
        let whole = (at as usize).min(n.saturating_sub(2));
        (whole, at - whole as f32)
    };
    let ((x, fx), (y, fy)) = (split(u, plane.width()), split(v, plane.height()));
    let (right, below) = ((x + 1).min(plane.width() - 1), (y + 1).min(plane.height() - 1));
    let along = |y: usize| (1.0 - fx) * plane.at(x, y) + fx * plane.at(right, y);
    (1.0 - fy) * along(y) + fy * along(below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_means_and_end_where_no_square_fits() {
        let frame = Plane::from_fn(13, 9, |u, v| (u * 10 + v) as f32);
        let pyramid = BoxPyramid::new(&frame, 9);
        assert_eq!(pyramid.len(), 3);
        assert_eq!(pyramid.level(1).size(), (6, 4));
        let mean = |x: usize, y: usize| {
            (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).map(|(i, j)| frame.at(4 * x + i, 4 * y + j)).sum::<f32>()
                / 16.0
        };
        assert!((pyramid.level(2).at(2, 1) - mean(2, 1)).abs() < 1e-4);
        assert_eq!(pyramid.level(7).size(), (1, 1));
    }

    #[test]
    fn a_ramp_is_sampled_as_it_is() {
        let frame = Plane::from_fn(64, 48, |u, v| u as f32 + 2.0 * v as f32);
        let pyramid = BoxPyramid::new(&frame, 3);
        for (u, v) in [(20.0, 11.0), (3.5, 3.5), (41.25, 30.0)] {
            assert!((sample_at(pyramid.level(3), 8.0, u, v) - (u + 2.0 * v)).abs() < 1e-3);
        }
        assert!((sample_at(pyramid.level(3), 8.0, 0.0, 0.0) - (3.5 + 7.0)).abs() < 1e-3, "the nearest square");
        assert!(sample_at(pyramid.level(6), 64.0, 5.0, 5.0).is_finite());
    }
}
