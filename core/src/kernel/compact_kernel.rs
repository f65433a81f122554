//! Compactly supported kernels: small round filters that locate a blob precisely.
//!
//! The DoG's Gaussians never end; content three radii away from a blob still pulls at its extremum. A compact kernel
//! ends: over q = ρ²/R² it is h(q) = (1 − q)³·p(q) for q < 1 and 0 beyond, with a polynomial p that makes its mean 0,
//! so that neither a grey level nor a ramp moves a blob. Its derivatives are known in closed form. There are two:
//!
//! - [`RIM`], p = 1 + 3q − 24q²: steepest where it is zero. With that radius on a blob's rim the place is determined
//!   best, and nothing beyond 1.9 radii matters.
//! - [`SOFT`], p = 1 − 10q + 24q² − 21q³: much like the DoG, for structure without such a rim; it reaches 2.65 radii.
//!
//! The noise of a disc's position is √(∫h'²ρ dρ)/(r·h'(r)), in units of the pixels' noise over contrast: 0.79 for
//! [`RIM`], 1.11 for [`SOFT`], 1.19 for the DoG at the disc's own scale and 0.94 for a DoG of the best scale.

use crate::plane::Plane;
use multiversion::multiversion;

/// Shape of a compactly supported kernel: h and its derivatives by their polynomials in q.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompactKernel {
    /// Coefficients of 1, q, q², q³ in h over (1 − q)³.
    value: [f32; 4],
    /// Coefficients of 1, q, q², q³ in h' over (1 − q)².
    first: [f32; 4],
    /// Coefficients of 1, q, q², q³ in h'' over 1 − q.
    second: [f32; 4],
    /// Distance from the centre at which the kernel is zero, in units of its radius R.
    pub zero_at: f64,
    /// Standard deviation of a component of the gradient on white noise of 1, for any radius: √(2π∫q·h'² dq).
    pub gradient_noise: f64,
}

pub const RIM: CompactKernel = CompactKernel {
    value: [1.0, 3.0, -24.0, 0.0],
    first: [0.0, -60.0, 120.0, 0.0],
    second: [-60.0, 420.0, -480.0, 0.0],
    zero_at: 0.525_329,
    gradient_noise: 2.9960,
};
pub const SOFT: CompactKernel = CompactKernel {
    value: [1.0, -10.0, 24.0, -21.0],
    first: [-13.0, 88.0, -183.0, 126.0],
    second: [114.0, -630.0, 1110.0, -630.0],
    zero_at: 0.377964,
    gradient_noise: 1.5715,
};
/// Columns that a line of pixels holds; no kernel is wider.
const LINE: usize = 192;
/// Largest radius, pixels.
pub const MAX_RADIUS: f64 = 90.0;
const LANES: usize = 8;

/// Part of an image: its pixels and their position. Beyond them the nearest pixel is repeated.
#[derive(Debug, Clone, Copy)]
pub struct PixelView<'a> {
    pub data: &'a [f32],
    /// Values from one row to the next.
    pub stride: usize,
    pub size: (usize, usize),
    /// Column and row of the image at which the pixels begin.
    pub left: i64,
    pub top: i64,
}

impl<'a> PixelView<'a> {
    pub fn of(plane: &'a Plane) -> Self {
        Self { data: plane.data(), stride: plane.width(), size: plane.size(), left: 0, top: 0 }
    }

    /// `count` pixels of row `v` from column `first` on; `None` where they are not all held.
    #[inline(always)]
    pub fn held(&self, v: i64, first: i64, count: usize) -> Option<&'a [f32]> {
        let from = usize::try_from(first - self.left).ok()?;
        self.row(v).get(from..from + count)
    }

    #[inline(always)]
    fn row(&self, v: i64) -> &'a [f32] {
        &self.data[(v - self.top).clamp(0, self.size.1 as i64 - 1) as usize * self.stride..][..self.size.0]
    }

    #[inline(always)]
    pub fn line(&self, v: i64, first: i64, out: &mut [f32]) {
        if let Some(row) = self.held(v, first, out.len()) {
            return out.copy_from_slice(row);
        }
        for (out, at) in out.iter_mut().zip(first - self.left..) {
            *out = self.row(v)[at.clamp(0, self.size.0 as i64 - 1) as usize];
        }
    }
}

/// Response of the kernel at a place, its gradient, and its second derivatives (uu, vv, uv), per pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct KernelResponse {
    pub value: f64,
    pub gradient: [f64; 2],
    pub hessian: [f64; 3],
}

impl KernelResponse {
    /// The smaller curvature of the peak, of a bright blob or a dark one; at most 0 where there is no peak.
    pub fn sharpness(&self) -> f64 {
        let [uu, vv, uv] = self.hessian.map(|h| -self.value.signum() * h);
        0.5 * (uu + vv) - (0.25 * (uu - vv).powi(2) + uv * uv).sqrt()
    }
}

#[inline(always)]
fn cubic(c: &[f32; 4], q: f32) -> f32 {
    q.mul_add(q.mul_add(q.mul_add(c[3], c[2]), c[1]), c[0])
}

/// Sums that make a [`KernelResponse`]. `x` and `y` are the distances of columns and rows, in radii.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn sums(kernel: &CompactKernel, pixels: &PixelView, first: (i64, i64), x: &[f32], y: &[f32], mean: f32) -> [f32; 7] {
    let mut line = [0.0f32; LINE];
    let mut acc = [[0.0f32; LANES]; 7];
    for (j, &y) in y.iter().enumerate() {
        pixels.line(first.1 + j as i64, first.0, &mut line[..x.len()]);
        let yy = y * y;
        for (x, pixels) in x.chunks_exact(LANES).zip(line.chunks_exact(LANES)) {
            for l in 0..LANES {
                let x = x[l];
                let q = x.mul_add(x, yy);
                // Each derivative of h has one power of (1 − q) less than the one before: `pixel` gains them in turn.
                let w = (1.0 - q).max(0.0);
                let pixel = (pixels[l] - mean) * w;
                let second = pixel * cubic(&kernel.second, q);
                let pixel = pixel * w;
                let first = pixel * cubic(&kernel.first, q);
                let pixel = pixel * w;
                acc[0][l] = pixel.mul_add(cubic(&kernel.value, q), acc[0][l]);
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
    // Lanes are added once at the end: the order of additions is the same on all processors.
    acc.map(|lanes| lanes.iter().sum())
}

impl PixelView<'_> {
    /// Mean on a circle of 0.9 `radius` around (x, y), subtracted first: samples sum to about 0, and err most there.
    pub fn local_mean(&self, radius: f64, (x, y): (f64, f64)) -> f32 {
        let near = |at: f64, n: usize| (at.round().max(0.0) as usize).min(n - 1);
        let at = |du: f64, dv: f64| {
            let (u, v) = (x - self.left as f64 + 0.9 * radius * du, y - self.top as f64 + 0.9 * radius * dv);
            self.data[near(v, self.size.1) * self.stride + near(u, self.size.0)]
        };
        // Cosines of multiples of 22.5 degrees.
        let [a, b, c] = [0.923_88, std::f64::consts::FRAC_1_SQRT_2, 0.382_68];
        let eighth = [(1.0, 0.0), (a, c), (b, b), (c, a)];
        let sum: f32 = eighth.iter().map(|&(x, y)| at(x, y) + at(-y, x) + at(-x, -y) + at(y, -x)).sum();
        sum / 16.0
    }

    /// The response at the place (x, y) of the image, on the pixels less [`PixelView::local_mean`].
    pub fn response(&self, kernel: &CompactKernel, radius: f64, (x, y): (f64, f64), local_mean: f32) -> KernelResponse {
        assert!((1.0..=MAX_RADIUS).contains(&radius), "a kernel of radius {radius}");
        let first = ((x - radius).floor() as i64 + 1, (y - radius).floor() as i64 + 1);
        let count = ((x + radius).ceil() as i64 - first.0) as usize;
        let rows = ((y + radius).ceil() as i64 - first.1) as usize;
        let mut distances = [[0.0f32; LINE]; 2];
        let inverse = 1.0 / radius;
        let columns = count.next_multiple_of(LANES);
        for (i, out) in distances[0][..columns].iter_mut().enumerate() {
            *out = ((first.0 as f64 + i as f64 - x) * inverse) as f32;
        }
        for (j, out) in distances[1][..rows].iter_mut().enumerate() {
            *out = ((first.1 as f64 + j as f64 - y) * inverse) as f32;
        }
        let sums = sums(kernel, self, first, &distances[0][..columns], &distances[1][..rows], local_mean);
        let [value, ring, ring_x, ring_y, xx, yy, xy] = sums.map(f64::from);
        // Derivatives of q with respect to the place, not to the pixel.
        let (once, twice) = (2.0 * inverse, 4.0 * inverse * inverse);
        KernelResponse {
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

    fn polynomial(c: &[f32; 4], q: f64) -> f64 {
        c.iter().rev().fold(0.0, |sum, &c| sum * q + f64::from(c))
    }

    fn h(kernel: &CompactKernel, q: f64) -> f64 {
        (1.0 - q).powi(3) * polynomial(&kernel.value, q)
    }

    fn integral(f: impl Fn(f64) -> f64) -> f64 {
        (0..20_000).map(|i| f((f64::from(i) + 0.5) / 20_000.0)).sum::<f64>() / 20_000.0
    }

    fn by_definition(kernel: &CompactKernel, plane: &Plane, radius: f64, (x, y): (f64, f64), local_mean: f32) -> f64 {
        let mut sum = 0.0;
        for v in -30..90i64 {
            for u in -30..90i64 {
                let q = ((u as f64 - x).powi(2) + (v as f64 - y).powi(2)) / (radius * radius);
                if q < 1.0 {
                    let pixel = plane.at(u.clamp(0, 59) as usize, v.clamp(0, 49) as usize) - local_mean;
                    sum += h(kernel, q) * f64::from(pixel);
                }
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn the_answer_is_the_sum_and_its_derivatives_are_differences(
            x in -3.0f64..62.0, y in -3.0f64..52.0, radius in 3.5f64..21.0, local_mean in 0.0f32..1.0, soft in any::<bool>(),
        ) {
            let (plane, kernel) = (texture(), if soft { SOFT } else { RIM });
            let answer = PixelView::of(&plane).response(&kernel, radius, (x, y), local_mean);
            let expected = |dx: f64, dy: f64| by_definition(&kernel, &plane, radius, (x + dx, y + dy), local_mean);
            prop_assert!((answer.value - expected(0.0, 0.0)).abs() < 2e-4 * radius, "{}", answer.value);
            let e = 1e-3;
            let steps = [[(e, 0.0), (-e, 0.0)], [(0.0, e), (0.0, -e)]];
            for (axis, [plus, minus]) in steps.into_iter().enumerate() {
                let difference = (expected(plus.0, plus.1) - expected(minus.0, minus.1)) / (2.0 * e);
                prop_assert!((answer.gradient[axis] - difference).abs() < 1e-3, "{answer:?} {difference}");
                let gradient = |(dx, dy)| PixelView::of(&plane).response(&kernel, radius, (x + dx, y + dy), local_mean).gradient;
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
        let (whole, part) = (PixelView::of(&plane), PixelView { left: 12, top: 9, ..PixelView::of(&part) });
        assert_eq!(whole.local_mean(8.0, (25.3, 22.8)), part.local_mean(8.0, (25.3, 22.8)));
        let response = |pixels: PixelView<'_>| pixels.response(&RIM, 8.0, (25.3, 22.8), 0.5);
        assert_eq!(response(whole), response(part));
    }

    #[test]
    fn flat_and_sloping_ground_answer_nothing() {
        let ramp = Plane::from_fn(60, 50, |u, v| 0.2 + 0.01 * u as f32 - 0.02 * v as f32);
        for at in [(30.0, 25.0), (30.4, 25.2), (29.5, 24.5)] {
            let disc = |u: usize, v: usize| (u as f64 - at.0).hypot(v as f64 - at.1) < 12.0 * RIM.zero_at;
            let blob = Plane::from_fn(60, 50, |u, v| f32::from(disc(u, v)));
            let blob = PixelView::of(&blob).response(&RIM, 12.0, at, 0.0);
            let ramp = PixelView::of(&ramp);
            let answer = ramp.response(&RIM, 12.0, at, ramp.local_mean(12.0, at));
            assert!(answer.value.abs() < 1e-3 * blob.value, "{answer:?} {blob:?}");
            assert!(answer.gradient.iter().all(|g| g.abs() < 2e-3 * blob.value), "{answer:?}");
        }
    }

    #[test]
    fn a_hat_is_what_its_numbers_say() {
        for kernel in [RIM, SOFT] {
            assert!(polynomial(&kernel.value, kernel.zero_at.powi(2)).abs() < 1e-4, "{kernel:?}");
            assert!(integral(|q| h(&kernel, q)).abs() < 1e-6, "its mean is 0: {kernel:?}");
            let first = |q: f64| (1.0 - q).powi(2) * polynomial(&kernel.first, q);
            let noise = (2.0 * std::f64::consts::PI * integral(|q| q * first(q).powi(2))).sqrt();
            assert!((noise / kernel.gradient_noise - 1.0).abs() < 1e-3, "{noise} {kernel:?}");
        }
    }

    #[test]
    fn a_peak_is_as_sharp_as_its_smaller_curvature() {
        let answer = |value: f64, hessian| KernelResponse { value, gradient: [0.0; 2], hessian };
        assert!((answer(2.0, [-3.0, -1.0, 0.0]).sharpness() - 1.0).abs() < 1e-12);
        assert!((answer(-2.0, [2.0, 2.0, 1.0]).sharpness() - 1.0).abs() < 1e-12);
        assert!(answer(2.0, [-3.0, 0.5, 0.0]).sharpness() < 0.0, "a saddle");
    }
}
