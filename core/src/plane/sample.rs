//! Values between the pixels.
//!
//! Positions are in pixels of the plane; the centre of the first pixel is (0, 0). A plane covers what its pixels cover:
//! from −0.5 to width − 0.5. Between the outermost centres and that edge the value is the nearest pixel's.

use super::Plane;

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

/// A square patch of `size × size` samples around `centre` = (u, v), reaching `half_width_px` pixels to each side,
/// upright.
///
/// Sample (i, j) is the value at `centre + half_width_px·((2i + 1)/size − 1, (2j + 1)/size − 1)`: the samples are the
/// centres of `size²` equal squares. Samples outside the plane are NaN, which is shown in its own colour.
pub fn sample_patch(plane: &Plane, centre: (f32, f32), half_width_px: f32, size: usize) -> Plane {
    sample_patch_turned(plane, centre, half_width_px, 0.0, size)
}

/// Like [`sample_patch`], but the patch's own horizontal axis points along `angle_rad` (from +u towards +v): what a
/// descriptor with that orientation sees.
pub fn sample_patch_turned(
    plane: &Plane,
    centre: (f32, f32),
    half_width_px: f32,
    angle_rad: f32,
    size: usize,
) -> Plane {
    let (sin, cos) = angle_rad.sin_cos();
    let offset = |i: usize| half_width_px * ((2 * i + 1) as f32 / size as f32 - 1.0);
    Plane::from_fn(size, size, |i, j| {
        let (x, y) = (offset(i), offset(j));
        bilinear(plane, centre.0 + cos * x - sin * y, centre.1 + sin * x + cos * y).unwrap_or(f32::NAN)
    })
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
        let patch = sample_patch(&plane, (4.0, 3.0), 1.5, 3);
        for j in 0..3 {
            for i in 0..3 {
                assert!((patch.at(i, j) - plane.at(3 + i, 2 + j)).abs() < 1e-5);
            }
        }
        assert!(sample_patch(&plane, (0.0, 0.0), 3.0, 5).at(0, 0).is_nan());
    }

    #[test]
    fn a_quarter_turn_moves_the_patch_axis_from_u_to_v() {
        let plane = ramp();
        let patch = sample_patch_turned(&plane, (4.0, 3.0), 1.5, std::f32::consts::FRAC_PI_2, 3);
        // The patch's right is the plane's down.
        assert!((patch.at(2, 1) - plane.at(4, 4)).abs() < 1e-5);
    }

    proptest! {
        #[test]
        fn a_linear_picture_is_sampled_exactly(u in 0f32..8.0, v in 0f32..5.0) {
            let value = bilinear(&ramp(), u, v).unwrap();
            prop_assert!((value - (2.0 * u - 0.5 * v + 1.0)).abs() < 1e-4);
        }
    }
}
