//! How pictures and features are seen, as plain values: pan and zoom ([`View`]), transforms between coordinate systems,
//! the quantity that colours show, and numbers as people read them. The project keeps these values, the canvas draws by
//! them.

mod pan_zoom;

pub use pan_zoom::{MAX_POINTS_PER_PIXEL, RectTransform, View, Zoom};

use crate::detector::Slope;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ColourBy {
    #[default]
    SlopeDirection,
    SlopeU,
    SlopeV,
    Scale,
    /// The DoG value with its sign: bright blobs are negative.
    Response,
    Snr,
    Limit,
    /// Evenness of the frames' responses along its motion, 0 … 1; known once it was computed.
    Coherence,
    Depth,
}

impl ColourBy {
    pub const ALL: [Self; 9] = {
        use ColourBy::*;
        [SlopeDirection, SlopeU, SlopeV, Scale, Response, Snr, Limit, Coherence, Depth]
    };

    /// The choices, in the order of a picker; depths only where slopes are read as depths.
    pub fn choices(with_depths: bool) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |by| with_depths || *by != Self::Depth)
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::SlopeDirection => "Slope",
            Self::SlopeU => "Slope u",
            Self::SlopeV => "Slope v",
            Self::Scale => "Scale",
            Self::Response => "Response",
            Self::Snr => "SNR",
            Self::Limit => "Slope limit",
            Self::Coherence => "Coherence",
            Self::Depth => "Depth",
        }
    }

    pub fn unit(self) -> &'static str {
        match self {
            Self::SlopeDirection | Self::SlopeU | Self::SlopeV => "px/frame",
            Self::Scale => "px",
            Self::Response => "of full scale",
            Self::Snr => "σ",
            Self::Limit | Self::Coherence => "",
            Self::Depth => "m",
        }
    }
}

/// Formats a number with `digits` significant digits, without trailing zeros: `0.0123`, `1234`, `−3.2e−7`, `NaN`.
pub fn number(value: f32, digits: usize) -> String {
    if value.is_nan() {
        return "NaN".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor() as i32;
    let text = if (-4..7).contains(&magnitude) {
        let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
        let fixed = format!("{value:.decimals$}");
        if fixed.contains('.') { fixed.trim_end_matches('0').trim_end_matches('.').to_owned() } else { fixed }
    } else {
        let scientific = format!("{value:.*e}", digits.saturating_sub(1));
        match scientific.split_once('e') {
            Some((mantissa, exponent)) if mantissa.contains('.') => {
                format!("{}e{exponent}", mantissa.trim_end_matches('0').trim_end_matches('.'))
            }
            _ => scientific,
        }
    };
    text.replace('-', "−")
}

pub fn signed_number(value: f32, digits: usize) -> String {
    let text = number(value, digits);
    if value > 0.0 { format!("+{text}") } else { text }
}

/// Formats with `decimals` decimals; a number that rounds to zero has no minus.
pub fn fixed(value: f32, decimals: usize) -> String {
    without_minus_zero(format!("{value:.decimals$}"))
}

/// Formats as [`fixed`] does, with a `+` before positive numbers; zero has no sign.
pub fn signed(value: f32, decimals: usize) -> String {
    let text = format!("{value:+.decimals$}");
    let is_zero = !text.contains(|c: char| ('1'..='9').contains(&c)) && value.is_finite();
    if is_zero { text.trim_start_matches(['+', '-']).to_owned() } else { text }
}

pub fn signed_slope(slope: Slope, decimals: usize) -> String {
    format!("{}, {}", signed(slope.u, decimals), signed(slope.v, decimals))
}

/// Drops the minus sign of a number that was rounded to zero: `-0.00` becomes `0.00`.
pub fn without_minus_zero(text: String) -> String {
    let is_zero = !text.contains(|c: char| ('1'..='9').contains(&c)) && text.contains('0');
    if is_zero { text.trim_start_matches(['-', '−']).to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_rounds_to_zero_has_no_minus() {
        let cases = [("-0.00", "0.00"), ("−0", "0"), ("-0.01", "-0.01"), ("+0.00", "+0.00"), ("−∞", "−∞"), ("–", "–")];
        for (text, wanted) in cases {
            assert_eq!(without_minus_zero(text.to_owned()), wanted);
        }
        assert_eq!([fixed(-0.004, 2), fixed(-0.006, 2), fixed(0.0, 1)], ["0.00", "-0.01", "0.0"]);
        assert_eq!(
            [signed(-0.004, 2), signed(0.004, 2), signed(-0.0, 1), signed(2.5, 1)],
            ["0.00", "0.00", "0.0", "+2.5"]
        );
        assert_eq!(signed_slope(Slope::new(-0.001, -1.5), 2), "0.00, -1.50");
        let mut style = egui::Style::default();
        crate::app::style::numbers(&mut style);
        assert_eq!(style.number_formatter.format(-0.001, 2..=2), "0.00");
        assert_eq!(style.number_formatter.format(-0.25, 2..=2), "-0.25");
    }

    #[test]
    fn numbers_as_people_read_them() {
        let cases = [
            (0.0, "0"),
            (0.5, "0.5"),
            (0.0123456, "0.01235"),
            (1.0, "1"),
            (1234.5678, "1235"),
            (65535.0, "65535"),
            (-0.25, "−0.25"),
            (3.2e-7, "3.2e−7"),
            (f32::NAN, "NaN"),
            (f32::NEG_INFINITY, "−∞"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value, 4), text, "{value}");
        }
    }

    #[test]
    fn faint_responses_of_dark_bursts_keep_their_digits() {
        assert_eq!(signed_number(0.000_012_3, 3), "+1.23e−5");
        assert_eq!(signed_number(-0.000_123_4, 3), "−0.000123");
        assert_eq!((signed_number(0.0, 3), signed_number(0.5, 3)), ("0".to_owned(), "+0.5".to_owned()));
    }
}
