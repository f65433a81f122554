//! The hat: a small round filter that says exactly where a blob lies.
//!
//! The DoG's Gaussians never end; what lies three radii away from a blob still pulls at its extremum. The hat ends. Over q = ρ²/R² it is
//! h(q) = (1 − q)³·(1 + 3q − 24q²) for q < 1 and 0 beyond: level in the middle, falling through 0 at [`ZERO_AT`]·R, a trough
//! around it at q = 1/2, and back to 0 with two continuous derivatives. Its mean is 0, so neither a grey level nor a ramp moves a blob. With the zero on a blob's rim the
//! hat is steepest where the blob itself is: the noise of the place is that of the gradient over the curvature,
//! √(∫h'²ρ dρ)/(r·h'(r)) in units of the pixels' noise over contrast, which is 0.85 here, 1.08 for the DoG at the blob's own scale and 0.95 for a DoG of the
//! best scale. On crowded charts it counts more that there is nothing beyond 1.9 radii.
//!
//! Gradient and second derivatives are known in closed form: h' = −60·q·(1 − q)²·(1 − 2q) and h'' = −60·(1 − q)·(1 − 7q + 8q²), so Newton's steps find the extremum.

use crate::plane::Plane;
use multiversion::multiversion;

/// Where the hat is zero, in units of its radius R: √((3 + √105)/48).
pub const ZERO_AT: f64 = 0.525_33;
/// Columns that a line of pixels holds; no hat is wider.
const LINE: usize = 192;
/// Largest radius, pixels.
pub const MAX_RADIUS: f64 = 90.0;
/// Values of a vector register.
const LANES: usize = 8;

/// A part of an image: its pixels and where they begin. Beyond the pixels the nearest one is repeated.
#[derive(Debug, Clone, Copy)]
pub struct Pixels<'a> {
    /// The pixels.
    pub plane: &'a Plane,
    /// Column of the image at which they begin.
    pub left: usize,
    /// Row of the image at which they begin.
    pub top: usize,
}

/// The hat's answer at a place, its gradient, and its second derivatives (uu, vv, uv), per pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Answer {
    /// The answer.
    pub value: f64,
    /// Its derivatives to the right and down.
    pub gradient: [f64; 2],
    /// Its second derivatives uu, vv and uv.
    pub hessian: [f64; 3],
}

/// The sums that make an [`Answer`], over the pixels of `plane` in `rows` lines from (`first.0`, `first.1`) on. `x` and `y` are the pixels' distances from
/// the place in radii; distances of unused columns are beyond 1.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn sums(plane: &Plane, first: (i64, i64), x: &[f32], y: &[f32], ground: f32) -> [f32; 7] {
    let (width, height) = (plane.width() as i64, plane.height() as i64);
    let count = x.len();
    let mut line = [0.0f32; LINE];
    let mut acc = [[0.0f32; LANES]; 7];
    for (j, &y) in y.iter().enumerate() {
        let row = plane.row((first.1 + j as i64).clamp(0, height - 1) as usize);
        if first.0 >= 0 && first.0 + count as i64 <= width {
            line[..count].copy_from_slice(&row[first.0 as usize..first.0 as usize + count]);
        } else {
            for (i, out) in line[..count].iter_mut().enumerate() {
                *out = row[(first.0 + i as i64).clamp(0, width - 1) as usize];
            }
        }
        let yy = y * y;
        for (x, pixels) in x.chunks_exact(LANES).zip(line.chunks_exact(LANES)) {
            for l in 0..LANES {
                let x = x[l];
                let q = x.mul_add(x, yy);
                let w = (1.0 - q).max(0.0);
                let pixel = (pixels[l] - ground) * w;
                let second = pixel * q.mul_add(q.mul_add(8.0, -7.0), 1.0);
                let pixel = pixel * w;
                let first = pixel * (q * q.mul_add(-2.0, 1.0));
                let pixel = pixel * w;
                acc[0][l] = pixel.mul_add(q.mul_add(q.mul_add(-24.0, 3.0), 1.0), acc[0][l]);
                acc[1][l] += first;
                acc[2][l] = first.mul_add(x, acc[2][l]);
                acc[3][l] = first.mul_add(y, acc[3][l]);
                let sx = second * x;
                acc[4][l] = sx.mul_add(x, acc[4][l]);
                acc[5][l] = second.mul_add(yy, acc[5][l]);
                acc[6][l] = sx.mul_add(y, acc[6][l]);
            }
        }
    }
    acc.map(|lanes| lanes.iter().sum())
}

impl Pixels<'_> {
    /// The grey level around the place (x, y) of the image: the mean of pixels on a circle of nine tenths of `radius`.
    ///
    /// The samples of a hat do not sum to exactly 0. Where it ends they are least even, so a hat is laid on the difference from what is there.
    pub fn ground(&self, radius: f64, (x, y): (f64, f64)) -> f32 {
        let near = |at: f64, n: usize| (at.round().max(0.0) as usize).min(n - 1);
        let (width, height) = self.plane.size();
        let at = |du: f64, dv: f64| {
            let (u, v) = (x - self.left as f64 + 0.9 * radius * du, y - self.top as f64 + 0.9 * radius * dv);
            self.plane.at(near(u, width), near(v, height))
        };
        // Cosines of multiples of 22.5 degrees.
        let [a, b, c] = [0.923_88, std::f64::consts::FRAC_1_SQRT_2, 0.382_68];
        let eighth = [(1.0, 0.0), (a, c), (b, b), (c, a)];
        let sum: f32 = eighth.iter().map(|&(x, y)| at(x, y) + at(-y, x) + at(-x, -y) + at(y, -x)).sum();
        sum / 16.0
    }

    /// The answer of a hat of `radius` pixels at the place (x, y) of the image, on the pixels less `ground`, which [`Pixels::ground`] gives.
    ///
    /// # Panics
    /// When the radius is not between 1 and [`MAX_RADIUS`], or there are no pixels.
    pub fn hat(&self, radius: f64, (x, y): (f64, f64), ground: f32) -> Answer {
        assert!((1.0..=MAX_RADIUS).contains(&radius), "a hat of radius {radius}");
        let (x, y) = (x - self.left as f64, y - self.top as f64);
        let first = ((x - radius).floor() as i64 + 1, (y - radius).floor() as i64 + 1);
        let count = ((x + radius).ceil() as i64 - first.0) as usize;
        let rows = ((y + radius).ceil() as i64 - first.1) as usize;
        let mut distances = [[0.0f32; LINE]; 2];
        let inverse = 1.0 / radius;
        for (i, out) in distances[0].iter_mut().enumerate() {
            *out = ((first.0 as f64 + i as f64 - x) * inverse) as f32;
        }
        for (j, out) in distances[1][..rows].iter_mut().enumerate() {
            *out = ((first.1 as f64 + j as f64 - y) * inverse) as f32;
        }
        let columns = count.next_multiple_of(LANES);
        let sums = sums(self.plane, first, &distances[0][..columns], &distances[1][..rows], ground);
        let [value, ring, ring_x, ring_y, xx, yy, xy] = sums.map(f64::from);
        // Derivatives of q with respect to the place, not the pixel, and the factor of h' and h''.
        let (once, twice) = (-60.0 * 2.0 * inverse, -60.0 * 4.0 * inverse * inverse);
        Answer {
            value,
            gradient: [-once * ring_x, -once * ring_y],
            hessian: [twice * xx + once * inverse * ring, twice * yy + once * inverse * ring, twice * xy],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn texture() -> Plane {
        Plane::from_fn(60, 50, |u, v| ((u * 31 + v * 17 + u * v) % 29) as f32 / 29.0)
    }

    fn pixels(plane: &Plane) -> Pixels<'_> {
        Pixels { plane, left: 0, top: 0 }
    }

    /// The definition, pixel by pixel.
    fn by_definition(plane: &Plane, radius: f64, (x, y): (f64, f64), ground: f32) -> f64 {
        let mut sum = 0.0;
        for v in -30..90i64 {
            for u in -30..90i64 {
                let q = ((u as f64 - x).powi(2) + (v as f64 - y).powi(2)) / (radius * radius);
                if q < 1.0 {
                    let pixel = plane.at(u.clamp(0, 59) as usize, v.clamp(0, 49) as usize) - ground;
                    sum += (1.0 - q).powi(3) * (1.0 + 3.0 * q - 24.0 * q * q) * f64::from(pixel);
                }
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn the_answer_is_the_sum_and_its_derivatives_are_differences(
            x in -3.0f64..62.0, y in -3.0f64..52.0, radius in 2.5f64..21.0, ground in 0.0f32..1.0,
        ) {
            let plane = texture();
            let answer = pixels(&plane).hat(radius, (x, y), ground);
            let expected = |dx: f64, dy: f64| by_definition(&plane, radius, (x + dx, y + dy), ground);
            prop_assert!((answer.value - expected(0.0, 0.0)).abs() < 2e-4 * radius, "{}", answer.value);
            let e = 1e-3;
            let steps = [[(e, 0.0), (-e, 0.0)], [(0.0, e), (0.0, -e)]];
            for (axis, [plus, minus]) in steps.into_iter().enumerate() {
                let difference = (expected(plus.0, plus.1) - expected(minus.0, minus.1)) / (2.0 * e);
                prop_assert!((answer.gradient[axis] - difference).abs() < 1e-3, "{answer:?} {difference}");
                let gradient = |(dx, dy)| pixels(&plane).hat(radius, (x + dx, y + dy), ground).gradient;
                let second = |of: usize| (gradient(plus)[of] - gradient(minus)[of]) / (2.0 * e);
                prop_assert!((answer.hessian[axis] - second(axis)).abs() < 2e-2, "{answer:?} {}", second(axis));
                prop_assert!((answer.hessian[2] - second(1 - axis)).abs() < 2e-2, "{answer:?} {}", second(1 - axis));
            }
        }
    }

    #[test]
    fn a_part_of_an_image_answers_like_the_whole() {
        let plane = texture();
        let part = Plane::from_fn(30, 30, |u, v| plane.at(u + 12, v + 9));
        let (whole, part) = (pixels(&plane), Pixels { plane: &part, left: 12, top: 9 });
        assert_eq!(whole.ground(8.0, (25.3, 22.8)), part.ground(8.0, (25.3, 22.8)));
        assert_eq!(whole.hat(8.0, (25.3, 22.8), 0.5), part.hat(8.0, (25.3, 22.8), 0.5));
    }

    #[test]
    fn flat_and_sloping_ground_answer_nothing() {
        let ramp = Plane::from_fn(60, 50, |u, v| 0.2 + 0.01 * u as f32 - 0.02 * v as f32);
        for at in [(30.0, 25.0), (30.4, 25.2), (29.5, 24.5)] {
            let disc = |u: usize, v: usize| (u as f64 - at.0).hypot(v as f64 - at.1) < 12.0 * ZERO_AT;
            let blob = pixels(&Plane::from_fn(60, 50, |u, v| f32::from(disc(u, v)))).hat(12.0, at, 0.0);
            let answer = pixels(&ramp).hat(12.0, at, pixels(&ramp).ground(12.0, at));
            assert!(answer.value.abs() < 1e-3 * blob.value, "{answer:?} {blob:?}");
            assert!(answer.gradient.iter().all(|g| g.abs() < 2e-3 * blob.value), "{answer:?}");
        }
    }

    #[test]
    fn the_ground_is_what_lies_around() {
        let plane = Plane::from_fn(60, 50, |u, v| if (u as f64 - 30.2).hypot(v as f64 - 25.7) < 8.0 { 0.9 } else { 0.1 });
        assert!((pixels(&plane).ground(12.0, (30.2, 25.7)) - 0.1).abs() < 1e-6);
    }

    #[test]
    fn the_zero_is_where_it_is_said_to_be() {
        let q = ZERO_AT * ZERO_AT;
        assert!((1.0 + 3.0 * q - 24.0 * q * q).abs() < 1e-4);
    }
}
