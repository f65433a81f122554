//! Values of a lesson's file that are checked as they are read, so that a mistake is reported with its line.

use serde::{Deserialize, Deserializer};

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

/// Place and tolerance: `[u, v, radius]`, pixels at mid-burst.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "[f32; 3]")]
pub struct Near {
    pub place: [f32; 2],
    pub radius: f32,
}

impl Near {
    pub fn contains(self, [u, v]: [f32; 2]) -> bool {
        (u - self.place[0]).hypot(v - self.place[1]) <= self.radius
    }
}

impl TryFrom<[f32; 3]> for Near {
    type Error = String;

    fn try_from(numbers: [f32; 3]) -> Result<Self, String> {
        let [u, v, radius] = finite(numbers)?;
        if radius > 0.0 {
            Ok(Self { place: [u, v], radius })
        } else {
            Err(format!(
                "the third number is the max distance from the place in pixels; it must be above 0, not {radius}"
            ))
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

pub(super) fn text<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    Text::deserialize(deserializer).map(|text| text.0)
}

pub(super) fn finite<const N: usize>(numbers: [f32; N]) -> Result<[f32; N], String> {
    let wrong = numbers.iter().find(|x| !x.is_finite());
    wrong.map_or(Ok(numbers), |x| Err(format!("{x} is not a finite number; give one")))
}
