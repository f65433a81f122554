//! Goals of a lesson's tasks: conditions that all have to hold.

use super::part::{field_of, parameters};
use super::{Between, BottomTab, Layout, Near, Workspace};
use crate::detector::DetectorParams;
use crate::matching::MatchParams;
use crate::requests::ViewKind;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Conditions on the window; an absent one always holds.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Goal {
    /// px/frame.
    pub slope_u: Option<Between>,
    pub slope_v: Option<Between>,
    pub show: Option<ViewKind>,
    pub layout: Option<Layout>,
    pub frame: Option<Between>,
    pub octave: Option<Between>,
    pub level: Option<Between>,
    pub frames_used: Option<Between>,
    pub features: Option<Between>,
    pub selected: Option<bool>,
    pub probe: Option<Near>,
    /// Required parameter values or ranges, by parameter name.
    pub params: BTreeMap<ParamName, GoalValue>,
    /// Range of slopes u that the searched range must contain.
    pub searches_u: Option<Between>,
    pub slopes: Option<Between>,
    pub tab: Option<BottomTab>,
    pub workspace: Option<Workspace>,
    pub inliers: Option<Between>,
    pub selected_match: Option<bool>,
    pub camera: Option<bool>,
    pub reads_depths: Option<bool>,
    /// Whether features are found by themselves, as *Auto* says.
    pub detects: Option<bool>,
    /// Whether the slopes are found from the burst, as *Auto slopes* says.
    pub finds_slopes: Option<bool>,
}

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(try_from = "String")]
pub struct ParamName(String);

impl ParamName {
    /// Name with `_` between words, as in a file.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl TryFrom<String> for ParamName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        if parameters().any(|doc| field_of(doc.name) == name) {
            Ok(Self(name))
        } else {
            Err(format!("there is no parameter '{name}'; use the names of a parameter file"))
        }
    }
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged, expecting = "data did not match any variant of untagged enum Wanted")]
pub enum GoalValue {
    Between(Between),
    Number(f64),
    Switch(bool),
    Word(String),
}

impl Goal {
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    pub fn params_are_met(&self, detector: &DetectorParams, matching: &MatchParams) -> bool {
        if self.params.is_empty() {
            return true;
        }
        let (detector, matching) = (table_of(detector), table_of(matching));
        self.params.iter().all(|(name, wanted)| {
            let value = detector.get(name.as_str()).or_else(|| matching.get(name.as_str()));
            value.is_some_and(|value| wanted.is_met(value))
        })
    }
}

impl GoalValue {
    fn is_met(&self, value: &toml::Value) -> bool {
        let number = value.as_float().or_else(|| value.as_integer().map(|x| x as f64));
        match self {
            Self::Between(between) => number.is_some_and(|x| between.contains(x as f32)),
            // Parameters are f32: a decimal number differs from them in the seventh digit.
            Self::Number(wanted) => number.is_some_and(|x| (x - wanted).abs() <= 1e-6 * wanted.abs().max(1.0)),
            Self::Switch(wanted) => value.as_bool() == Some(*wanted),
            Self::Word(word) => value.as_str() == Some(word),
        }
    }
}

fn table_of(params: &impl Serialize) -> toml::Table {
    toml::Table::try_from(params).expect("parameters are plain values, which TOML can always hold")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::NoiseGate;

    fn goal(text: &str) -> Goal {
        toml::from_str(text).expect(text)
    }

    #[test]
    fn conditions_hold_within_their_bounds() {
        let detector = DetectorParams { noise_gate: NoiseGate::Factor(4.0), ..DetectorParams::default() };
        for (text, met) in [
            ("", true),
            ("probe = [103, 54, 5]", true),
            ("probe = [104, 54, 5]", false),
            ("params = { noise_gate = [3.9, 4.1] }", true),
            ("params = { noise_gate = 4 }", true),
            ("params = { noise_gate = \"auto\" }", false),
            ("params = { mutual = true, ratio = [0.7, 0.9], method = \"buff\" }", true),
            ("params = { mutual = false }", false),
        ] {
            let goal = goal(text);
            let is_near = goal.probe.is_none_or(|near| near.contains([100.0, 50.0]));
            assert_eq!(is_near && goal.params_are_met(&detector, &MatchParams::default()), met, "{text}");
        }
    }

    #[test]
    fn a_goal_with_a_mistake_is_none() {
        for text in ["slope_u = 3", "slope_w = [0, 1]", "params = { gate = 3 }", "probe = [1, 2, 0]", "show = \"x\""] {
            assert!(toml::from_str::<Goal>(text).is_err(), "{text}");
        }
    }
}
