//! The rows of the table: methods, and the gold standard among them.

use crate::evaluate::methods::BurstMethod;
use serde::{Serialize, Serializer};
use std::str::FromStr;

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatchMethod {
    /// SIFT on a sharp image of the same view.
    Gold,
    /// A method that finds features in the burst.
    Burst(BurstMethod),
}

impl MatchMethod {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gold => "gold",
            Self::Burst(method) => method.name(),
        }
    }

    /// The method, if it searches the burst.
    pub fn of_burst(self) -> Option<BurstMethod> {
        match self {
            Self::Gold => None,
            Self::Burst(method) => Some(method),
        }
    }

    /// Name in a table.
    pub fn label(self) -> &'static str {
        match self {
            Self::Gold => "gold standard",
            Self::Burst(method) => method.label(),
        }
    }
}

impl FromStr for MatchMethod {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "gold" {
            return Ok(Self::Gold);
        }
        text.parse().map(Self::Burst).map_err(|e: String| e.replace("give ", "give gold, "))
    }
}

impl Serialize for MatchMethod {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_are_read_as_they_are_written() {
        for word in ["gold", "sift-frame", "sift-mean", "sift-merge", "buff-1d", "buff-2d", "buff-auto"] {
            assert_eq!(word.parse::<MatchMethod>().map(MatchMethod::name), Ok(word));
        }
        assert!("surf".parse::<MatchMethod>().expect_err("unknown").contains("give gold, sift-frame"));
    }
}
