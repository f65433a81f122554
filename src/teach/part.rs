//! Parts of the window that a lesson can highlight, by name.

use crate::detector::params::{ParamDoc, doc};
use crate::matching::params::doc as matching_doc;
use serde::{Deserialize, Deserializer, de};
use std::fmt;
use strum::IntoEnumIterator;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, strum::EnumIter, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Part {
    Pictures,
    Frame,
    /// The slider of slope u, with the bars below it.
    SlopeU,
    SlopeV,
    Octave,
    Level,
    Kinds,
    Workspaces,
    Detect,
    Tabs,
    Below,
    Probe,
    Response,
    Shares,
    /// Number of frames that are added, in the lesson's panel.
    FramesAdded,
    Snr,
    /// Row of a parameter of the detector or of matching, by the parameter's name on the command line.
    #[strum(disabled)]
    Parameter(&'static str),
}

impl Part {
    pub fn parameter(doc: &ParamDoc) -> Self {
        Self::Parameter(doc.name)
    }
}

/// All parameters that have a row in the window: the detector's, then those of matching.
pub(super) fn parameters() -> impl Iterator<Item = ParamDoc> {
    doc::ALL.into_iter().map(|record| record.doc).chain(matching_doc::ALL.map(|record| record.doc))
}

pub(super) fn field_of(name: &str) -> String {
    name.replace('-', "_")
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameter(name) => f.write_str(&field_of(name)),
            named => f.write_str(named.into()),
        }
    }
}

impl TryFrom<String> for Part {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let named = Self::iter().find(|part| name == <&str>::from(part));
        let parameter = || parameters().find(|doc| field_of(doc.name) == name).map(|doc| Self::parameter(&doc));
        // A part's own name wins over that of a parameter.
        named.or_else(parameter).ok_or_else(|| {
            let names: Vec<&str> = Self::iter().map(<&str>::from).collect();
            format!("the window has no part '{name}'; give one of {}, or the name of a parameter", names.join(", "))
        })
    }
}

impl<'de> Deserialize<'de> for Part {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::try_from(String::deserialize(deserializer)?).map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_read_by_its_name_and_no_other() {
        for part in Part::iter().chain(parameters().map(|doc| Part::parameter(&doc))) {
            assert_eq!(Part::try_from(part.to_string()), Ok(part));
        }
        for bad in ["", "Picture", "slope-u", "nothing"] {
            assert!(Part::try_from(bad.to_owned()).expect_err(bad).contains("slope_u"));
        }
    }
}
