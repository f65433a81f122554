//! Values of the options that the parameters of synthetic bursts are on a command line (feature `cli`).

use super::Motion;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::de::DeserializeOwned;
use std::ops::RangeInclusive;

pub(super) const SNR_HELP: &str = "Signal-to-noise ratio of one pixel in one frame: the difference of the two levels over the standard deviation of the noise \
    at their mean; 'inf' makes no noise";

/// Parser of `words`, all words of `T` in a parameter file, so that file and command line share their words.
pub fn words<T>(words: &'static [&'static str]) -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(words).try_map(|word| serde_json::from_value::<T>(word.into()))
}

/// Parser of directions of motion.
pub fn motions() -> impl TypedValueParser<Value = Motion> {
    PossibleValuesParser::new(["1d", "2d"]).map(|word| if word == "2d" { Motion::TwoD } else { Motion::OneD })
}

/// Reads a range of finite numbers, `MIN:MAX`, or one number for both ends.
pub fn parse_range(text: &str) -> Result<RangeInclusive<f64>, String> {
    let bad = || format!("'{text}' is not MIN:MAX, such as 3.6:19");
    let (low, high) = text.split_once(':').unwrap_or((text, text));
    let number = |s: &str| s.trim().parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(bad);
    Ok(number(low)?..=number(high)?)
}
