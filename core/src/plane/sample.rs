//! Values between the pixels: at a place, along a line, in a turned square; and statistics of a rectangle's values.
//!
//! Positions are in pixels of the plane; the centre of the first pixel is (0, 0). A plane covers what its pixels cover:
//! from −0.5 to width − 0.5. Between the outermost centres and that edge the value is the nearest pixel's.

use super::Plane;
use super::statistics::{Region, summary};

/// The value at (`u`, `v`), linear between the four pixels around it; `None` where the plane has no pixel (or the
/// position is not finite).
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

/// `a` minus `b`, on the pixels of `a`. Pixel (i, j) of `a` lies at (i, j)·`b_px_per_a_px` of `b`, whose values are
/// taken linearly between its pixels; where `b` has none the difference is NaN, which is shown in its own colour.
pub fn difference(a: &Plane, b: &Plane, b_px_per_a_px: f32) -> Plane {
    if a.size() == b.size() && b_px_per_a_px == 1.0 {
        return Plane::from_fn(a.width(), a.height(), |u, v| a.at(u, v) - b.at(u, v));
    }
    Plane::from_fn(a.width(), a.height(), |u, v| {
        let other = bilinear(b, u as f32 * b_px_per_a_px, v as f32 * b_px_per_a_px);
        a.at(u, v) - other.unwrap_or(f32::NAN)
    })
}

/// A square patch of `size × size` samples around `centre` = (u, v), reaching `half_width_px` pixels to each side. Its
/// horizontal axis points along `angle_rad` (from +u towards +v): what a descriptor with that orientation sees.
///
/// Sample (i, j) is the value at `centre + half_width_px·((2i + 1)/size − 1, (2j + 1)/size − 1)`, turned: the samples
/// are the centres of `size²` equal squares. Samples outside the plane are NaN, which is shown in its own colour.
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

/// The values of `plane` along the line from `from` to `to`, both (u, v) in pixels of which `px_per_plane_px` make one
/// pixel of the plane (1: its own).
///
/// A sample is taken about every pixel of the plane, the first at `from`, the last at `to`; at least two. Ends that are
/// not finite give no samples.
pub fn profile(plane: &Plane, from: [f32; 2], to: [f32; 2], px_per_plane_px: f32) -> Vec<ProfileSample> {
    let (du, dv) = (to[0] - from[0], to[1] - from[1]);
    let length = du.hypot(dv);
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
    /// The standard deviation of white noise on a smooth picture, from neighbouring values; `None` in a region smaller
    /// than 3 × 3 pixels.
    pub noise: Option<f64>,
}

/// The statistics of the values of `region`, cut to the plane; `None` when it holds no finite value.
pub fn region_statistics(plane: &Plane, region: &Region) -> Option<RegionStatistics> {
    let region = region.within(plane);
    let summary = summary(plane, &region);
    let (min, max) = summary.range()?;
    let mut squares = 0.0;
    for v in region.rows.clone() {
        let row = &plane.row(v)[region.columns.clone()];
        squares += row.iter().filter(|x| x.is_finite()).map(|&x| (f64::from(x) - summary.mean).powi(2)).sum::<f64>();
    }
    let deviation = (squares / (summary.count.max(2) - 1) as f64).sqrt();
    let noise = region_noise(plane, &region);
    Some(RegionStatistics { count: summary.count, mean: summary.mean, deviation, min, max, noise })
}

/// The median of |x| of a normal distribution of standard deviation 1.
const MEDIAN_OF_NORMAL: f64 = 0.674_489_750_196_081_7;

/// The standard deviation of white noise in `region`, whatever smooth picture lies under it: the median of the absolute
/// second differences in both directions at once (J. Immerkær, "Fast noise variance estimation", 1996, whose mask this
/// is; the median in place of his mean leaves edges out).
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
    if answers.is_empty() {
        return None;
    }
    let middle = answers.len() / 2;
    let (_, median, _) = answers.select_nth_unstable_by(middle, f32::total_cmp);
    // The mask's weights have a sum of squares of 36.
    Some(f64::from(*median) / (6.0 * MEDIAN_OF_NORMAL))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ramp() -> Plane {
        Plane::from_fn(9, 6, |u, v| 2.0 * u as f32 - 0.5 * v as f32 + 1.0)
    }

    #[test]
    fn a_difference_is_taken_at_the_same_places_of_the_image() {
        let (fine, coarse) = (ramp(), Plane::from_fn(5, 3, |u, v| 4.0 * u as f32 - v as f32 + 1.0));
        assert!(difference(&fine, &fine, 1.0).data().iter().all(|x| *x == 0.0));
        // The coarse plane is the same ramp on every other pixel.
        assert!(difference(&coarse, &fine, 2.0).data().iter().all(|x| x.abs() < 1e-5));
        let back = difference(&fine, &coarse, 0.5);
        assert!(back.at(3, 2).abs() < 1e-5);
        let beside = difference(&fine, &Plane::zeros(4, 4), 1.0);
        assert!(beside.at(8, 5).is_nan() && !beside.at(3, 3).is_nan());
    }

    #[test]
    fn pixels_are_exact_and_edges_are_held() {
        let plane = ramp();
        assert_eq!(bilinear(&plane, 3.0, 2.0), Some(plane.at(3, 2)));
        assert_eq!(bilinear(&plane, -0.5, -0.5), Some(plane.at(0, 0)));
        assert_eq!(bilinear(&plane, 8.5, 5.5), Some(plane.at(8, 5)));
        for (u, v) in [(-0.51, 0.0), (0.0, 5.51), (f32::NAN, 0.0), (f32::INFINITY, 0.0)] {
            assert_eq!(bilinear(&plane, u, v), None);
        }
        assert_eq!(bilinear(&Plane::zeros(0, 3), 0.0, 0.0), None);
    }

    #[test]
    fn a_nan_beside_an_exact_position_does_not_spread() {
        let mut plane = ramp();
        plane.row_mut(2)[4] = f32::NAN;
        assert_eq!(bilinear(&plane, 3.0, 2.0), Some(plane.at(3, 2)));
        assert!(bilinear(&plane, 3.5, 2.0).unwrap().is_nan());
    }

    #[test]
    fn a_patch_at_whole_pixels_is_a_crop() {
        let plane = ramp();
        let patch = sample_patch(&plane, (4.0, 3.0), 1.5, 0.0, 3);
        for j in 0..3 {
            for i in 0..3 {
                assert!((patch.at(i, j) - plane.at(3 + i, 2 + j)).abs() < 1e-5);
            }
        }
        assert!(sample_patch(&plane, (0.0, 0.0), 3.0, 0.0, 5).at(0, 0).is_nan());
        // The right of a patch after a quarter turn is the plane's down.
        let turned = sample_patch(&plane, (4.0, 3.0), 1.5, std::f32::consts::FRAC_PI_2, 3);
        assert!((turned.at(2, 1) - plane.at(4, 4)).abs() < 1e-5);
    }

    proptest! {
        #[test]
        fn a_linear_picture_is_sampled_exactly(u in 0f32..8.0, v in 0f32..5.0) {
            let value = bilinear(&ramp(), u, v).unwrap();
            prop_assert!((value - (2.0 * u - 0.5 * v + 1.0)).abs() < 1e-4);
        }
    }

    #[test]
    fn a_profile_has_the_values_of_a_ramp_at_every_pixel() {
        let ramp = Plane::from_fn(20, 10, |u, v| u as f32 + 100.0 * v as f32);
        let samples = profile(&ramp, [2.0, 3.0], [12.0, 3.0], 1.0);
        assert_eq!(samples.len(), 11);
        for (i, s) in samples.iter().enumerate() {
            assert_eq!((s.distance_px, s.u, s.v, s.value), (i as f32, 2.0 + i as f32, 3.0, 302.0 + i as f32));
        }
        // The same place of an image on every other pixel.
        let half = Plane::from_fn(10, 5, |u, v| 2.0 * u as f32 + 200.0 * v as f32);
        let coarse = profile(&half, [2.0, 4.0], [12.0, 4.0], 2.0);
        assert_eq!((coarse.len(), coarse[5].value), (6, 412.0));
        assert!(profile(&ramp, [15.0, 5.0], [30.0, 5.0], 1.0).last().is_some_and(|s| s.value.is_nan()));
        assert!(profile(&ramp, [f32::NAN, 0.0], [1.0, 1.0], 1.0).is_empty());
    }

    #[test]
    fn the_noise_of_a_region_is_that_of_the_noise_and_not_of_what_lies_under_it() {
        let mut random = crate::synth::random::Stream::new(5, 0);
        let plane = Plane::from_fn(120, 90, |u, v| {
            let step = if u > 60 { 0.5 } else { 0.0 };
            0.003 * u as f32 + 0.002 * v as f32 + step + 0.02 * random.normal() as f32
        });
        let found = region_statistics(&plane, &Region { columns: 10..110, rows: 10..80 }).unwrap();
        assert_eq!(found.count, 100 * 70);
        assert!((found.noise.unwrap() / 0.02 - 1.0).abs() < 0.04, "{found:?}");
        assert!(found.deviation > 0.2 && f64::from(found.min) < found.mean && found.mean < f64::from(found.max));
        let narrow = region_statistics(&plane, &Region { columns: 3..5, rows: 3..9 }).unwrap();
        assert_eq!((narrow.count, narrow.noise), (12, None));
        assert_eq!(region_statistics(&plane, &Region { columns: 500..600, rows: 0..3 }), None);
    }

    proptest! {
        #[test]
        fn statistics_are_those_of_the_values(values in prop::collection::vec(-1f32..1.0, 1..80)) {
            let plane = Plane::from_vec(values.len(), 1, values.clone());
            let found = region_statistics(&plane, &Region::whole(&plane)).unwrap();
            let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
            prop_assert!((found.mean - mean).abs() < 1e-9);
            prop_assert!(found.deviation <= f64::from(found.max - found.min) + 1e-9);
        }
    }
}
