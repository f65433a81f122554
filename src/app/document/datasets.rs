//! The dataset and the trajectories as they are set.

use crate::app::defaults::with_defaults;
use crate::app::document::{Side, Sides};
use crate::app::{view::View, words::choices};
use crate::dataset::DatasetSource;
use crate::evaluate::poses::{PoseStudy, Projection};
use crate::matching::PairSelection;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Two bursts by their places, the earlier one first.
pub type BurstPair = (usize, usize);

/// The pair of the bursts at two places, the lower place first; `None` if the places are equal.
pub fn pair_of(a: usize, b: usize) -> Option<BurstPair> {
    (a != b).then_some((a.min(b), a.max(b)))
}

choices! {
    #[derive(Default)]
    PairColumn {
        #[default]
        Pair: "pair", "The two bursts";
        Putative: "putative", "Matches by descriptors alone";
        Inliers: "inliers", "Matches that a common geometry explains";
        Ratio: "ratio", "Match ratio: putative matches over keypoints, mean of both bursts";
        Score: "score", "Match score: inliers over keypoints, mean of both bursts";
        #[serde(alias = "precision")]
        InlierRatio: "inlier ratio", "Inlier ratio: inliers over putative matches";
    }
}

with_defaults! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    pub struct PairChoice {
        /// Whether each burst is matched with the next few only.
        pub neighbours: bool,
        /// Number of these next bursts, 1 or more.
        pub overlap: usize = 3,
        /// Number of others, 1 or more, with which each burst is matched that look most alike; `None` for another rule.
        pub alike: Option<usize>,
    }
}

impl PairChoice {
    pub fn selection(self) -> PairSelection {
        match self.alike {
            Some(partners) => PairSelection::Near(partners),
            None if self.neighbours => PairSelection::Sequential(self.overlap),
            None => PairSelection::All,
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetChoice {
    pub source: DatasetSource,
    pub folder: Option<PathBuf>,
    /// Places of the bursts chosen as A and as B.
    #[serde(default)]
    pub pair: Sides<Option<usize>>,
}

impl DatasetChoice {
    pub fn selected(&self) -> Option<BurstPair> {
        pair_of(self.pair.a?, self.pair.b?)
    }

    /// Makes the earlier burst of a pair A and the later one B.
    pub fn select(&mut self, (a, b): BurstPair) {
        self.pair = Sides { a: Some(a), b: Some(b) };
    }

    /// Clears the choice if it is chosen already. A burst cannot be both.
    pub fn choose(&mut self, side: Side, place: usize) {
        let Self { pair, .. } = self;
        pair[side] = (pair[side] != Some(place)).then_some(place);
        pair[side.other()].take_if(|other| *other == place);
    }

    /// Without places that `count` bursts do not have.
    pub fn within(mut self, count: usize) -> Self {
        for side in Side::BOTH {
            self.pair[side] = self.pair[side].filter(|place| *place < count);
        }
        self
    }
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Trajectories {
    pub estimate: Option<PathBuf>,
    pub second: Option<PathBuf>,
    pub truth: Option<PathBuf>,
    pub study: PoseStudy,
    pub projection: Projection,
    /// Degrees by which a free view was turned around and above.
    pub orbit: [f32; 2],
    /// Whether the points of a sparse model are drawn.
    pub points: bool,
    pub view: View,
    /// Camera of the truth, by its place.
    pub selected: Option<usize>,
    pub point: Option<usize>,
}

impl Trajectories {
    /// Files and folders, in the order of [`crate::requests::Which::ALL`].
    pub fn paths(&self) -> [&Option<PathBuf>; 3] {
        [&self.estimate, &self.second, &self.truth]
    }

    pub fn paths_mut(&mut self) -> [&mut Option<PathBuf>; 3] {
        [&mut self.estimate, &mut self.second, &mut self.truth]
    }
}
