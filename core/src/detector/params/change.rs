//! Change of one setting, as advice and explanations suggest it: commands print it, and the window applies it.

use super::{DetectorParams, ParamDoc, ParamError, doc};
use crate::detector::params::slope_grid::SlopeAxis;
use serde::de::DeserializeOwned;
use serde::{Serialize, Serializer};
use std::str::FromStr;

/// A parameter and its new value, as the command line takes it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ParamChange {
    /// Parameter to change.
    #[serde(serialize_with = "name_of")]
    pub parameter: ParamDoc,
    /// New value.
    pub value: String,
}

fn name_of<S: Serializer>(parameter: &ParamDoc, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(parameter.name)
}

impl ParamChange {
    /// Change of `parameter` to `value`.
    pub fn new(parameter: ParamDoc, value: impl ToString) -> Self {
        Self { parameter, value: value.to_string() }
    }

    /// Text as an option of the commands.
    pub fn option(&self) -> String {
        format!("--{} {}", self.parameter.name, self.value)
    }

    /// Text with the parameter's label in the window.
    pub fn label(&self) -> String {
        format!("{} {}", self.parameter.label, self.value)
    }

    /// Applies this change to `params` and checks the result.
    ///
    /// # Errors
    /// The value cannot be read, or the parameters make no sense with it. The choice between given and found slopes
    /// ([`doc::SLOPES`]) is not one of the detector's parameters, so a change of it is refused too.
    pub fn applied(&self, params: &DetectorParams) -> Result<DetectorParams, ParamError> {
        Self::all_applied(std::slice::from_ref(self), params)
    }

    /// Applies all of `changes` to `params` and checks the result once: some values make sense only with others.
    ///
    /// # Errors
    /// As [`Self::applied`].
    pub fn all_applied(changes: &[Self], params: &DetectorParams) -> Result<DetectorParams, ParamError> {
        let mut changed = params.clone();
        for change in changes {
            change.set(&mut changed).map_err(|problem| change.unreadable(problem))?;
        }
        changed.validate()?;
        Ok(changed)
    }

    fn unreadable(&self, problem: String) -> ParamError {
        let remedy = format!("give what '--{}' takes", self.parameter.name);
        ParamError { parameter: self.parameter.name, problem, remedy }
    }

    fn set(&self, p: &mut DetectorParams) -> Result<(), String> {
        let text = self.value.as_str();
        match self.parameter.name {
            name if name == doc::METHOD.name => p.method = word(text)?,
            name if name == doc::SLOPES_U.name => p.slopes.u = SlopeAxis::from_str(text)?,
            name if name == doc::SLOPES_V.name => p.slopes.v = SlopeAxis::from_str(text)?,
            name if name == doc::SLOPE_DIRECTION.name => p.slopes.direction_deg = number(text)?,
            name if name == doc::FRAMES.name => p.frames = Some(text.parse()?),
            name if name == doc::OCTAVES.name => p.octaves = number(text)?,
            name if name == doc::LEVELS.name => p.levels = number(text)?,
            name if name == doc::FIRST_OCTAVE.name => p.first_octave = number(text)?,
            name if name == doc::PEAK_THRESHOLD.name => p.peak_threshold = number(text)?,
            name if name == doc::NOISE_GATE.name => p.noise_gate = text.parse()?,
            name if name == doc::NOISE_MODEL.name => p.noise_model = word(text)?,
            name if name == doc::FLICKER.name => p.flicker = word(text)?,
            name if name == doc::EDGE_THRESHOLD.name => p.edge_threshold = number(text)?,
            name if name == doc::SLOPE_EXTREMA.name => p.slope_extrema = word(text)?,
            name if name == doc::SLOPE_NEIGHBOURS.name => p.slope_neighbours = word(text)?,
            name if name == doc::DISTINCT.name => p.distinct = text.parse()?,
            name if name == doc::DISTINCT_SCALE.name => p.distinct_scale = number(text)?,
            name if name == doc::INTERPOLATION.name => p.interpolation = word(text)?,
            name if name == doc::KERNEL_CUT.name => p.kernel_cut = number(text)?,
            name if name == doc::LOCALISATION.name => p.localisation = word(text)?,
            name if name == doc::MAX_FEATURES.name => p.max_features = number(text)?,
            name if name == doc::MAX_ORIENTATIONS.name => p.max_orientations = number(text)?,
            name if name == doc::DESCRIBE_SLOPE.name => p.describe_slope = word(text)?,
            _ => return Err("this is chosen before the detector's parameters are".to_owned()),
        }
        Ok(())
    }
}

fn number<T: FromStr>(text: &str) -> Result<T, String> {
    text.trim().parse().map_err(|_| format!("'{text}' is not a number that it takes"))
}

/// Reads one of a few words, as files spell them.
fn word<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(serde_json::Value::String(text.to_owned())).map_err(|_| format!("'{text}' is not known"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::{Distinct, Method, NoiseGate, SlopeExtrema};

    #[test]
    fn every_parameter_of_the_detector_can_be_changed() {
        let before = DetectorParams::default();
        for doc in doc::ALL.into_iter().filter(|doc| *doc != doc::SLOPES) {
            let value = match doc.name {
                "method" => "sift",
                "slopes-u" | "slopes-v" => "-1:2:5",
                "frames" => "1..4",
                "noise-gate" => "4.25",
                "noise-model" => "white",
                "flicker" => "off",
                "slope-extrema" => "joint",
                "slope-neighbours" => "all",
                "distinct" => "off",
                "interpolation" => "nearest",
                "localisation" => "quadratic",
                "describe-slope" => "grid",
                "first-octave" => "-1",
                _ => "3",
            };
            let after = ParamChange::new(doc, value).applied(&before).unwrap_or_else(|e| panic!("{}: {e}", doc.name));
            assert_ne!(after, before, "{}", doc.name);
            let error = ParamChange::new(doc, "nonsense").applied(&before).expect_err(doc.name);
            assert_eq!(error.parameter, doc.name);
        }
        assert!(ParamChange::new(doc::SLOPES, "auto").applied(&before).is_err());
    }

    #[test]
    fn values_arrive_where_they_belong() {
        let before = DetectorParams::default();
        let after = |doc, value: &str| ParamChange::new(doc, value).applied(&before).expect("valid");
        assert_eq!(after(doc::NOISE_GATE, "strict").noise_gate, NoiseGate::Strict);
        assert_eq!(after(doc::DISTINCT, "0.5").distinct, Distinct::Radius(0.5));
        assert_eq!(after(doc::METHOD, "merge").method, Method::Merge);
        assert_eq!(after(doc::SLOPE_EXTREMA, "joint").slope_extrema, SlopeExtrema::Joint);
        assert!(ParamChange::new(doc::LEVELS, 0).applied(&before).is_err(), "checked");
        assert_eq!(ParamChange::new(doc::NOISE_GATE, 3.9).option(), "--noise-gate 3.9");
    }
}
