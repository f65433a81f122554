//! Mapping of values to colours: range, gamma and colour map.
//!
//! [`Display::colour`] is the reference. The shader computes the same, and a test compares the two; exported pictures
//! and thumbnails use this one.

use super::Plane;
use super::colour_map::{ColourMap, Rgb};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Colour of a value that is not a number. No sequential or diverging map contains it.
pub const NAN_COLOUR: Rgb = [255, 0, 255];

/// Gammas that [`Display::sanitised`] allows.
pub const GAMMA_RANGE: std::ops::RangeInclusive<f32> = 0.1..=10.0;

/// Mapping of values to colours.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Display {
    /// Value shown with the map's first colour, in the picture's unit (fraction of full scale). Smaller values get the
    /// same colour.
    pub min: f32,
    /// Value shown with the map's last colour. Larger values get the same colour.
    pub max: f32,
    /// Exponent's inverse: the position in the range is raised to the power 1/gamma, so that values above 1 brighten
    /// the dark half. With a diverging map it applies to the distance from the centre, so that both signs are treated
    /// alike.
    pub gamma: f32,
    /// Colour map.
    pub map: ColourMap,
    /// Whether the range is kept symmetric about zero, for pictures whose values have a sign.
    pub symmetric: bool,
}

impl Default for Display {
    /// The full range [0, 1] in grey.
    fn default() -> Self {
        Self { min: 0.0, max: 1.0, gamma: 1.0, map: ColourMap::Grey, symmetric: false }
    }
}

impl Display {
    /// Display of values with a sign: ±`limit` with a diverging map.
    pub fn symmetric(limit: f32) -> Self {
        Self { min: -limit, max: limit, gamma: 1.0, map: ColourMap::BlueWhiteRed, symmetric: true }
    }

    /// This display with another range. A symmetric one takes ± the larger of the two magnitudes. An empty or
    /// non-finite range becomes a small one around `min` (or 0), so that a display is always usable.
    #[must_use]
    pub fn with_range(self, min: f32, max: f32) -> Self {
        let min = if min.is_finite() { min } else { 0.0 };
        let max = if max.is_finite() { max } else { min };
        // Half a millionth of full scale is less than any step of the files read here, yet well above f32's resolution
        // near 1.
        let smallest = |at: f32| 5e-7_f32.max(at.abs() * 1e-6);
        if self.symmetric {
            let limit = min.abs().max(max.abs()).max(smallest(0.0));
            Self { min: -limit, max: limit, ..self }
        } else {
            Self { min, max: max.max(min + smallest(min)), ..self }
        }
    }

    /// This display with all values in their allowed ranges, since a file may hold anything.
    #[must_use]
    pub fn sanitised(self) -> Self {
        let gamma =
            if self.gamma.is_finite() { self.gamma.clamp(*GAMMA_RANGE.start(), *GAMMA_RANGE.end()) } else { 1.0 };
        Self { gamma, ..self }.with_range(self.min, self.max)
    }

    /// Position of `value` in the colour map, in [0, 1], after gamma; `None` for a value that is not a number.
    pub fn position(&self, value: f32) -> Option<f32> {
        if value.is_nan() {
            return None;
        }
        let t = ((value - self.min) / (self.max - self.min)).clamp(0.0, 1.0);
        // An infinite value over an infinite range cannot come from a sanitised display; 0 is a safe result.
        let t = if t.is_nan() { 0.0 } else { t };
        let exponent = 1.0 / self.gamma;
        Some(if self.map.is_diverging() {
            let signed = 2.0 * t - 1.0;
            0.5 + 0.5 * signed.abs().powf(exponent).copysign(signed)
        } else {
            t.powf(exponent)
        })
    }

    /// The colour of `value`. Builds the map's table each time; for many values use [`Display::colours`].
    pub fn colour(&self, value: f32) -> Rgb {
        self.colours().colour(value)
    }

    /// The display with its colour table, for many values.
    pub fn colours(&self) -> Colours {
        Colours { display: *self, lut: self.map.lut() }
    }
}

/// A [`Display`] with its map's table: fast for many values.
#[derive(Debug, Clone)]
pub struct Colours {
    display: Display,
    lut: [Rgb; 256],
}

impl Colours {
    /// The colour of `value`: linear between the table's entries.
    pub fn colour(&self, value: f32) -> Rgb {
        let Some(position) = self.display.position(value) else { return NAN_COLOUR };
        let x = position * 255.0;
        let i = (x as usize).min(254);
        let f = x - i as f32;
        let (a, b) = (self.lut[i], self.lut[i + 1]);
        std::array::from_fn(|c| (f32::from(a[c]) + f * (f32::from(b[c]) - f32::from(a[c])) + 0.5) as u8)
    }
}

/// The picture as displayed: one opaque RGBA pixel for each value.
pub fn to_rgba8(plane: &Plane, display: &Display) -> image::RgbaImage {
    let colours = display.colours();
    let width = plane.width();
    let mut bytes: Vec<u8> = super::memory::zeroed(width * plane.height() * 4);
    if width > 0 {
        bytes.par_chunks_mut(width * 4).zip(plane.data().par_chunks(width)).for_each(|(out, row)| {
            for (pixel, &value) in out.chunks_exact_mut(4).zip(row) {
                let [r, g, b] = colours.colour(value);
                pixel.copy_from_slice(&[r, g, b, 255]);
            }
        });
    }
    image::RgbaImage::from_raw(width as u32, plane.height() as u32, bytes)
        .expect("the buffer was made with four bytes for each pixel")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn grey_is_the_rounded_value() {
        let display = Display::default();
        for i in 0..=255u8 {
            assert_eq!(display.colour(f32::from(i) / 255.0), [i; 3]);
        }
        assert_eq!(display.colour(-1.0), [0; 3]);
        assert_eq!(display.colour(f32::INFINITY), [255; 3]);
        assert_eq!(display.colour(f32::NAN), NAN_COLOUR);
    }

    #[test]
    fn gamma_brightens_dark_values_and_keeps_the_ends() {
        let plain = Display::default();
        let bright = Display { gamma: 2.2, ..plain };
        assert!(bright.colour(0.1)[0] > plain.colour(0.1)[0]);
        assert_eq!((bright.colour(0.0), bright.colour(1.0)), ([0; 3], [255; 3]));
    }

    #[test]
    fn zero_is_neutral_and_signs_are_alike_in_a_symmetric_display() {
        for gamma in [0.5, 1.0, 2.0] {
            let display = Display { gamma, ..Display::symmetric(0.02) };
            let zero = display.colour(0.0);
            assert!(zero.iter().all(|&c| c == zero[0]));
            let (low, high) = (display.position(-0.01).unwrap(), display.position(0.01).unwrap());
            assert!((low + high - 1.0).abs() < 1e-6);
        }
        assert_eq!(Display::symmetric(0.1).with_range(-0.3, 0.2).max, 0.3);
    }

    #[test]
    fn rgba_is_the_colour_of_every_pixel() {
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
        }
    }
}
