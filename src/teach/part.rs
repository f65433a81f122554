//! Parts of the window that a lesson can highlight, by name.

use crate::detector::params::{ParamDoc, doc};
use crate::matching::params::doc as matching_doc;
use serde::{Deserialize, Deserializer, de};
use std::fmt;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Part {
    /// All pictures, with their headers.
    Pictures,
    Frame,
    /// The slider of slope u, with the bars below it.
    SlopeU,
    SlopeV,
    Octave,
    Level,
    /// The switch between frame, motion stack and DoG.
    Kinds,
    Workspaces,
    Detect,
    Tabs,
    Below,
    Probe,
    /// The probe's response over slope and scale.
    Response,
    /// The probe's share of each frame.
    Shares,
    /// Number of frames that are added, in the lesson's panel.
    FramesAdded,
    /// Measured signal-to-noise ratio, in the lesson's panel.
    Snr,
    /// Row of a parameter of the detector or of matching, by the parameter's name on the command line.
    Parameter(&'static str),
}

impl Part {
    pub const NAMED: [Self; 16] = [
        Self::Pictures,
        Self::Frame,
        Self::SlopeU,
        Self::SlopeV,
        Self::Octave,
        Self::Level,
        Self::Kinds,
        Self::Workspaces,
        Self::Detect,
        Self::Tabs,
        Self::Below,
        Self::Probe,
        Self::Response,
        Self::Shares,
        Self::FramesAdded,
        Self::Snr,
    ];

    pub fn parameter(doc: &ParamDoc) -> Self {
        Self::Parameter(doc.name)
    }

    pub fn name(self) -> String {
        match self {
            Self::Pictures => "pictures",
            Self::Frame => "frame",
            Self::SlopeU => "slope_u",
            Self::SlopeV => "slope_v",
            Self::Octave => "octave",
            Self::Level => "level",
            Self::Kinds => "kinds",
            Self::Workspaces => "workspaces",
            Self::Detect => "detect",
            Self::Tabs => "tabs",
            Self::Below => "below",
            Self::Probe => "probe",
            Self::Response => "response",
            Self::Shares => "shares",
            Self::FramesAdded => "frames_added",
            Self::Snr => "snr",
            Self::Parameter(name) => return field_of(name),
        }
        .to_owned()
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
        f.write_str(&self.name())
    }
}

impl TryFrom<String> for Part {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let named = Self::NAMED.into_iter().find(|part| part.name() == name);
        let parameter = || parameters().find(|doc| field_of(doc.name) == name).map(|doc| Self::parameter(&doc));
        named.or_else(parameter).ok_or_else(|| {
            let names: Vec<String> = Self::NAMED.iter().map(|part| part.name()).collect();
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
        let parts: Vec<Part> = Part::NAMED.into_iter().chain(parameters().map(|doc| Part::parameter(&doc))).collect();
        for part in &parts {
            assert_eq!(Part::try_from(part.name()), Ok(*part));
        }
        let mut names: Vec<String> = parts.iter().map(|part| part.name()).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), parts.len(), "two parts have one name");
        for bad in ["", "Picture", "slope-u", "nothing"] {
            assert!(Part::try_from(bad.to_owned()).expect_err(bad).contains("slope_u"));
        }
    }
}
