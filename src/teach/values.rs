//! Values of a lesson's file that are checked as they are read, so that a mistake is reported where it stands.

use serde::Deserialize;

/// Everything from `min` to `max`, both included; written `[min, max]`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "[f32; 2]")]
pub struct Between {
    /// The least value that is meant.
    pub min: f32,
    /// The greatest.
    pub max: f32,
}

impl Between {
    /// Whether `value` is meant.
    pub fn contains(self, value: f32) -> bool {
        (self.min..=self.max).contains(&value)
    }

    /// The value in the middle.
    pub fn middle(self) -> f32 {
        0.5 * (self.min + self.max)
    }
}

impl TryFrom<[f32; 2]> for Between {
    type Error = String;

    fn try_from([min, max]: [f32; 2]) -> Result<Self, String> {
        if min.is_finite() && max.is_finite() && min <= max {
            Ok(Self { min, max })
        } else {
            Err(format!("[{min}, {max}] is no range; give the least value, then the greatest"))
        }
    }
}

/// A text that says something.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub(super) struct Text(pub String);

impl TryFrom<String> for Text {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let text = text.trim();
        if text.is_empty() { Err("the text is empty; write a sentence") } else { Ok(Self(text.to_owned())) }
    }
}

/// `numbers`, if all of them are finite.
pub(super) fn finite<const N: usize>(numbers: [f32; N]) -> Result<[f32; N], String> {
    match numbers.iter().find(|x| !x.is_finite()) {
        Some(x) => Err(format!("{x} is not a number that can be meant here")),
        None => Ok(numbers),
    }
}
