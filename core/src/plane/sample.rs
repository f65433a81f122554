//! Values between the pixels: at a place, along a line, in a turned square; and statistics of a rectangle's values.
//!
//! Positions are in pixels of the plane; the centre of the first pixel is (0, 0). A plane covers what its pixels cover:
//! from −0.5 to width − 0.5. Between the outermost centres and that edge the value is the nearest pixel's.

use super::Plane;
use super::statistics::{Region, summary, upper_median};

/// Value at (`u`, `v`), linear between the four pixels around; `None` outside the plane.
pub fn bilinear(plane: &Plane, u: f32, v: f32) -> Option<f32> {
    let (width, height) = plane.size();
    let inside = |x: f32, size: usize| x >= -0.5 && x <= size as f32 - 0.5;
    if width == 0 || height == 0 || !inside(u, width) || !inside(v, height) {
        return None;
    }
    let (u, v) = (u.clamp(0.0, (width - 1) as f32), v.clamp(0.0, (height - 1) as f32));
    let (u0, v0) = (u as usize, v as usize);
    let (u1, v1) = ((u0 + 1).min(width - 1), (v0 + 1).min(height - 1));
    let (fu, fv) = (u - u0 as f32, v - v0 as f32);
    let (top, bottom) = (plane.row(v0), plane.row(v1));
    // A weight of exactly 0 leaves its pixel out, so that a NaN beside an exact position does not spread.
    let mix = |a: f32, b: f32, f: f32| if f == 0.0 { a } else { (1.0 - f) * a + f * b };
    Some(mix(mix(top[u0], top[u1], fu), mix(bottom[u0], bottom[u1], fu), fv))
}

/// Value at (`u`, `v`) by Catmull–Rom splines through 4×4 pixels, of which the outermost are repeated; `None` outside
/// the centres of the outermost pixels. Fine structure loses less than by [`bilinear`].
pub fn cubic(plane: &Plane, u: f32, v: f32) -> Option<f32> {
    let (width, height) = plane.size();
    // Negated, so that NaN is outside as well.
    if !(u >= 0.0 && v >= 0.0 && u <= width as f32 - 1.0 && v <= height as f32 - 1.0) {
        return None;
    }
    let weights = |f: f32| {
        let [before, here] = [((1.0 - 0.5 * f) * f - 0.5) * f, (1.5 * f - 2.5) * f * f + 1.0];
        [before, here, ((2.0 - 1.5 * f) * f + 0.5) * f, (0.5 * f - 0.5) * f * f]
    };
    let (of_columns, of_rows) = (weights(u.fract()), weights(v.fract()));
    let pixel = |x: f32, k: usize, count: usize| (x as usize + k).saturating_sub(1).min(count - 1);
    let row = |k: usize| {
        let row = plane.row(pixel(v, k, height));
        (0..4).map(|k| of_columns[k] * row[pixel(u, k, width)]).sum::<f32>()
    };
    Some((0..4).map(|k| of_rows[k] * row(k)).sum())
}

/// `a` minus `b`, on the pixels of `a`. Pixel (i, j) of `a` lies at (i, j)·`b_px_per_a_px` of `b`, read linearly
/// between its pixels; outside `b` the difference is NaN, which has a colour of its own.
pub fn difference(a: &Plane, b: &Plane, b_px_per_a_px: f32) -> Plane {
    if a.size() == b.size() && b_px_per_a_px == 1.0 {
        return Plane::from_fn(a.width(), a.height(), |u, v| a.at(u, v) - b.at(u, v));
    }
    Plane::from_fn(a.width(), a.height(), |u, v| {
        a.at(u, v) - bilinear(b, u as f32 * b_px_per_a_px, v as f32 * b_px_per_a_px).unwrap_or(f32::NAN)
    })
}

/// Square patch of `size × size` samples around `centre` = (u, v), `half_width_px` pixels to each side, whose
/// horizontal axis points along `angle_rad` (from +u towards +v): what a descriptor with that orientation sees. Sample
/// (i, j) lies at `centre + half_width_px·((2i + 1)/size − 1, (2j + 1)/size − 1)`, turned; NaN outside.
pub fn sample_patch(plane: &Plane, centre: (f32, f32), half_width_px: f32, angle_rad: f32, size: usize) -> Plane {
    let (sin, cos) = angle_rad.sin_cos();
    let offset = |i: usize| half_width_px * ((2 * i + 1) as f32 / size as f32 - 1.0);
    Plane::from_fn(size, size, |i, j| {
        let (x, y) = (offset(i), offset(j));
        bilinear(plane, centre.0 + cos * x - sin * y, centre.1 + sin * x + cos * y).unwrap_or(f32::NAN)
    })
}

/// Value at one place of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileSample {
    /// Distance from the line's start, in the pixels in which its ends were given.
    pub distance_px: f32,
    /// Column of the place, in the pixels of the ends.
    pub u: f32,
    /// Row of the place, in the pixels of the ends.
    pub v: f32,
    /// Value there, linear between the plane's pixels; NaN outside the plane.
    pub value: f32,
}

/// Maximum number of samples of a profile: a screen shows no more.
const MAX_SAMPLES: usize = 1 << 14;

/// Values of `plane` along the line from `from` to `to`, both (u, v) in pixels of which `px_per_plane_px` make one of
/// the plane: about one sample a pixel, both ends included. Ends that are not finite give none.
pub fn profile(plane: &Plane, from: [f32; 2], to: [f32; 2], px_per_plane_px: f32) -> Vec<ProfileSample> {
    let (du, dv) = (to[0] - from[0], to[1] - from[1]);
    let length = du.hypot(dv);
    // Negated, so that NaN is refused as well.
    if !(length.is_finite() && from[0].is_finite() && from[1].is_finite() && px_per_plane_px > 0.0) {
        return Vec::new();
    }
    let steps = ((length / px_per_plane_px).round() as usize).clamp(1, MAX_SAMPLES - 1);
    (0..=steps)
        .map(|i| {
            let t = i as f32 / steps as f32;
            let (u, v) = (from[0] + t * du, from[1] + t * dv);
            let value = bilinear(plane, u / px_per_plane_px, v / px_per_plane_px).unwrap_or(f32::NAN);
            ProfileSample { distance_px: t * length, u, v, value }
        })
        .collect()
}

/// Statistics of the values in a rectangle. Values that are not finite are left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionStatistics {
    /// Number of finite values.
    pub count: usize,
    /// Mean of the finite values.
    pub mean: f64,
    /// Standard deviation about the mean; 0 for a single value.
    pub deviation: f64,
    /// Smallest finite value.
    pub min: f32,
    /// Largest finite value.
    pub max: f32,
    /// Standard deviation of white noise on a smooth picture; `None` in a region smaller than 3 × 3 pixels.
    pub noise: Option<f64>,
}

/// Statistics of the values of `region`, cut to the plane; `None` when it holds no finite value.
pub fn region_statistics(plane: &Plane, region: &Region) -> Option<RegionStatistics> {
    let region = region.within(plane);
    let summary = summary(plane, &region);
    let (min, max) = summary.range()?;
    // About the mean: sums of squares would cancel where values are large and alike.
    let mut squares = 0.0;
    for v in region.rows.clone() {
        let row = &plane.row(v)[region.columns.clone()];
        squares += row.iter().filter(|x| x.is_finite()).map(|&x| (f64::from(x) - summary.mean).powi(2)).sum::<f64>();
    }
    let deviation = (squares / (summary.count.max(2) - 1) as f64).sqrt();
    let noise = region_noise(plane, &region);
    Some(RegionStatistics { count: summary.count, mean: summary.mean, deviation, min, max, noise })
}

const MEDIAN_OF_NORMAL: f64 = 0.674_489_750_196_081_7;

/// Standard deviation of white noise over any smooth picture: the median of the absolute second differences in both
/// directions at once (J. Immerkær, "Fast noise variance estimation", 1996; the median ignores edges).
fn region_noise(plane: &Plane, region: &Region) -> Option<f64> {
    if region.columns.len() < 3 || region.rows.len() < 3 {
        return None;
    }
    let mut answers: Vec<f32> = Vec::with_capacity((region.columns.len() - 2) * (region.rows.len() - 2));
    for v in region.rows.start + 1..region.rows.end - 1 {
        let rows = [plane.row(v - 1), plane.row(v), plane.row(v + 1)];
        for u in region.columns.start + 1..region.columns.end - 1 {
            let across = |row: &[f32]| row[u - 1] - 2.0 * row[u] + row[u + 1];
            let answer = across(rows[0]) - 2.0 * across(rows[1]) + across(rows[2]);
            if answer.is_finite() {
                answers.push(answer.abs());
            }
        }
    }
    // The mask's weights have a sum of squares of 36.
    upper_median(answers).map(|median| f64::from(median) / (6.0 * MEDIAN_OF_NORMAL))
}
