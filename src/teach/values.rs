//! Values of a lesson's file that are checked as they are read, so that a mistake is reported with its line.

use serde::Deserialize;

/// Range from `min` to `max`, both included; written `[min, max]`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "[f32; 2]")]
pub struct Between {
    pub min: f32,
    pub max: f32,
}

impl Between {
    pub fn contains(self, value: f32) -> bool {
        (self.min..=self.max).contains(&value)
    }

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
            Err(format!("[{min}, {max}] is not a range; give min, then max"))
        }
    }
}

/// Text that is not empty; surrounding blanks are removed.
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

/// Returns `numbers`.
///
/// # Errors
/// When one of them is not finite.
pub(super) fn finite<const N: usize>(numbers: [f32; N]) -> Result<[f32; N], String> {
    match numbers.iter().find(|x| !x.is_finite()) {
        Some(x) => Err(format!("{x} is not a finite number; give one")),
        None => Ok(numbers),
    }
}
