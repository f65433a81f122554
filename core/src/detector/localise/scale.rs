//! Scale of a blob: the σ at which |D| at its place is largest, over all scales, not only those of the pyramid.
//!
//! D at one place is the difference of two sums of pixels under Gaussians, which may have any width. So D is evaluated
//! at three close scales around the pyramid's scale, and again around the peak of the parabola through the logarithms
//! until that converges. The scales are in VLFeat's convention, in which the pixels already have a σ of their own.

use crate::detector::localise::rim_radius;
use crate::kernel::compact_kernel::{PixelView, RIM};
use multiversion::multiversion;

/// Distance of the three scales, as a logarithm.
const STEP: f64 = 0.035;
/// Maximum number of rounds; two are usual.
const MAX_ROUNDS: usize = 4;
/// Largest move of a round, in steps.
const FARTHEST: f64 = 4.0;
/// Smallest variance that sampled Gaussians can represent, pixels².
const MIN_VARIANCE: f64 = 0.5;
/// Radius at which the Gaussians are cut, in standard deviations.
const CUT: f64 = 4.0;
/// Number of Gaussians in a round: two for each of three scales.
const GAUSSIANS: usize = 6;
/// Number of values whose sums are in registers at once.
const LANES: usize = 32;

/// `count` samples of each Gaussian around `at` at the whole pixels from `first` on, then zeros up to `stride`.
fn taps(variances: &[f64; GAUSSIANS], at: f64, first: i64, count: usize, stride: usize) -> Vec<f32> {
    let mut taps = vec![0.0f32; stride * GAUSSIANS];
    for (taps, variance) in taps.chunks_exact_mut(stride).zip(variances) {
        // Each sample is the one before times a ratio that itself falls by a constant ratio.
        let d = first as f64 - at;
        let mut value = (-0.5 * d * d / variance).exp() / (2.0 * std::f64::consts::PI * variance).sqrt();
        let mut ratio = (-(d + 0.5) / variance).exp();
        let fall = (-1.0 / variance).exp();
        for tap in &mut taps[..count] {
            *tap = value as f32;
            value *= ratio;
            ratio *= fall;
        }
    }
    taps
}

/// Sums of `lines` of pixels under Gaussians with samples `along_u` and `along_v`, all `stride` long, whole [`LANES`].
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn weighted_sums(lines: &[f32], along_u: &[f32], along_v: &[f32], stride: usize) -> [f64; GAUSSIANS] {
    let mut sums = [0.0f64; GAUSSIANS];
    for (sum, (along_u, along_v)) in sums.iter_mut().zip(along_u.chunks_exact(stride).zip(along_v.chunks_exact(stride)))
    {
        let mut total = [0.0f32; LANES];
        for (start, along_u) in along_u.chunks_exact(LANES).enumerate() {
            let mut acc = [0.0f32; LANES];
            for (line, weight) in lines.chunks_exact(stride).zip(along_v) {
                let pixels: &[f32; LANES] = line[start * LANES..][..LANES].try_into().expect("a whole block");
                // Along v first: the weights along u then apply to one sum a column.
                for l in 0..LANES {
                    acc[l] = weight.mul_add(pixels[l], acc[l]);
                }
            }
            for l in 0..LANES {
                total[l] = along_u[l].mul_add(acc[l], total[l]);
            }
        }
        *sum = total.iter().map(|&x| f64::from(x)).sum();
    }
    sums
}

/// Reach of the pixels that are read around a feature of scale `sigma` (pixels, `levels` levels an octave).
pub fn reach(sigma: f64, levels: usize) -> usize {
    (CUT * sigma * 2f64.powf(1.0 / levels as f64) * (1.0 + STEP)).ceil() as usize + 1
}

/// σ near `sigma` at which |D(x, y)| is largest, all in pixels. The pixels already have a σ of `from`; D has `levels`
/// levels an octave. `None` where there is no peak within one level.
pub fn scale_peak(pixels: &PixelView<'_>, (x, y): (f64, f64), sigma: f64, levels: usize, from: f64) -> Option<f64> {
    let k = 2f64.powf(1.0 / levels as f64);
    // Without the local mean, cutting the Gaussians off beyond the blob's rim would count as structure.
    let local_mean = pixels.local_mean(RIM.on_rim(rim_radius(sigma, levels)), (x, y));
    let radius = reach(sigma, levels) as i64;
    let first = (x.round() as i64 - radius, y.round() as i64 - radius);
    let count = 2 * radius as usize + 1;
    let stride = count.next_multiple_of(LANES);
    let mut lines = vec![0.0f32; stride * count];
    for (line, v) in lines.chunks_exact_mut(stride).zip(first.1..) {
        pixels.line(v, first.0, &mut line[..count]);
        line[..count].iter_mut().for_each(|x| *x -= local_mean);
    }
    // The pixels' own blur bounds the finest scale.
    let finest = 0.5 * (from * from + MIN_VARIANCE).ln() + STEP;
    let limits = sigma.ln() - k.ln()..sigma.ln() + k.ln();
    let mut middle = sigma.ln().max(finest);
    for _ in 0..MAX_ROUNDS {
        let variances: [f64; GAUSSIANS] = std::array::from_fn(|g| {
            let sigma = (middle + STEP * ((g / 2) as f64 - 1.0)).exp() * if g % 2 == 0 { 1.0 } else { k };
            sigma * sigma - from * from
        });
        let along_u = taps(&variances, x, first.0, count, stride);
        let along_v = taps(&variances, y, first.1, count, stride);
        let g = weighted_sums(&lines, &along_u, &along_v, stride);
        // The sign is that of the middle scale; where D changes its sign between scales there is no blob.
        let sign = (g[3] - g[2]).signum();
        let d: [f64; 3] = std::array::from_fn(|i| sign * (g[2 * i + 1] - g[2 * i]));
        if d.iter().any(|d| *d <= 0.0) {
            return None;
        }
        // A parabola through logarithms, as D over ln σ resembles a Gaussian.
        let [before, here, after] = d.map(f64::ln);
        let curvature = before - 2.0 * here + after;
        if curvature >= 0.0 {
            return None;
        }
        let offset = (0.5 * (before - after) / curvature).clamp(-FARTHEST, FARTHEST);
        let peak = middle + STEP * offset;
        if !limits.contains(&peak) {
            return None;
        }
        // Within a step of the middle the parabola is exact enough; otherwise it is fitted again nearer the peak.
        if offset.abs() < 0.75 {
            return Some(peak.exp());
        }
        // The pixels show no finer scale: a peak just below is taken, one farther away is unknown.
        if peak < finest && middle == finest {
            return (offset > -1.0).then(|| peak.exp());
        }
        middle = peak.max(finest);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Plane;

    #[test]
    fn a_gaussian_blob_has_its_own_scale() {
        // The blob's own σ is b less the pixels': D is largest at σ = b/√k.
        for (b, levels) in [(3.0f64, 3), (4.4, 4), (3.6, 1)] {
            let plane = Plane::from_fn(120, 110, |u, v| {
                (0.3 - 0.2 * (-((u as f64 - 60.3).powi(2) + (v as f64 - 54.8).powi(2)) / (2.0 * b * b)).exp()) as f32
            });
            let k = 2f64.powf(1.0 / levels as f64);
            for from in [0.0, 0.5, 1.6] {
                let expected = (b * b - from * from).sqrt() / k.sqrt();
                for start in [0.96, 1.0, 1.05] {
                    let found = scale_peak(&PixelView::of(&plane), (60.3, 54.8), start * expected, levels, from);
                    if expected.powi(2) > from * from + MIN_VARIANCE * 1.3 {
                        let found = found.expect("a blob");
                        assert!((found / expected - 1.0).abs() < 1e-3, "{b} {levels} {from}: {found} {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn where_there_is_no_blob_there_is_no_scale() {
        let ramp = Plane::from_fn(80, 70, |u, v| (u + 2 * v) as f32 * 0.003);
        let edge = Plane::from_fn(80, 70, |u, _| f32::from(u > 40));
        for plane in [ramp, edge] {
            assert_eq!(scale_peak(&PixelView::of(&plane), (40.5, 35.0), 3.0, 3, 0.5), None);
        }
    }
}
