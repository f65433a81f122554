//! The workspaces of the window: what it is about at the moment.

use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Workspace {
    #[default]
    Inspect,
    Pair,
    Methods,
    Matches,
    Trajectories,
    Lab,
}

impl Workspace {
    pub fn needs_burst(self) -> bool {
        matches!(self, Self::Inspect | Self::Pair | Self::Methods)
    }
}
