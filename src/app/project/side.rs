//! Which of the two bursts.

use serde::{Deserialize, Serialize};

/// One of the two bursts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The first, on the left.
    #[default]
    A,
    /// The second, on the right.
    B,
}

impl Side {
    /// Both, from left to right.
    pub const BOTH: [Self; 2] = [Self::A, Self::B];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
        }
    }

    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}
