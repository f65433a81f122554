//! Change of one setting, as advice and explanations suggest it: commands print it, and the window applies it.

use super::{DetectorParams, Param, ParamDoc, SearchParams, doc};
use crate::error::{Error, Result};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// Parameter and its new value, as the command line takes it; applied by [`Self::applied`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ParamChange {
    /// Parameter to change, by name in files.
    #[serde(serialize_with = "name_of", deserialize_with = "parameter_named")]
    pub parameter: Param<SearchParams>,
    /// New value, in the syntax of the option.
    pub value: String,
}

fn name_of<S: Serializer>(parameter: &Param<SearchParams>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(parameter.name)
}

fn parameter_named<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Param<SearchParams>, D::Error> {
    let name = String::deserialize(deserializer)?;
    let found = doc::ALL.into_iter().find(|parameter| parameter.name == name);
    found.ok_or_else(|| de::Error::custom(format!("there is no parameter '{name}'")))
}

impl ParamChange {
    /// Change of `parameter` to `value`.
    pub fn new(parameter: Param<SearchParams>, value: impl ToString) -> Self {
        Self { parameter, value: value.to_string() }
    }

    /// Text as an option of the commands.
    pub fn option(&self) -> String {
        format!("--{} {}", self.parameter.name, self.value)
    }

    /// Text with the parameter's label in the window, where numbers have a sign of minus.
    pub fn label(&self) -> String {
        let is_word = self.value.contains(char::is_alphabetic);
        let value = if is_word { self.value.clone() } else { self.value.replace('-', "−") };
        format!("{} {value}", self.parameter.label)
    }

    /// Applies this change to `params` and checks the result.
    ///
    /// # Errors
    /// A value cannot be read, the parameters make no sense with it, or slopes would be found ([`doc::SLOPES`]).
    pub fn applied(&self, params: &DetectorParams) -> Result<DetectorParams> {
        Self::all_applied(std::slice::from_ref(self), params)
    }

    /// Applies all of `changes` to `params` and checks the result once: some values make sense only with others.
    ///
    /// # Errors
    /// As [`Self::applied`].
    pub fn all_applied(changes: &[Self], params: &DetectorParams) -> Result<DetectorParams> {
        let mut changed = SearchParams::from(params.clone());
        for change in changes {
            let ParamDoc { name: parameter, .. } = *change.parameter;
            let remedy = format!("give what '--{parameter}' takes");
            let wrong = |problem| Error::param(parameter, problem, remedy);
            change.parameter.read(&mut changed, &change.value).map_err(wrong)?;
        }
        changed.validate()?;
        let found = || Error::param(doc::SLOPES.name, "those of a search are known", "give ranges");
        changed.slopes.given().map(|grid| changed.at(grid)).ok_or_else(found)
    }
}
