//! Goals of a lesson's tasks: conditions that all have to hold.

use super::part::{field_of, parameters};
use super::{Between, BottomTab, Layout, Near, Workspace};
use crate::detector::{DetectorParams, Slope};
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

#[derive(Debug, Clone)]
pub struct Situation<'a> {
    pub slope: Slope,
    /// Content of the focused picture; `None` where it is made of several.
    pub show: Option<ViewKind>,
    pub layout: Option<Layout>,
    pub frame: usize,
    pub octave: i32,
    pub level: i32,
    pub frames_used: usize,
    /// With the present parameters.
    pub features: Option<usize>,
    pub selected: bool,
    /// Probed place, pixels at mid-burst, once its answer is there.
    pub probe: Option<[f32; 2]>,
    pub params: DetectorParams,
    pub matching: &'a MatchParams,
    pub tab: Option<BottomTab>,
    pub workspace: Workspace,
    pub inliers: Option<usize>,
    pub selected_match: bool,
    /// Whether a camera of the trajectories is selected.
    pub camera: bool,
    pub reads_depths: bool,
    pub detects: bool,
    pub finds_slopes: bool,
}

impl Goal {
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    pub fn is_met(&self, now: &Situation<'_>) -> bool {
        let within = |wanted: Option<Between>, value: f32| wanted.is_none_or(|wanted| wanted.contains(value));
        // As long as features or inliers are not counted, no number of them is reached.
        let counted = |wanted: Option<Between>, value: Option<usize>| {
            wanted.is_none_or(|wanted| value.is_some_and(|value| wanted.contains(value as f32)))
        };
        let grid = now.params.used_slopes();
        let near = |wanted: Near| {
            now.probe.is_some_and(|[u, v]| (u - wanted.place[0]).hypot(v - wanted.place[1]) <= wanted.radius)
        };
        within(self.slope_u, now.slope.u)
            && within(self.slope_v, now.slope.v)
            && same(self.show, now.show)
            && same(self.layout, now.layout)
            && within(self.frame, now.frame as f32)
            && within(self.octave, now.octave as f32)
            && within(self.level, now.level as f32)
            && within(self.frames_used, now.frames_used as f32)
            && counted(self.features, now.features)
            && self.selected.is_none_or(|wanted| wanted == now.selected)
            && self.probe.is_none_or(near)
            && self.params_are_met(now)
            && self.searches_u.is_none_or(|wanted| grid.u.min <= wanted.min && wanted.max <= grid.u.max)
            && within(self.slopes, grid.len() as f32)
            && same(self.tab, now.tab)
            && same(self.workspace, Some(now.workspace))
            && counted(self.inliers, now.inliers)
            && self.selected_match.is_none_or(|wanted| wanted == now.selected_match)
            && self.camera.is_none_or(|wanted| wanted == now.camera)
            && self.reads_depths.is_none_or(|wanted| wanted == now.reads_depths)
            && self.detects.is_none_or(|wanted| wanted == now.detects)
            && self.finds_slopes.is_none_or(|wanted| wanted == now.finds_slopes)
    }

    fn params_are_met(&self, now: &Situation<'_>) -> bool {
        if self.params.is_empty() {
            return true;
        }
        let (detector, matching) = (table_of(&now.params), table_of(now.matching));
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

fn same<T: PartialEq>(wanted: Option<T>, now: Option<T>) -> bool {
    wanted.is_none() || wanted == now
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::{NoiseGate, SlopeGrid};

    fn goal(text: &str) -> Goal {
        toml::from_str(text).expect(text)
    }

    fn is_met(text: &str, change: impl FnOnce(&mut Situation<'_>)) -> bool {
        let params = DetectorParams {
            noise_gate: NoiseGate::Factor(4.0),
            slopes: SlopeGrid::line(-3.0..=3.0, 7),
            ..DetectorParams::default()
        };
        let matching = MatchParams::default();
        let mut now = Situation {
            slope: Slope::new(-2.0, 0.5),
            show: Some(ViewKind::Stack),
            layout: None,
            frame: 3,
            octave: 1,
            level: 2,
            frames_used: 10,
            features: Some(40),
            selected: false,
            probe: Some([100.0, 50.0]),
            params,
            matching: &matching,
            tab: Some(BottomTab::Tally),
            workspace: Workspace::Inspect,
            inliers: None,
            selected_match: false,
            camera: false,
            reads_depths: false,
            detects: true,
            finds_slopes: false,
        };
        change(&mut now);
        goal(text).is_met(&now)
    }

    #[test]
    fn conditions_hold_within_their_bounds() {
        for (text, met) in [
            ("", true),
            ("slope_v = [0.4, 0.6]\nslope_u = [0, 1]", false),
            ("level = [0, 1]", false),
            ("features = [50, 100]", false),
            ("probe = [103, 54, 5]", true),
            ("probe = [104, 54, 5]", false),
            ("params = { noise_gate = [3.9, 4.1] }", true),
            ("params = { noise_gate = 4 }", true),
            ("params = { noise_gate = \"auto\" }", false),
            ("params = { mutual = true, ratio = [0.7, 0.9], method = \"buff\" }", true),
            ("params = { mutual = false }", false),
            ("searches_u = [-3, 2]", true),
            ("searches_u = [-4, 2]", false),
            ("slopes = [7, 7]", true),
            ("inliers = [0, 9]", false),
        ] {
            assert_eq!(is_met(text, |_| {}), met, "{text}");
        }
        assert!(is_met("inliers = [5, 9]", |now| now.inliers = Some(7)));
        assert!(!is_met("probe = [100, 50, 9]", |now| now.probe = None), "its answer is not there yet");
    }

    #[test]
    fn a_goal_with_a_mistake_is_none() {
        for text in ["slope_u = 3", "slope_w = [0, 1]", "params = { gate = 3 }", "probe = [1, 2, 0]", "show = \"x\""] {
            assert!(toml::from_str::<Goal>(text).is_err(), "{text}");
        }
    }
}
