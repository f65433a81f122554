//! The workspaces of the window: what it is about at the moment.

use serde::{Deserialize, Serialize};

/// A task of the window: each workspace has its own arrangement of the middle of the window and of the panels around
/// it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Workspace {
    /// One burst, its pictures and features.
    #[default]
    Inspect,
    /// Two bursts side by side, and the matches between them.
    Pair,
    /// Several methods on the same burst.
    Methods,
    /// The matches of a dataset's pairs.
    Matches,
    /// An estimated and a true trajectory.
    Trajectories,
    /// Studies of charts whose truth is known.
    Lab,
}

impl Workspace {
    /// Whether it shows a burst, and has nothing to show while none is open.
    pub fn needs_burst(self) -> bool {
        matches!(self, Self::Inspect | Self::Pair | Self::Methods)
    }
}
