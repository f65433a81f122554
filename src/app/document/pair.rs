//! Two bursts as they are set: the look and order of their matches, and the panes of each.

use crate::app::defaults::with_defaults;
use crate::app::document::{Cursor, Document, Ranges, Side};
use crate::app::pane::{Link, PaneGroup, PaneId, PaneLinks};
use crate::app::words::choices;
use serde::{Deserialize, Serialize};

choices! {
    #[derive(Default)]
    MatchColumn {
        #[default]
        Number: "#", "Number, in the order of A's features, from 0, as in files";
        UA: "u A", "Column in A at mid-burst; the first pixel's centre is 0";
        VA: "v A", "Row in A at mid-burst; the first pixel's centre is 0";
        UB: "u B", "Column in B at mid-burst; the first pixel's centre is 0";
        VB: "v B", "Row in B at mid-burst; the first pixel's centre is 0";
        SigmaA: "σ A", "Scale σ in A, pixels";
        SigmaB: "σ B", "Scale σ in B, pixels";
        SlopeA: "Slope A", "Apparent motion in A to the right, px/frame";
        SlopeB: "Slope B", "Apparent motion in B to the right, px/frame";
        Motion: "Motions", "Difference of the motions in A and B, px/frame";
        Distance: "Distance", "Distance of the descriptors";
        Ratio: "Ratio", "Distance over that to the second nearest compared";
        Error: "Error", "Distance from the geometry, pixels";
        Inlier: "Inlier", "Whether it agrees with the geometry";
    }
}

choices! {
    /// Way in which matches are drawn over the pictures.
    #[derive(Default)]
    MatchesAs {
        #[default]
        Lines: "Lines", "From picture to picture, the strongest of each part; zoom in for more";
        Vectors: "Vectors", "In A, from the place in A to that in B";
        Near: "Near pointer", "Only lines that end near the pointer";
    }
}

with_defaults! {
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct MatchLook {
        /// Whether the matches that agree with the geometry are shown; also those that were not verified.
        pub inliers: bool = true,
        pub outliers: bool = true,
        pub alone: bool = true,
        pub features: bool,
        pub geometry: bool = true,
        pub drawn_as: MatchesAs = MatchesAs::Lines,
        /// Largest number of matches that are drawn; as many as each part of the picture bears if `None`.
        pub most: Option<usize>,
        /// Whether lines have the colour of the difference of the motions.
        pub by_motion: bool,
        /// Largest difference of the motions of the matches that are shown, px/frame.
        pub max_motion: Option<f32>,
    }
}

impl MatchLook {
    pub fn shows(&self, inlier: Option<bool>) -> bool {
        if inlier == Some(false) { self.outliers } else { self.inliers }
    }

    pub(crate) fn listing(&self) -> Self {
        let Self { inliers, outliers, max_motion, .. } = *self;
        Self { inliers, outliers, max_motion, ..Self::default() }
    }

    /// Copy whose limit is a number or none: a file may contain any value.
    #[must_use]
    pub fn sanitised(self) -> Self {
        Self { max_motion: self.max_motion.filter(|max| *max >= 0.0), ..self }
    }
}

choices! {
    #[derive(Default)]
    PairTab {
        #[default]
        Matches: "Matches", "A row for each match";
        Unmatched: "Unmatched", "Features of A that are not inliers, and the step at which each was lost";
        Compared: "Compared", "Features of the burst in focus, compared with others";
    }
}

impl Document {
    pub fn bring_cursors_together(&mut self) {
        let (cursor, side) = (*self.cursor(), self.focused().side.other());
        let own = PaneId::of(side);
        let others = self.panes.shown_of(side, None);
        let alone = others.len() < 2;
        for id in others.into_iter().filter(|id| *id != own).chain([own]) {
            if let Some(pane) = self.panes.get_mut(id) {
                let kind = if alone { cursor.kind } else { pane.cursor.kind };
                (pane.cursor, pane.slope_chosen) = (Cursor { kind, ..cursor }, true);
            }
        }
    }

    /// Cursors of two bursts that are linked are brought together.
    pub fn toggle_link(&mut self, link: Link) {
        let on = !self.panes.all_share(link);
        if !self.workspace.shows_pair() {
            return self.panes.shown().into_iter().for_each(|id| self.set_link(id, link, on));
        }
        self.link_pair(link, on);
        if on && link == Link::Cursor {
            self.bring_cursors_together();
        }
    }

    /// The pane that stands for the burst of `side` in *Two bursts*: its own, or where that was closed the first one.
    pub fn pane_for(&self, side: Side) -> PaneId {
        let own = PaneId::of(side);
        let shown = self.panes.shown_in(PaneGroup::Pair);
        let first = || shown.iter().copied().find(|id| self.panes.is_on(*id, side));
        if shown.contains(&own) { own } else { first().unwrap_or(own) }
    }

    pub fn ranges_of_side(&self, side: Side) -> &Ranges {
        self.ranges_of(self.panes.of(side))
    }

    pub fn pair_links(&self) -> PaneLinks {
        let shown = self.panes.shown_in(PaneGroup::Pair);
        let all = |link| shown.iter().all(|id| self.panes.has_link(*id, link));
        let (view, cursor, display) = (all(Link::View), all(Link::Cursor), all(Link::Display));
        PaneLinks { view, cursor, display, ..PaneLinks::default() }
    }

    pub fn link_pair(&mut self, link: Link, on: bool) {
        for id in self.panes.shown_in(PaneGroup::Pair) {
            if on || self.panes.is_on(id, Side::B) {
                self.set_link(id, link, on);
            }
        }
    }

    pub fn focus_other_side(&mut self) {
        if let Some(id) = self.panes.shown_of(self.focused().side.other(), self.focused().method).first() {
            self.panes.set_focus(*id);
        }
    }
}
