//! Value parsers of the arguments for synthetic bursts.

use crate::synth::{Motion, RadiusLaw};
use std::ops::RangeInclusive;

pub(super) fn motions() -> impl clap::builder::TypedValueParser<Value = Motion> {
    use clap::builder::{PossibleValuesParser, TypedValueParser};
    PossibleValuesParser::new(["1d", "2d"]).map(|word| if word == "2d" { Motion::TwoD } else { Motion::OneD })
}

pub(super) fn radius_laws() -> impl clap::builder::TypedValueParser<Value = RadiusLaw> {
    use clap::builder::{PossibleValuesParser, TypedValueParser};
    PossibleValuesParser::new(RadiusLaw::ALL.map(RadiusLaw::name)).try_map(|word| word.parse::<RadiusLaw>())
}

pub(super) fn parse_range(text: &str) -> Result<RangeInclusive<f64>, String> {
    let bad = || format!("'{text}' is not MIN:MAX, such as 3.6:19");
    let (low, high) = text.split_once(':').unwrap_or((text, text));
    let number = |s: &str| s.trim().parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(bad);
    Ok(number(low)?..=number(high)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::ChartParams;

    #[test]
    fn the_default_radius_is_the_charts() {
        assert_eq!(parse_range("3.6:19"), Ok(ChartParams::default().radius));
    }

    #[test]
    fn ranges_are_two_numbers() {
        assert_eq!(parse_range("2"), Ok(2.0..=2.0));
        assert!(parse_range("x:2").is_err() && parse_range("1:nan").is_err());
    }
}
