//! Colours of values: ranges, maps, and their lightness.

use crate::prelude::*;
use burstscope_core::plane::display::*;

#[test]
fn grey_is_rounded_zero_neutral_in_a_symmetric_display_and_rgba_the_colour_of_every_pixel() {
    let display = Display::default();
    (0..=255u8).for_each(|i| assert_eq!(display.colour(f32::from(i) / 255.0), [i; 3]));
    assert_eq!(display.colour(-1.0), [0; 3]);
    assert_eq!(display.colour(f32::INFINITY), [255; 3]);
    assert_eq!(display.colour(f32::NAN), NAN_COLOUR);
    for gamma in [0.5, 1.0, 2.0] {
        let display = Display { gamma, ..Display::symmetric(0.02) };
        let zero = display.colour(0.0);
        assert!(zero.iter().all(|&c| c == zero[0]));
        let (low, high) = (display.position(-0.01).unwrap(), display.position(0.01).unwrap());
        assert!((low + high - 1.0).abs() < 1e-6);
    }
    assert_eq!(Display::symmetric(0.1).with_range(-0.3, 0.2).max, 0.3);
    let plane = Plane::from_fn(7, 3, |u, v| (u + 7 * v) as f32 / 20.0);
    let display = Display { map: ColourMap::Viridis, gamma: 1.7, ..Display::default() };
    let image = to_rgba8(&plane, &display);
    for (u, v, pixel) in image.enumerate_pixels() {
        let [r, g, b] = display.colour(plane.at(u as usize, v as usize));
        assert_eq!(pixel.0, [r, g, b, 255]);
    }
    assert_eq!(to_rgba8(&Plane::zeros(0, 4), &display).dimensions(), (0, 4));
}

proptest! {
    #[test]
    fn anything_read_from_a_file_becomes_a_usable_display(
        min in any::<f32>(), max in any::<f32>(), gamma in any::<f32>(), symmetric in any::<bool>(), value in any::<f32>()
    ) {
        let display = Display { min, max, gamma, symmetric, map: ColourMap::Grey }.sanitised();
        prop_assert!(display.min < display.max, "{display:?}");
        prop_assert!(display.min.is_finite() && display.max.is_finite());
        prop_assert!(!symmetric || display.min == -display.max);
        if let Some(t) = display.position(value) {
            prop_assert!((0.0..=1.0).contains(&t), "{t}");
        } else {
            prop_assert!(value.is_nan());
        }
    }

    #[test]
    fn larger_values_lie_later_in_the_map(a in -1f32..2.0, b in -1f32..2.0, gamma in 0.2f32..5.0) {
        for display in [Display { gamma, ..Display::default() }, Display { gamma, ..Display::symmetric(0.7) }] {
            let (low, high) = (a.min(b), a.max(b));
            prop_assert!(display.position(low).unwrap() <= display.position(high).unwrap() + 1e-6);
        }
    for map in ColourMap::ALL.into_iter().filter(|m| m.is_diverging()) {
        let lut = map.lut();
        assert_eq!(lut[127], lut[128], "{map:?}");
        assert!(lut[127].iter().all(|&c| c == lut[127][0]), "{map:?}: {:?}", lut[127]);
        for d in 20..128 {
            assert_ne!(lut[127 - d], lut[128 + d], "{map:?}");
            // The two sides are about equally light, so that neither sign looks stronger.
            assert!((luma(lut[127 - d]) - luma(lut[128 + d])).abs() < 40.0, "{map:?} at ±{d}");
        }
    }
    }
}

fn luma(c: Rgb) -> f32 {
    0.2126 * f32::from(c[0]) + 0.7152 * f32::from(c[1]) + 0.0722 * f32::from(c[2])
}

#[test]
fn directions_are_cyclic_even_in_lightness_and_grey_without_motion() {
    use std::f32::consts::{PI, TAU};
    assert_eq!(direction_colour(-PI, 1.0), direction_colour(PI, 1.0));
    let still = direction_colour(1.0, 0.0);
    assert!(still.iter().max().unwrap() - still.iter().min().unwrap() <= 1, "{still:?}");
    assert_eq!(direction_colour(f32::NAN, 1.0), direction_colour(0.0, 0.0));
    for i in 0..36 {
        let a = direction_colour(i as f32 * TAU / 36.0, 1.0);
        let b = direction_colour((i + 9) as f32 * TAU / 36.0, 1.0);
        assert!((luma(a) - luma(still)).abs() < 30.0, "{a:?} against {still:?}");
        let difference: i32 = (0..3).map(|c| (i32::from(a[c]) - i32::from(b[c])).abs()).sum();
        assert!(difference > 60, "a quarter turn must be visible: {a:?} {b:?}");
    }
}
