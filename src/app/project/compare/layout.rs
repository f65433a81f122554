//! Which methods are shown, and how they are laid beside one another.

use crate::app::project::compare::Contender;
use serde::{Deserialize, Serialize};

/// How methods are laid beside one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Layout {
    /// A pane for each.
    #[default]
    Panes,
    /// Two in one place, with a line between them that can be moved.
    Wipe,
    /// Two in one place, one after the other.
    Flip,
    /// A row for each with its matches between A and B.
    Matches,
}

impl Layout {
    /// All of them, in the order of the switch.
    pub const ALL: [Self; 4] = [Self::Panes, Self::Wipe, Self::Flip, Self::Matches];

    /// Its name.
    pub fn label(self) -> &'static str {
        match self {
            Self::Panes => "Panes",
            Self::Wipe => "Wipe",
            Self::Flip => "Flip",
            Self::Matches => "Match lines",
        }
    }

    /// What it shows.
    pub fn help(self) -> &'static str {
        match self {
            Self::Panes => "A picture for each method, side by side",
            Self::Wipe => "Two methods in one picture, with a line between them that can be dragged",
            Self::Flip => "Two methods in one place: Y flips from one to the other",
            Self::Matches => "A row for each method: its matches between A and B",
        }
    }

    /// The one after it; the rows of matches only where there is a second burst.
    #[must_use]
    pub fn next(self, has_second: bool) -> Self {
        let there = |layout: &&Self| has_second || **layout != Self::Matches;
        let place = Self::ALL.iter().position(|l| *l == self).unwrap_or(0);
        let after = Self::ALL.iter().cycle().skip(place + 1).find(there);
        after.copied().unwrap_or_default()
    }
}

/// Which methods are shown, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CompareLook {
    /// The methods.
    pub methods: Vec<Contender>,
    /// How they are laid out.
    pub layout: Layout,
    /// The two of a wipe or a flip, left and right.
    pub two: [Contender; 2],
    /// Where the line of a wipe is, 0 … 1 from the left.
    pub wipe: f32,
    /// Whether a flip shows the second.
    pub flipped: bool,
    /// Whether features are drawn.
    pub features: bool,
}

impl Default for CompareLook {
    fn default() -> Self {
        Self {
            methods: Contender::ALL.to_vec(),
            layout: Layout::default(),
            two: [Contender::Sift, Contender::Buff1d],
            wipe: 0.5,
            flipped: false,
            features: true,
        }
    }
}

impl CompareLook {
    /// Whether `method` is shown.
    pub fn shows(&self, method: Contender) -> bool {
        self.methods.contains(&method)
    }

    /// Shows or hides `method`.
    pub fn show(&mut self, method: Contender, shown: bool) {
        self.methods.retain(|m| *m != method);
        if shown {
            self.methods.push(method);
            self.methods.sort_unstable();
        }
    }

    /// The same with values that make sense: what comes from a file may be anything.
    #[must_use]
    pub fn sanitised(mut self) -> Self {
        self.methods.sort_unstable();
        self.methods.dedup();
        self.wipe = if self.wipe.is_finite() { self.wipe.clamp(0.0, 1.0) } else { 0.5 };
        self
    }
}
