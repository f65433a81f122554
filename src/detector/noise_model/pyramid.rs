//! Means over squares of 2, 4, 8 … pixels: a frame at the resolutions at which its noise and its brightness are looked at.

use crate::plane::Plane;

/// A frame's means over squares of 2, 4, 8 … pixels, without overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxPyramid {
    levels: Vec<Plane>,
}

impl BoxPyramid {
    /// The means over squares of 2¹ … 2^`count` pixels, as far as both sides hold a whole square.
    pub fn new(frame: &Plane, count: usize) -> Self {
        let mut levels: Vec<Plane> = Vec::with_capacity(count);
        for _ in 0..count {
            let finer = levels.last().unwrap_or(frame);
            if finer.width() < 2 || finer.height() < 2 {
                break;
            }
            levels.push(halved(finer));
        }
        Self { levels }
    }

    /// The means over squares of 2^`level` pixels, `level` from 1 on; the coarsest there is, if it ends before.
    ///
    /// # Panics
    /// When the pyramid is empty: the frame is under 2×2 pixels.
    pub fn level(&self, level: usize) -> &Plane {
        &self.levels[(level - 1).min(self.levels.len() - 1)]
    }

    /// How many levels there are.
    pub fn len(&self) -> usize {
        self.levels.len()
    }

    /// Whether the frame was too small for any.
    pub fn is_empty(&self) -> bool {
        self.levels.is_empty()
    }
}

/// The means over squares of 2×2 pixels; a last odd column or row is left out.
fn halved(plane: &Plane) -> Plane {
    let (width, height) = (plane.width() / 2, plane.height() / 2);
    let mut out = Plane::zeros(width, height);
    for v in 0..height {
        let (upper, lower) = (plane.row(2 * v), plane.row(2 * v + 1));
        let pairs = upper.as_chunks::<2>().0.iter().zip(lower.as_chunks::<2>().0);
        for (out, (a, b)) in out.row_mut(v).iter_mut().zip(pairs) {
            *out = 0.25 * ((a[0] + a[1]) + (b[0] + b[1]));
        }
    }
    out
}

/// The value of a pyramid's `plane`, whose pixels are squares of `square` image pixels, at the image's place (u, v): bilinear between the middles of the
/// squares, the nearest ones beyond the outermost.
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
