//! The rooms of the window: what it is about at the moment.

use serde::{Deserialize, Serialize};

/// What the window is about: each room has the middle of the window and the panels around it for itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Room {
    /// One burst, its pictures and features.
    #[default]
    Burst,
    /// Two bursts side by side, and the matches between them.
    Pair,
}
