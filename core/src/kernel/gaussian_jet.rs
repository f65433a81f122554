//! Gaussian jets: a place's sums of pixels under two Gaussians and under their derivatives up to the fourth order.
//!
//! Sampled Gaussians and their derivatives are separable, so all 30 sums take one pass over the pixels: each row is
//! multiplied by ten weights, and what remains by ten weights a column. A jet shows how D changes with place and, by
//! the heat equation, with scale, without a picture of D.

use crate::kernel::compact_kernel::PixelView;
use multiversion::multiversion;
use std::ops::Range;

/// Orders of derivatives along one axis, 0 to 4.
const ORDERS: usize = 5;
/// Weights of a row or column: the orders of two Gaussians.
const WEIGHTS: usize = 2 * ORDERS;
/// Derivatives with orders (along u, along v) that sum to 4 at most.
const TERMS: usize = 15;
/// Values in a vector register.
const LANES: usize = 8;

/// Derivatives of a smoothed image at one place: `jet[p][q]` is taken p times along u and q times along v; p + q is at
/// most 4.
pub type Jet = [[f64; ORDERS]; ORDERS];

/// Pixels around a place, less a local mean, and the buffers for their jets.
#[derive(Debug, Default)]
pub struct JetPixels {
    lines: Vec<f32>,
    along_u: Vec<f32>,
    along_v: Vec<[f32; WEIGHTS]>,
    /// Columns and rows.
    count: usize,
    stride: usize,
    /// Column and row of the first pixel.
    first: (i64, i64),
}

impl JetPixels {
    /// Reads the pixels up to `radius` from the pixel at `middle`, less `local_mean`.
    pub fn read(&mut self, pixels: &PixelView<'_>, middle: (i64, i64), radius: usize, local_mean: f32) {
        self.first = (middle.0 - radius as i64, middle.1 - radius as i64);
        self.count = 2 * radius + 1;
        self.stride = self.count.next_multiple_of(LANES);
        self.lines.clear();
        self.lines.resize(self.stride * self.count, 0.0);
        for (line, v) in self.lines.chunks_exact_mut(self.stride).zip(self.first.1..) {
            let line = &mut line[..self.count];
            pixels.line(v, self.first.0, line);
            line.iter_mut().for_each(|x| *x -= local_mean);
        }
    }

    /// Jets at the place (x, y) of the image under sampled Gaussians of the two `variances`, square pixels; the pixels
    /// that were read are all that is summed.
    pub fn jets(&mut self, (x, y): (f64, f64), variances: [f64; 2]) -> [Jet; 2] {
        let Self { lines, along_u, along_v, count, stride, first } = self;
        along_u.clear();
        along_u.resize(WEIGHTS * *stride, 0.0);
        along_v.clear();
        along_v.resize(*count, [0.0; WEIGHTS]);
        for (g, &variance) in variances.iter().enumerate() {
            weights(variance, first.0 as f64 - x, *count, |i, order, w| {
                along_u[(g * ORDERS + order) * *stride + i] = w;
            });
            weights(variance, first.1 as f64 - y, *count, |i, order, w| along_v[i][g * ORDERS + order] = w);
        }
        sums(lines, along_u, along_v, *stride).map(|terms| {
            let mut terms = terms.into_iter().map(f64::from);
            let mut jet = [[0.0; ORDERS]; ORDERS];
            for (p, row) in jet.iter_mut().enumerate() {
                row[..ORDERS - p].iter_mut().zip(&mut terms).for_each(|(to, term)| *to = term);
            }
            jet
        })
    }
}

/// Smallest variance of the Gaussian whose third and fourth derivatives are taken, square pixels: samples of those of
/// narrower ones do not sum to 0. There these orders are those of a slightly smoother image.
const MIN_VARIANCE_OF_HIGH_ORDERS: f64 = 0.8;

/// Calls `write(i, order, weight)` with the derivatives, with respect to its centre, of a Gaussian of `variance` at
/// `count` whole distances from `d` on.
fn weights(variance: f64, d: f64, count: usize, mut write: impl FnMut(usize, usize, f32)) {
    if variance >= MIN_VARIANCE_OF_HIGH_ORDERS {
        return weights_of_orders(0..ORDERS, variance, d, count, &mut write);
    }
    weights_of_orders(0..3, variance, d, count, &mut write);
    weights_of_orders(3..ORDERS, MIN_VARIANCE_OF_HIGH_ORDERS, d, count, &mut write);
}

/// As [`weights`], of some orders.
fn weights_of_orders(
    orders: Range<usize>,
    variance: f64,
    mut d: f64,
    count: usize,
    write: &mut impl FnMut(usize, usize, f32),
) {
    // Each sample is the one before times a ratio that itself falls by a constant ratio.
    let inverse = 1.0 / variance;
    let mut value = (-0.5 * d * d * inverse).exp() / (2.0 * std::f64::consts::PI * variance).sqrt();
    let mut ratio = (-(d + 0.5) * inverse).exp();
    let fall = (-inverse).exp();
    for i in 0..count {
        let mut before = 0.0;
        let mut now = value;
        for order in 0..orders.end {
            if order >= orders.start {
                write(i, order, now as f32);
            }
            (before, now) = (now, inverse * (d * now - order as f64 * before));
        }
        value *= ratio;
        ratio *= fall;
        d += 1.0;
    }
}

/// The sums of `lines`, rows of `stride` pixels, under the products of the weights of columns and of rows.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn sums(lines: &[f32], along_u: &[f32], along_v: &[[f32; WEIGHTS]], stride: usize) -> [[f32; TERMS]; 2] {
    let mut totals = [[[0.0f32; LANES]; TERMS]; 2];
    for start in (0..stride).step_by(LANES) {
        let mut acc = [[0.0f32; LANES]; WEIGHTS];
        for (line, weights) in lines.chunks_exact(stride).zip(along_v) {
            let pixels: &[f32; LANES] = line[start..][..LANES].try_into().expect("a whole vector");
            for (acc, weight) in acc.iter_mut().zip(weights) {
                for l in 0..LANES {
                    acc[l] = weight.mul_add(pixels[l], acc[l]);
                }
            }
        }
        for (g, totals) in totals.iter_mut().enumerate() {
            let mut term = 0;
            for p in 0..ORDERS {
                let weights: &[f32; LANES] =
                    along_u[(g * ORDERS + p) * stride + start..][..LANES].try_into().expect("a whole vector");
                for acc in &acc[g * ORDERS..(g + 1) * ORDERS - p] {
                    for l in 0..LANES {
                        totals[term][l] = weights[l].mul_add(acc[l], totals[term][l]);
                    }
                    term += 1;
                }
            }
        }
    }
    totals.map(|terms| terms.map(|lanes| lanes.iter().sum()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Plane;
    use proptest::prelude::*;

    /// The sum by its definition: pixels under a Gaussian, moved to another place for the derivatives.
    fn by_definition(plane: &Plane, mean: f32, (x, y): (f64, f64), variance: f64) -> f64 {
        let weight = |d: f64| (-0.5 * d * d / variance).exp() / (2.0 * std::f64::consts::PI * variance).sqrt();
        let (width, height) = plane.size();
        let mut sum = 0.0;
        for v in -30..height as i64 + 30 {
            for u in -30..width as i64 + 30 {
                let pixel = plane.at(u.clamp(0, width as i64 - 1) as usize, v.clamp(0, height as i64 - 1) as usize);
                sum += f64::from(pixel - mean) * weight(u as f64 - x) * weight(v as f64 - y);
            }
        }
        sum
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

        #[test]
        fn a_jet_is_the_sum_and_its_derivatives(
            x in 2.0f64..38.0, y in 2.0f64..28.0, variance in 1.0f64..9.0, ratio in 1.1f64..2.0, mean in 0.0f32..1.0,
        ) {
            let plane = Plane::from_fn(40, 30, |u, v| ((u * 31 + v * 17 + u * v) % 29) as f32 / 29.0);
            let mut pixels = JetPixels::default();
            pixels.read(&PixelView::of(&plane), (x.round() as i64, y.round() as i64), 24, mean);
            let variances = [variance, ratio * variance];
            let jets = pixels.jets((x, y), variances);
            for (jet, variance) in jets.into_iter().zip(variances) {
                let at = |dx: f64, dy: f64| by_definition(&plane, mean, (x + dx, y + dy), variance);
                prop_assert!((jet[0][0] - at(0.0, 0.0)).abs() < 1e-4, "{} {}", jet[0][0], at(0.0, 0.0));
                let e = 1e-3;
                prop_assert!((jet[1][0] - (at(e, 0.0) - at(-e, 0.0)) / (2.0 * e)).abs() < 1e-4);
                prop_assert!((jet[0][1] - (at(0.0, e) - at(0.0, -e)) / (2.0 * e)).abs() < 1e-4);
                let e = 0.05;
                let second = |f: &dyn Fn(f64) -> f64| (f(e) - 2.0 * f(0.0) + f(-e)) / (e * e);
                prop_assert!((jet[2][0] - second(&|d| at(d, 0.0))).abs() < 2e-3);
                prop_assert!((jet[0][2] - second(&|d| at(0.0, d))).abs() < 2e-3);
                prop_assert!((jet[2][2] - second(&|d| second(&|f| at(d, f)))).abs() < 5e-3);
                let fourth = (at(0.4, 0.0) - 4.0 * at(0.2, 0.0) + 6.0 * at(0.0, 0.0) - 4.0 * at(-0.2, 0.0) + at(-0.4, 0.0)) / 0.2f64.powi(4);
                prop_assert!((jet[4][0] - fourth).abs() < 0.03 * (1.0 + fourth.abs()), "{} {fourth}", jet[4][0]);
            }
        }
    }
}
