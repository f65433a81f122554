//! The parameters of matching: defined, described and checked here and nowhere else.
//!
//! As with the detector's, the command line, the window and files use these names, and their help texts come from [`doc`].

use crate::detector::ParamError;
use serde::{Deserialize, Serialize};

/// Everything that decides which features match. The same features and the same parameters give the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MatchParams {
    /// See [`doc::RATIO`].
    pub ratio: f32,
    /// See [`doc::MUTUAL`].
    pub mutual: bool,
}

impl Default for MatchParams {
    fn default() -> Self {
        Self { ratio: 0.8, mutual: true }
    }
}

impl MatchParams {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first parameter that makes no sense.
    pub fn validate(&self) -> Result<(), ParamError> {
        if !(self.ratio > 0.0 && self.ratio <= 1.0) {
            return Err(ParamError {
                parameter: doc::RATIO.name,
                problem: self.ratio.to_string(),
                remedy: "give more than 0 and at most 1 (0.8 is usual, 1 switches the test off)".to_owned(),
            });
        }
        Ok(())
    }
}

/// The descriptions of the parameters of matching, in the words that every surface shows.
pub mod doc {
    use crate::detector::ParamDoc;
    use crate::detector::params::doc::param_doc;

    param_doc!(
        RATIO,
        "ratio",
        "Ratio test",
        "",
        "The largest ratio of the distances to the nearest and the second nearest descriptor; 1 switches the test off.",
        "Raise it to keep more matches, of which more are wrong."
    );
    param_doc!(
        MUTUAL,
        "mutual",
        "Mutual check",
        "",
        "Whether two features must be nearest to each other, and pass the ratio test both ways.",
        "Switch it off to let several features of A match one of B."
    );

    /// All of them, in the order in which surfaces show them.
    pub const ALL: [ParamDoc; 2] = [RATIO, MUTUAL];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_valid_and_nonsense_is_named() {
        assert_eq!(MatchParams::default().validate(), Ok(()));
        for ratio in [0.0, -0.5, 1.01, f32::NAN] {
            let error = MatchParams { ratio, ..MatchParams::default() }.validate().expect_err("nonsense");
            assert_eq!(error.parameter, "ratio");
        }
    }

    #[test]
    fn every_field_has_a_description() {
        let text = toml::to_string(&MatchParams::default()).expect("plain values");
        let table: toml::Table = text.parse().expect("valid");
        for field in table.keys() {
            assert!(doc::ALL.iter().any(|d| d.name.replace('-', "_") == *field), "{field} has no description");
        }
    }
}
