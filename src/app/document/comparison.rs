//! The comparison of a burst with a reference, as it is set.

use crate::app::words::choices;
use crate::detector::SearchParams;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

choices! {
    Reference {
        Pinned: "Pinned result", "Gained, lost and moved features against the pinned result";
        File: "Opened features",
        "Features of a file: in both, only theirs, only ours. Open them from the Features menu";
        Truth: "Truth",
        "Known truth: found, missed, repeated and false features, and those at a wrong motion: more than 0.35 px/frame off, or than smears it by its σ. Synthetic bursts and the demo have one; that of a scene is partial, so features elsewhere may be right";
    }
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Comparison {
    pub with: Option<Reference>,
    pub file: Option<PathBuf>,
    /// Parameters of the pinned result: where that is not kept, the detection is repeated, which gives the same bits.
    pub pinned: Option<SearchParams>,
    pub hidden: Vec<Compared>,
    pub selected: Option<usize>,
}

impl Comparison {
    pub fn shows(&self, kind: Compared) -> bool {
        !self.hidden.contains(&kind)
    }

    /// Without what belongs to the burst that was open before.
    #[must_use]
    pub fn of_next_burst(&self) -> Self {
        let with = self.with.filter(|with| *with == Reference::Truth);
        if with.is_some() { Self { pinned: None, file: None, ..self.clone() } } else { Self::default() }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Compared {
    /// Theirs alone: lost, only in the file, missed.
    Theirs,
    /// Ours, on an object that moves otherwise.
    WrongMotion,
    /// Ours alone: gained, not in the file, false or elsewhere.
    Ours,
    /// In both, but not at the same place, scale and slope.
    Moved,
    /// Ours, but a stronger feature has found the same object.
    Repeated,
    /// In both: as before, found.
    Same,
}

impl Compared {
    pub fn of(with: Reference) -> &'static [Self] {
        match with {
            Reference::Pinned | Reference::File => &[Self::Theirs, Self::Ours, Self::Moved, Self::Same],
            Reference::Truth => &[Self::Theirs, Self::WrongMotion, Self::Ours, Self::Repeated, Self::Same],
        }
    }

    pub fn label(self, with: Reference) -> &'static str {
        match (with, self) {
            (Reference::Pinned, Self::Theirs) => "Lost",
            (Reference::Pinned, Self::Ours) => "Gained",
            (Reference::File, Self::Theirs) => "Only theirs",
            (Reference::File, Self::Ours) => "Only ours",
            (Reference::Truth, Self::Theirs) => "Missed",
            (Reference::Truth, Self::Ours) => "Elsewhere",
            (_, Self::Moved) => "Moved",
            (_, Self::WrongMotion) => "Wrong motion",
            (_, Self::Repeated) => "Repeated",
            (Reference::Pinned, Self::Same) => "As before",
            (Reference::File, Self::Same) => "Both",
            (Reference::Truth, Self::Same) => "Found",
        }
    }
}
