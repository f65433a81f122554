//! Mapping of values to colours: range, gamma and colour map.
//!
//! [`Display::colour`] is the reference, which exported pictures use; a test compares the shader with it.
//!
//! The window, the exported pictures and the legends read the same tables. Perceptual maps run from dark to light in
//! even steps; diverging ones have an exactly neutral grey at the centre, for values with a sign.

use super::Plane;
use super::statistics::{Region, percentiles};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use strum::{EnumCount, IntoStaticStr, VariantArray};

/// Colour of a value that is not a number. No sequential or diverging map contains it.
pub const NAN_COLOUR: Rgb = [255, 0, 255];

/// Gammas that [`Display::sanitised`] allows.
pub const GAMMA_RANGE: std::ops::RangeInclusive<f32> = 0.1..=10.0;

/// Mapping of values to colours.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Display {
    /// Value shown with the map's first colour, as all smaller ones, in the picture's unit (fraction of full scale).
    pub min: f32,
    /// Value shown with the map's last colour, as all larger ones.
    pub max: f32,
    /// Exponent 1/gamma of the position in the range: values above 1 brighten the dark half. With a diverging map it
    /// applies to the distance from the centre, so that both signs are treated alike.
    pub gamma: f32,
    /// Colour map, diverging for values with a sign.
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

    /// This display with another range. A symmetric one takes ± the larger magnitude. An empty or non-finite range
    /// becomes a small one around `min` (or 0), so that a display is always usable.
    #[must_use]
    pub fn with_range(self, min: f32, max: f32) -> Self {
        let min = if min.is_finite() { min } else { 0.0 };
        let max = if max.is_finite() { max } else { min };
        // Less than any step of the files read here, yet well above f32's resolution near 1.
        let smallest = |at: f32| 5e-7_f32.max(at.abs() * 1e-6);
        if self.symmetric {
            let limit = min.abs().max(max.abs()).max(smallest(0.0));
            Self { min: -limit, max: limit, ..self }
        } else {
            Self { min, max: max.max(min + smallest(min)), ..self }
        }
    }

    /// This display from one percentile to another (0 … 100) of the plane's finite values; as it is without any.
    #[must_use]
    pub fn over_percentiles(self, plane: &Plane, percents: [f32; 2]) -> Self {
        match percentiles(plane, &Region::whole(plane), &percents).as_deref() {
            Some([min, max]) => self.with_range(*min, *max),
            _ => self,
        }
    }

    /// Grey display in which all but the outermost thousandths of the plane's values differ.
    pub fn stretched(plane: &Plane) -> Self {
        Self::default().over_percentiles(plane, [0.1, 99.9])
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

    /// Colour of `value`. Builds the map's table each time; for many values use [`Display::colours`].
    pub fn colour(&self, value: f32) -> Rgb {
        self.colours().colour(value)
    }

    /// Display with its colour table, for many values.
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
    /// Colour of `value`: linear between the table's entries.
    pub fn colour(&self, value: f32) -> Rgb {
        let Some(position) = self.display.position(value) else { return NAN_COLOUR };
        let x = position * 255.0;
        let i = (x as usize).min(254);
        let f = x - i as f32;
        let (a, b) = (self.lut[i], self.lut[i + 1]);
        std::array::from_fn(|c| (f32::from(a[c]) + f * (f32::from(b[c]) - f32::from(a[c])) + 0.5) as u8)
    }
}

/// Picture as displayed: one opaque RGBA pixel for each value.
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

/// Colour as 8-bit sRGB: red, green, blue.
pub type Rgb = [u8; 3];

/// Named table of 256 colours, sequential or diverging.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, EnumCount, VariantArray, IntoStaticStr,
)]
#[serde(rename_all = "snake_case")]
pub enum ColourMap {
    /// Black to white.
    #[default]
    Grey,
    /// Dark blue over green to yellow.
    Viridis,
    /// Black over purple to pale yellow.
    Magma,
    /// Blue to yellow; looks the same to people with and without a colour vision deficiency.
    Cividis,
    /// A rainbow with many distinct hues; shows fine differences, but is not even in lightness.
    Turbo,
    /// Diverging: blue, white at the centre, red.
    #[strum(serialize = "Blue – white – red")]
    BlueWhiteRed,
    /// Diverging: blue, black at the centre, orange. Easier on the eyes in a dark room.
    #[strum(serialize = "Blue – black – orange")]
    BlueBlackOrange,
    /// Diverging: purple, white at the centre, green.
    #[strum(serialize = "Purple – white – green")]
    PurpleWhiteGreen,
}

impl ColourMap {
    /// All maps, in the order in which a picker lists them.
    pub const ALL: [Self; Self::COUNT] = *Self::VARIANTS.first_chunk().expect("as many");

    /// Name for the user, in sentence case.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Use of the map, in one sentence.
    pub fn help(self) -> &'static str {
        match self {
            Self::Grey => "The plain picture.",
            Self::Viridis => "Perceptually even, readable with most colour vision deficiencies.",
            Self::Magma => "Perceptually even, with a black that stays black.",
            Self::Cividis => "Perceptually even and made for colour-blind eyes.",
            Self::Turbo => "Many hues for fine differences; not even in lightness.",
            Self::BlueWhiteRed => "For values with a sign: negative blue, zero white, positive red.",
            Self::BlueBlackOrange => {
                "For values with a sign on a dark screen: negative blue, zero black, positive orange."
            }
            Self::PurpleWhiteGreen => "For values with a sign: negative purple, zero white, positive green.",
        }
    }

    /// Whether the map has a neutral centre, for values with a sign.
    pub fn is_diverging(self) -> bool {
        matches!(self, Self::BlueWhiteRed | Self::BlueBlackOrange | Self::PurpleWhiteGreen)
    }

    /// Table from the smallest value to the largest. Entries 127 and 128 of a diverging map are the same neutral grey.
    pub fn lut(self) -> [Rgb; 256] {
        std::array::from_fn(|i| {
            let t = if self.is_diverging() {
                // Two halves of 128 entries that both end at the centre.
                if i < 128 { 0.5 * i as f64 / 127.0 } else { 0.5 + 0.5 * (i - 128) as f64 / 127.0 }
            } else {
                i as f64 / 255.0
            };
            self.eval(t)
        })
    }

    fn eval(self, t: f64) -> Rgb {
        match self {
            Self::Grey => [(t * 255.0).round() as u8; 3],
            Self::Viridis => gradient(colorous::VIRIDIS, t),
            Self::Magma => gradient(colorous::MAGMA, t),
            Self::Cividis => gradient(colorous::CIVIDIS, t),
            Self::Turbo => gradient(colorous::TURBO, t),
            Self::BlueWhiteRed => neutral_centre(|t| gradient(colorous::RED_BLUE, 1.0 - t), t),
            Self::PurpleWhiteGreen => neutral_centre(|t| gradient(colorous::PURPLE_GREEN, t), t),
            Self::BlueBlackOrange => {
                // Black to a saturated hue, then on to a light tint: lightness grows evenly away from the centre.
                const BLUE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [20.0, 108.0, 190.0], [160.0, 220.0, 255.0]];
                const ORANGE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [196.0, 88.0, 10.0], [255.0, 214.0, 150.0]];
                let (side, distance) = if t < 0.5 { (BLUE, 1.0 - 2.0 * t) } else { (ORANGE, 2.0 * t - 1.0) };
                let (a, b, f) = if distance < 0.5 {
                    (side[0], side[1], 2.0 * distance)
                } else {
                    (side[1], side[2], 2.0 * distance - 1.0)
                };
                std::array::from_fn(|c| (a[c] + f * (b[c] - a[c])).round() as u8)
            }
        }
    }
}

fn gradient(gradient: colorous::Gradient, t: f64) -> Rgb {
    gradient.eval_continuous(t.clamp(0.0, 1.0)).into_array()
}

/// Makes the centre of a diverging map exactly grey: the small tint there is taken off, fading out towards the ends.
fn neutral_centre(map: impl Fn(f64) -> Rgb, t: f64) -> Rgb {
    let centre = map(0.5);
    let grey = (centre.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0).round();
    let nearness = 1.0 - (2.0 * t - 1.0).abs();
    let colour = map(t);
    std::array::from_fn(|c| {
        (f64::from(colour[c]) + nearness * (grey - f64::from(centre[c]))).round().clamp(0.0, 255.0) as u8
    })
}

/// Cyclic colour for a direction: the hue shows `angle_rad` (from +u towards +v), the saturation `magnitude_fraction`
/// in [0, 1], at first faster (power 0.6), at about equal lightness. Hues are those of the OKLCH colour space (Ottosson
/// 2020, "A perceptual color space for image processing").
pub fn direction_colour(angle_rad: f32, magnitude_fraction: f32) -> Rgb {
    const LIGHTNESS: f32 = 0.75;
    // A little beyond what sRGB holds for every hue: cyan is clamped, the others gain.
    const CHROMA: f32 = 0.165;
    const HUE_OF_RIGHT_RAD: f32 = 0.5;
    let fraction = if magnitude_fraction.is_finite() { magnitude_fraction.clamp(0.0, 1.0).powf(0.6) } else { 0.0 };
    let (angle_rad, chroma) = if angle_rad.is_finite() { (angle_rad, CHROMA * fraction) } else { (0.0, 0.0) };
    let hue = angle_rad + HUE_OF_RIGHT_RAD;
    oklab_to_srgb(LIGHTNESS, chroma * hue.cos(), chroma * hue.sin())
}

/// OKLab to 8-bit sRGB; values outside are clamped.
fn oklab_to_srgb(lightness: f32, a: f32, b: f32) -> Rgb {
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    let linear = [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ];
    linear.map(|x| {
        let x = x.clamp(0.0, 1.0);
        let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    })
}
