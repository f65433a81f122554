//! Change of one setting, as advice and explanations suggest it: commands print it, and the window applies it.

use super::{DetectorParams, Param, ParamDoc, doc};
use crate::error::{Error, Result};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// A parameter and its new value, as the command line takes it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ParamChange {
    /// Parameter to change.
    #[serde(serialize_with = "name_of", deserialize_with = "parameter_named")]
    pub parameter: Param<DetectorParams>,
    /// New value.
    pub value: String,
}

fn name_of<S: Serializer>(parameter: &Param<DetectorParams>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(parameter.name)
}

fn parameter_named<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Param<DetectorParams>, D::Error> {
    let name = String::deserialize(deserializer)?;
    let found = doc::ALL.into_iter().chain([doc::SLOPES]).find(|parameter| parameter.name == name);
    found.ok_or_else(|| de::Error::custom(format!("there is no parameter '{name}'")))
}

impl ParamChange {
    /// Change of `parameter` to `value`.
    pub fn new(parameter: Param<DetectorParams>, value: impl ToString) -> Self {
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
    /// A value cannot be read, the parameters make no sense with it, or it is a choice of slopes
    /// ([`super::doc::SLOPES`]).
    pub fn applied(&self, params: &DetectorParams) -> Result<DetectorParams> {
        Self::all_applied(std::slice::from_ref(self), params)
    }

    /// Applies all of `changes` to `params` and checks the result once: some values make sense only with others.
    ///
    /// # Errors
    /// As [`Self::applied`].
    pub fn all_applied(changes: &[Self], params: &DetectorParams) -> Result<DetectorParams> {
        let mut changed = params.clone();
        for change in changes {
            let ParamDoc { name: parameter, .. } = *change.parameter;
            let remedy = format!("give what '--{parameter}' takes");
            let wrong = |problem| Error::param(parameter, problem, remedy);
            change.parameter.read(&mut changed, &change.value).map_err(wrong)?;
        }
        changed.validate()?;
        Ok(changed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_of_the_detector_can_be_changed_alone() {
        let before = DetectorParams::default();
        for record in doc::ALL.into_iter().filter(|record| *record != doc::SLOPES) {
            let mut sample = DetectorParams::default();
            let words = (record.field)(&mut sample).words().unwrap_or_default().iter().map(|(word, _)| *word);
            let others =
                words.chain(["-1:2:5", "1..4", "0.5", "4.25", "3"]).filter(|text| *text != record.text(&before));
            let changed = others.filter_map(|text| Some((text, ParamChange::new(record, text).applied(&before).ok()?)));
            let mut changed = changed.filter(|(text, after)| record.text(after) == **text);
            let (text, after) = changed.next_back().unwrap_or_else(|| panic!("{}: no other value", record.name));
            for other in doc::ALL.into_iter().filter(|_| record != doc::RULES) {
                let expected = if other == record { text.to_owned() } else { other.text(&before) };
                assert_eq!(other.text(&after), expected, "{} changed to {text}: {}", record.name, other.name);
            }
            let error = ParamChange::new(record, "nonsense").applied(&before).expect_err(record.name);
            assert_eq!(error.subject, record.name);
        }
        assert!(ParamChange::new(doc::SLOPES, "auto").applied(&before).is_err());
        assert!(ParamChange::new(doc::LEVELS, 0).applied(&before).is_err(), "checked");
        assert_eq!(ParamChange::new(doc::NOISE_GATE, "strict").option(), "--noise-gate strict");
    }
}
