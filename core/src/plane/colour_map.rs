//! Colour maps: from a position in [0, 1] to a colour.
//!
//! All colour maps are defined here. The window, the exported pictures and the legends read the same tables. Perceptual
//! maps run from dark to light in even steps, so that equal differences in value look equally large. Diverging maps
//! have an exactly neutral grey at the centre and are meant for values with a sign, such as the DoG response.

use serde::{Deserialize, Serialize};

/// A colour as 8-bit sRGB: red, green, blue.
pub type Rgb = [u8; 3];

/// A named table of 256 colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
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
    BlueWhiteRed,
    /// Diverging: blue, black at the centre, orange. Easier on the eyes in a dark room.
    BlueBlackOrange,
    /// Diverging: purple, white at the centre, green.
    PurpleWhiteGreen,
}

impl ColourMap {
    /// All maps, in the order in which a picker lists them.
    pub const ALL: [Self; 8] = [
        Self::Grey,
        Self::Viridis,
        Self::Magma,
        Self::Cividis,
        Self::Turbo,
        Self::BlueWhiteRed,
        Self::BlueBlackOrange,
        Self::PurpleWhiteGreen,
    ];

    /// Name for the user, in sentence case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Grey => "Grey",
            Self::Viridis => "Viridis",
            Self::Magma => "Magma",
            Self::Cividis => "Cividis",
            Self::Turbo => "Turbo",
            Self::BlueWhiteRed => "Blue – white – red",
            Self::BlueBlackOrange => "Blue – black – orange",
            Self::PurpleWhiteGreen => "Purple – white – green",
        }
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

    /// The table. Entry 0 is the colour of the smallest value, entry 255 of the largest. A diverging map's entries 127
    /// and 128 are the same neutral grey, so that the exact centre is neutral.
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

    /// The colour at `t` in [0, 1], from which the table is made.
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

/// Reads a map of `colorous`.
fn gradient(gradient: colorous::Gradient, t: f64) -> Rgb {
    gradient.eval_continuous(t.clamp(0.0, 1.0)).into_array()
}

/// Makes the centre of a diverging map exactly grey: its small tint is taken off there, fading out towards the ends.
fn neutral_centre(map: impl Fn(f64) -> Rgb, t: f64) -> Rgb {
    let centre = map(0.5);
    let grey = (centre.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0).round();
    let nearness = 1.0 - (2.0 * t - 1.0).abs();
    let colour = map(t);
    std::array::from_fn(|c| {
        (f64::from(colour[c]) + nearness * (grey - f64::from(centre[c]))).round().clamp(0.0, 255.0) as u8
    })
}

/// A cyclic colour for a direction: the hue tells `angle_rad` (from +u towards +v), the saturation tells
/// `magnitude_fraction` in [0, 1].
///
/// Lightness is about the same all around, so no direction looks much stronger than another; magnitude 0 is a neutral
/// grey. Saturation grows faster at first (power 0.6), so that small motions can be told from none. The hues are those
/// of the OKLCH colour space (Ottosson 2020, "A perceptual color space for image processing").
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Approximate perceived lightness.
    fn luma(c: Rgb) -> f32 {
        0.2126 * f32::from(c[0]) + 0.7152 * f32::from(c[1]) + 0.0722 * f32::from(c[2])
    }

    #[test]
    fn perceptual_maps_grow_lighter_all_the_way() {
        for map in [ColourMap::Grey, ColourMap::Viridis, ColourMap::Magma, ColourMap::Cividis] {
            let lut = map.lut();
            for pair in lut.windows(2) {
                assert!(luma(pair[1]) > luma(pair[0]) - 0.6, "{map:?}: {pair:?}");
            }
            assert!(luma(lut[255]) - luma(lut[0]) > 150.0, "{map:?}");
        }
    }

    #[test]
    fn the_centre_of_a_diverging_map_is_exactly_neutral_and_its_sides_differ() {
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

    #[test]
    fn names_survive_toml_and_are_distinct() {
        #[derive(Serialize, Deserialize)]
        struct Holder {
            map: ColourMap,
        }
        let mut names = std::collections::HashSet::new();
        for map in ColourMap::ALL {
            assert!(names.insert(map.name()));
            let text = toml::to_string(&Holder { map }).unwrap();
            assert_eq!(toml::from_str::<Holder>(&text).unwrap().map, map);
        }
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
}
