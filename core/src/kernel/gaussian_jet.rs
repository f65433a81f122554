//! Gaussian jets: a place's sums of pixels under two Gaussians and under their derivatives up to the fourth order.
//!
//! Sampled Gaussians and their derivatives are separable, so all 30 sums take one pass over the pixels, with ten
//! weights a row and ten a column. A jet shows how D changes with place and, by the heat equation, with scale.

use crate::kernel::compact_kernel::PixelView;
use multiversion::multiversion;

/// Orders of derivatives along one axis, 0 to 4.
const ORDERS: usize = 5;
/// Weights of a row or column: the orders of two Gaussians.
const WEIGHTS: usize = 2 * ORDERS;
/// Derivatives with orders (along u, along v) that sum to 4 at most.
const TERMS: usize = 15;
const LANES: usize = 8;

/// Derivatives of a smoothed image at one place: `jet[p][q]`, p times along u and q times along v, p + q ≤ 4.
pub type Jet = [[f64; ORDERS]; ORDERS];

/// Pixels around a place, less a local mean, and the buffers for their jets.
#[derive(Debug, Default)]
pub struct JetPixels {
    lines: Vec<f32>,
    /// Weights of columns for both Gaussians, then those of rows.
    along: [Vec<f32>; 4],
    wider: Vec<f32>,
    stride: usize,
    first: (i64, i64),
}

impl JetPixels {
    pub fn read(&mut self, pixels: &PixelView<'_>, middle: (i64, i64), radius: usize, local_mean: f32) {
        self.first = (middle.0 - radius as i64, middle.1 - radius as i64);
        let count = 2 * radius + 1;
        self.stride = count.next_multiple_of(LANES);
        self.lines.resize(self.stride * count, 0.0);
        read_less(pixels, self.first, local_mean, &mut self.lines, count);
    }

    /// Jets at the place (x, y) of the image under sampled Gaussians of the two `variances`, square pixels.
    pub fn jets(&mut self, (x, y): (f64, f64), variances: [f64; 2]) -> [Jet; 2] {
        let Self { lines, along, wider, stride, first } = self;
        let (du, dv) = (first.0 as f64 - x, first.1 as f64 - y);
        let [one, other] = variances;
        let gaussians = [(one, du), (other, du), (one, dv), (other, dv)];
        along.iter_mut().for_each(|along| along.resize(ORDERS * *stride, 0.0));
        samples(gaussians, along.each_mut().map(|along| &mut along[..*stride]));
        for (along, (variance, d)) in along.iter_mut().zip(gaussians) {
            weights(variance, d, *stride, along, wider);
        }
        sums(lines, along, *stride).map(|terms| {
            let mut terms = terms.into_iter().map(f64::from);
            let mut jet = [[0.0; ORDERS]; ORDERS];
            for (p, row) in jet.iter_mut().enumerate() {
                row[..ORDERS - p].iter_mut().zip(&mut terms).for_each(|(to, term)| *to = term);
            }
            jet
        })
    }
}

/// Fills `count` rows of `lines` with as many pixels from `first` on less `mean`, and with 0 beyond them.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn read_less(pixels: &PixelView, first: (i64, i64), mean: f32, lines: &mut [f32], count: usize) {
    let stride = lines.len() / count;
    for (line, v) in lines.chunks_exact_mut(stride).zip(first.1..) {
        let (line, padding) = line.split_at_mut(count);
        match pixels.held(v, first.0, count) {
            Some(from) => line.iter_mut().zip(from).for_each(|(out, x)| *out = x - mean),
            None => {
                pixels.line(v, first.0, line);
                line.iter_mut().for_each(|x| *x -= mean);
            }
        }
        padding.fill(0.0);
    }
}

/// Square pixels. Samples of narrower Gaussians give second derivatives that are wrong by several percent.
const MIN_SAMPLED_VARIANCE: f64 = 1.2;
/// Terms by which a sampled Gaussian is made as sharp as a narrower one, beside itself.
const SHARPENING: usize = 4;

/// Writes the derivatives of a Gaussian of `variance` at `stride` whole distances from `d` on, order after order; `out`
/// begins with its samples. A Gaussian too narrow to be sampled is a wider one, whose samples these are, sharpened by
/// exp(−c/2·∂²), c being the difference of the variances.
fn weights(variance: f64, d: f64, stride: usize, out: &mut [f32], wider: &mut Vec<f32>) {
    let missing = MIN_SAMPLED_VARIANCE - variance;
    if missing <= 0.0 {
        return derivatives(variance, d, stride, out);
    }
    wider.resize((ORDERS + 2 * SHARPENING) * stride, 0.0);
    wider[..stride].copy_from_slice(&out[..stride]);
    derivatives(MIN_SAMPLED_VARIANCE, d, stride, wider);
    for (order, out) in out.chunks_exact_mut(stride).enumerate() {
        out.copy_from_slice(&wider[order * stride..][..stride]);
        // The series of a Gaussian that is sharpened by its own derivatives.
        let mut factor = 1.0;
        for term in 1..=SHARPENING {
            factor *= (-0.5 * missing / term as f64) as f32;
            let derivative = &wider[(order + 2 * term) * stride..][..stride];
            out.iter_mut().zip(derivative).for_each(|(out, x)| *out += factor * x);
        }
    }
}

/// Samples of Gaussians of a variance, at least [`MIN_SAMPLED_VARIANCE`], at whole distances from another on, side by
/// side: alone each would wait for its sample before.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn samples(gaussians: [(f64, f64); 4], outs: [&mut [f32]; 4]) {
    // Each sample is the one before times a ratio that itself falls by a constant ratio.
    let [mut value, mut ratio, mut fall] = [[0.0f64; 4]; 3];
    for (k, (variance, d)) in gaussians.into_iter().enumerate() {
        let variance = variance.max(MIN_SAMPLED_VARIANCE);
        let inverse = 1.0 / variance;
        value[k] = (-0.5 * d * d * inverse).exp() / (2.0 * std::f64::consts::PI * variance).sqrt();
        (ratio[k], fall[k]) = ((-(d + 0.5) * inverse).exp(), (-inverse).exp());
    }
    let [a, b, c, d] = outs;
    for (((a, b), c), d) in a.iter_mut().zip(b).zip(c).zip(d) {
        for (k, out) in [a, b, c, d].into_iter().enumerate() {
            *out = value[k] as f32;
            value[k] *= ratio[k];
            ratio[k] *= fall[k];
        }
    }
}

/// Derivatives of a Gaussian of `variance` with respect to its centre, as many orders as `out` holds, from its samples.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn derivatives(variance: f64, d: f64, stride: usize, out: &mut [f32]) {
    let inverse = 1.0 / variance;
    let (first, step) = ((d * inverse) as f32, inverse as f32);
    // The recursion of the Hermite polynomials.
    for order in 1..out.len() / stride {
        let (before, next) = out.split_at_mut(order * stride);
        let now = &before[(order - 1) * stride..];
        let factor = step * (order - 1) as f32;
        let before = &before[order.saturating_sub(2) * stride..][..stride];
        for (i, ((next, now), before)) in next[..stride].iter_mut().zip(now).zip(before).enumerate() {
            *next = (first + step * i as f32) * now - factor * before;
        }
    }
}

/// The sums of `lines`, rows of `stride` pixels, under the products of the weights `along` columns and rows.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn sums(lines: &[f32], along: &[Vec<f32>; 4], stride: usize) -> [[f32; TERMS]; 2] {
    let mut totals = [[[0.0f32; LANES]; TERMS]; 2];
    // Slices as long as the loop need no checks in it, and leave the sums in registers.
    let rows = lines.len() / stride;
    let along_v: [&[f32]; WEIGHTS] = std::array::from_fn(|i| &along[2 + i / ORDERS][i % ORDERS * stride..][..rows]);
    for start in (0..stride).step_by(LANES) {
        let mut acc = [[0.0f32; LANES]; WEIGHTS];
        for (v, line) in (0..rows).zip(lines.chunks_exact(stride)) {
            let pixels: &[f32; LANES] = line[start..][..LANES].try_into().expect("a whole vector");
            for order in 0..WEIGHTS {
                for l in 0..LANES {
                    acc[order][l] = along_v[order][v].mul_add(pixels[l], acc[order][l]);
                }
            }
        }
        // Row sums of one order along v are shared by all orders along u.
        for (g, totals) in totals.iter_mut().enumerate() {
            let mut term = 0;
            for p in 0..ORDERS {
                let weights: &[f32; LANES] =
                    along[g][p * stride + start..][..LANES].try_into().expect("a whole vector");
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
            for (jet, variance) in pixels.jets((x, y), variances).into_iter().zip(variances) {
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

    #[test]
    fn narrow_jets_of_smooth_pixels_are_those_of_the_scene() {
        // A blob of variance s² that is blurred by a Gaussian is one of the sum of their variances.
        let own = 1.7f64 * 1.7;
        for (x, y) in [(20.0, 15.0), (20.5, 15.5), (20.3, 14.6)] {
            let plane = Plane::from_fn(40, 30, |u, v| {
                (-((u as f64 - x).powi(2) + (v as f64 - y).powi(2)) / (2.0 * own)).exp() as f32
            });
            let mut pixels = JetPixels::default();
            pixels.read(&PixelView::of(&plane), (20, 15), 9, 0.0);
            for variance in [0.3, 0.5, 0.8, 1.1, 1.3] {
                let [jet, _] = pixels.jets((x, y), [variance, 2.0]);
                let all = own + variance;
                let peak = own / all;
                for ((p, q), expected, error) in [
                    ((0, 0), peak, 1e-3),
                    ((1, 0), 0.0, 2e-3),
                    ((2, 0), -peak / all, 5e-3),
                    ((0, 2), -peak / all, 5e-3),
                    ((2, 2), peak / (all * all), 2e-2),
                    ((4, 0), 3.0 * peak / (all * all), 3e-2),
                ] {
                    let found = jet[p][q];
                    assert!((found - expected).abs() < error, "{p} {q} of {variance} at {x} {y}: {found} {expected}");
                }
            }
        }
    }
}
