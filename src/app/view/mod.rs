//! How pictures and features are seen, as plain values: pan and zoom, quantities of features, numbers for people.

mod pan_zoom;

pub use pan_zoom::{MAX_POINTS_PER_PIXEL, RectTransform, View, Zoom};

use crate::detector::quantity::{BRIGHT, Colours, Form, WARM};
use crate::detector::{Feature, MotionLayer, Quantity, Slope};
use crate::inspect::{place::Judged, words};
use serde::{Deserialize, Serialize};

/// Motion or quantity that the colours of features show: each quantity whose record has colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(into = "&'static str", try_from = "String")]
pub enum ColourBy {
    #[default]
    SlopeDirection,
    /// Length of its motion: of a camera that moves before a still scene, what is near is fast.
    Speed,
    Of(Quantity),
}

impl From<ColourBy> for &'static str {
    fn from(by: ColourBy) -> Self {
        match by {
            ColourBy::SlopeDirection => "slope_direction",
            ColourBy::Speed => "speed",
            ColourBy::Of(Quantity::Sigma) => "scale",
            ColourBy::Of(Quantity::AtSlopeLimit) => "limit",
            ColourBy::Of(Quantity::Moves) => "moves",
            ColourBy::Of(quantity) => quantity.record().key,
        }
    }
}

impl TryFrom<String> for ColourBy {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let words: Vec<&str> = Self::all().map(Into::into).collect();
        let by = Self::all().find(|by| word == <&str>::from(*by));
        by.ok_or_else(|| format!("unknown variant `{word}`, expected one of `{}`", words.join("`, `")))
    }
}

impl ColourBy {
    pub fn all() -> impl Iterator<Item = Self> {
        let quantities = Quantity::ALL.into_iter().filter(|quantity| quantity.record().colours.is_some());
        [Self::SlopeDirection, Self::Speed].into_iter().chain(quantities.map(Self::Of))
    }

    /// The choices, in the order of a picker; depths only where slopes are read as depths.
    pub fn choices(with_depths: bool) -> impl Iterator<Item = Self> {
        Self::all().filter(move |by| with_depths || *by != Self::Of(Quantity::Depth))
    }

    pub fn quantity(self) -> Option<Quantity> {
        if let Self::Of(quantity) = self { Some(quantity) } else { None }
    }

    pub fn is_of_slope(self) -> bool {
        use Quantity::{AtSlopeLimit, SlopeSigma, SlopeU, SlopeV};
        self.quantity().is_none_or(|quantity| matches!(quantity, SlopeU | SlopeV | SlopeSigma | AtSlopeLimit))
    }

    pub fn name(self) -> &'static str {
        let motion = if self == Self::Speed { "Speed" } else { "Slope" };
        self.quantity().map_or(motion, |quantity| quantity.record().title)
    }

    pub fn unit(self) -> &'static str {
        self.quantity().unwrap_or(Quantity::SlopeU).record().unit
    }

    pub fn colours(self) -> Colours {
        let of_motion = if self == Self::Speed { Colours { is_log: false, ..WARM } } else { BRIGHT };
        self.quantity().and_then(|quantity| quantity.record().colours).unwrap_or(of_motion)
    }
}

#[derive(Debug, Clone, Copy, Default)]
pub struct KnownOfFeature<'a> {
    /// Coherence and verdict, once they were computed.
    pub judged: Option<&'a Judged>,
    /// Depth and its standard deviation, metres; `None` without a set-up, or where no depth explains the motion.
    pub depth_m: Option<[f64; 2]>,
}

/// The quantities that tables show; depths only where slopes are read as depths.
pub fn shown_quantities(with_depths: bool) -> impl Iterator<Item = Quantity> {
    Quantity::ALL.into_iter().filter(move |quantity| with_depths || *quantity != Quantity::Depth)
}

/// The value of `quantity` of the feature at `index`, by which tables sort; `None` while it is not known.
pub fn quantity_value(quantity: Quantity, index: usize, feature: &Feature, known: KnownOfFeature<'_>) -> Option<f32> {
    match quantity {
        Quantity::Rank => Some(index as f32),
        Quantity::Depth => known.depth_m.map(|[metres, _]| metres as f32),
        Quantity::Coherence => known.judged.and_then(|judged| judged.coherence),
        Quantity::Verdict => known.judged.map(|judged| judged.verdict as u8 as f32),
        Quantity::FieldSigma => quantity.of(feature),
        stored => stored.of(feature).filter(|_| !stored.is_empty(feature)),
    }
}

pub fn quantity_text(quantity: Quantity, index: usize, feature: &Feature, known: KnownOfFeature<'_>) -> String {
    match (quantity, known.judged) {
        // Not computed yet, unlike a value that a feature does not have.
        (Quantity::Coherence | Quantity::Verdict, None) => return "…".to_owned(),
        (Quantity::Verdict, Some(judged)) => return judged.verdict.word().to_owned(),
        (Quantity::Moves, _) => return feature.moves.words().to_owned(),
        _ => {}
    }
    let record = quantity.record();
    let Some(x) = quantity_value(quantity, index, feature, known) else { return record.unknown.to_owned() };
    match record.form {
        Form::Whole => format!("{x:.0}"),
        Form::Fixed(decimals) => fixed(x, decimals),
        Form::Signed(decimals) => signed(x, decimals),
        Form::Digits(digits) => number(x, digits),
        Form::SignedDigits(digits) => signed_number(x, digits),
        Form::Degrees => format!("{}°", fixed(x.to_degrees(), 0)),
        Form::Flag => if x > 0.0 { "yes" } else { "" }.to_owned(),
    }
}

/// A motion and its standard deviation for people: `+2.10, 0.00 ± 0.41 px/frame`.
pub fn motion_text(slope: Slope, sigma: f32, decimals: usize) -> String {
    format!("{} ± {} px/frame", signed_slope(slope, decimals), fixed(sigma, 2))
}

/// A depth and its standard deviation for people: `2.31 ± 0.12 m`.
pub fn depth_text([metres, sigma]: [f64; 2]) -> String {
    format!("{} ± {} m", number(metres as f32, 3), number(sigma as f32, 2))
}

/// Name of the motion layer `number`, from 1: `1: (2.10, 0.00) px/frame, 38 %`; of movers with `, moves by itself`.
pub fn layer_text(number: i32, layer: &MotionLayer) -> String {
    let [u, v] = [layer.slope.u, layer.slope.v].map(|part| fixed(part, 2));
    let moves = if layer.inverse_depth.is_none() { ", moves by itself" } else { "" };
    format!("{number}: ({u}, {v}) px/frame, {} %{moves}", fixed(100.0 * layer.share, 0))
}

/// The item with the smallest of the distances, of which none beyond `reach` counts.
pub fn nearest<T>(items: impl IntoIterator<Item = (f32, T)>, reach: f32) -> Option<T> {
    let near = items.into_iter().filter(|(distance, _)| *distance <= reach);
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, item)| item)
}

/// Formats a number with `digits` significant digits, without trailing zeros: `0.0123`, `1234`, `−3.2e−7`, `NaN`.
pub fn number(value: f32, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return with_minus(value.to_string()).replace("inf", "∞");
    }
    let magnitude = value.abs().log10().floor() as i32;
    // From 0.0001 to ten million in plain digits: beyond, zeros would hide the size.
    if (-4..7).contains(&magnitude) {
        return words::number(value, (digits as i32 - 1 - magnitude).max(0) as usize);
    }
    let rounded = format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(f64::from(value));
    format!("{rounded:e}").replace('-', "−")
}

pub fn signed_number(value: f32, digits: usize) -> String {
    let text = number(value, digits);
    if value > 0.0 { format!("+{text}") } else { text }
}

/// Formats with `decimals` decimals; a number that rounds to zero has no minus.
pub fn fixed(value: f32, decimals: usize) -> String {
    with_minus(format!("{value:.decimals$}"))
}

/// Formats as [`fixed`] does, with a `+` before positive numbers; zero has no sign.
pub fn signed(value: f32, decimals: usize) -> String {
    let text = format!("{value:+.decimals$}");
    let is_zero = !text.contains(|c: char| ('1'..='9').contains(&c)) && value.is_finite();
    if is_zero { text.trim_start_matches(['+', '-']).to_owned() } else { with_minus(text) }
}

pub fn signed_slope(slope: Slope, decimals: usize) -> String {
    format!("{}, {}", signed(slope.u, decimals), signed(slope.v, decimals))
}

/// A number as it is shown: with a minus sign for a hyphen, and none before what was rounded to zero.
pub fn with_minus(text: String) -> String {
    let is_zero = !text.contains(|c: char| ('1'..='9').contains(&c)) && text.contains('0');
    if is_zero { text.trim_start_matches(['-', '−']).to_owned() } else { text.replace('-', "−") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_rounds_to_zero_has_no_minus() {
        let cases = [("-0.00", "0.00"), ("−0", "0"), ("-0.01", "−0.01"), ("+0.00", "+0.00"), ("−∞", "−∞"), ("–", "–")];
        for (text, wanted) in cases {
            assert_eq!(with_minus(text.to_owned()), wanted);
        }
        assert_eq!([fixed(-0.004, 2), fixed(-0.006, 2), fixed(0.0, 1)], ["0.00", "−0.01", "0.0"]);
        assert_eq!([signed(-0.004, 2), signed(-0.0, 1), signed(2.5, 1)], ["0.00", "0.0", "+2.5"]);
        assert_eq!(signed_slope(Slope::new(-0.001, -1.5), 2), "0.00, −1.50");
        let mut style = egui::Style::default();
        crate::app::style::numbers(&mut style);
        assert_eq!(style.number_formatter.format(-0.001, 2..=2), "0.00");
        assert_eq!(style.number_formatter.format(-0.25, 2..=2), "−0.25");
    }

    #[test]
    fn an_unknown_field_and_no_layer_are_not_nought() {
        let known = Feature { field: Slope::new(-0.5, 0.0), field_sigma: 0.1, layer: 2, ..Feature::default() };
        let unknown = Feature { field_sigma: f32::INFINITY, layer: 0, ..known };
        let text = |quantity, feature| quantity_text(quantity, 0, feature, KnownOfFeature::default());
        for (quantity, value) in [(Quantity::FieldU, "−0.50"), (Quantity::FieldV, "0.00"), (Quantity::Layer, "2")] {
            assert_eq!([&known, &unknown].map(|feature| text(quantity, feature)), [value, "–"], "{quantity:?}");
        }
        assert_eq!(motion_text(known.field, 0.414, 2), "−0.50, 0.00 ± 0.41 px/frame");
        let layer = MotionLayer { slope: Slope::new(2.1, -0.001), spread: 0.1, share: 0.384, inverse_depth: Some(1.0) };
        assert_eq!(layer_text(1, &layer), "1: (2.10, 0.00) px/frame, 38 %");
        assert_eq!(depth_text([8.0, 0.8]), "8 ± 0.8 m");
    }

    #[test]
    fn numbers_as_people_read_them() {
        let values = [0.0, 0.0123456, 1.0, 1234.5678, 65535.0, -0.25, 3.2e-7, f32::NAN, f32::NEG_INFINITY];
        let texts = ["0", "0.01235", "1", "1235", "65535", "−0.25", "3.2e−7", "NaN", "−∞"];
        assert_eq!(values.map(|value| number(value, 4)), texts);
        // Faint responses of dark bursts keep their digits.
        for (value, text) in [(0.000_012_3, "+1.23e−5"), (-0.000_123_4, "−0.000123"), (0.0, "0"), (0.5, "+0.5")] {
            assert_eq!(signed_number(value, 3), text);
        }
    }
}
