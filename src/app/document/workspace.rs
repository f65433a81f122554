//! The workspaces, a record each: which bursts are on show, and what keys and panels that all of them have do there.

use crate::app::document::panes::{Change, Tool};
use crate::app::document::{Document, FeaturesShown, Side};
use crate::app::pane::{PaneGroup, PaneId, Preset, SidesPreset};
use crate::teach::Workspace;

/// Settings of a workspace; `app::workspace` draws it.
pub struct Record {
    /// Bursts whose pictures are on show. Where there are two, rows are their matches, and else features of A.
    pub sides: &'static [Side],
    /// Whether features, candidates and places of A are examined, with tools that measure.
    pub inspects: bool,
    pub is_of_dataset: bool,
    pub right: Right,
    /// Arrangements of the panes for the menu of a pane, with name and meaning.
    pub layouts: fn(PaneId) -> Vec<(&'static str, &'static str, Change)>,
    pub draws_features: fn(&Document) -> bool,
    pub toggle_features: fn(&mut Document),
    pub selected: fn(&Document) -> Option<usize>,
    pub select: fn(&mut Document, Option<usize>),
    pub clear_selection: fn(&mut Document),
}

/// When the panel on the right opens by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Right {
    Always,
    WithFeature,
    WithMatch,
}

const OF_FEATURES: Record = Record {
    sides: &[],
    inspects: false,
    is_of_dataset: false,
    right: Right::Always,
    layouts: |id| Preset::ALL.map(|(preset, name, help)| (name, help, Change::LayOut(id, preset))).to_vec(),
    draws_features: |document| document.look.overlay != FeaturesShown::None,
    toggle_features: |document| document.look.overlay = document.look.overlay.next(),
    selected: |document| document.selected,
    select: |document, row| document.selected = row,
    clear_selection: |document| (document.selected, document.comparisons.a.selected) = (None, None),
};

const INSPECT: Record = Record { sides: &[Side::A], inspects: true, right: Right::WithFeature, ..OF_FEATURES };

const PAIR: Record = Record {
    sides: &Side::BOTH,
    right: Right::WithMatch,
    layouts: |_| SidesPreset::ALL.map(|to| (to.words()[0], to.words()[1], Change::LayOutSides(to))).to_vec(),
    draws_features: |document| document.match_look.features,
    toggle_features: |document| document.match_look.features ^= true,
    selected: |document| document.selected_match,
    select: |document, row| document.selected_match = row,
    clear_selection: |document| (document.selected_match, document.asked_about) = (None, None),
    ..OF_FEATURES
};

const OF_DATASET: Record = Record { is_of_dataset: true, ..OF_FEATURES };

impl Workspace {
    pub fn record(self) -> &'static Record {
        match self {
            Self::Inspect => &INSPECT,
            Self::Pair => &PAIR,
            Self::Matches | Self::Trajectories => &OF_DATASET,
            Self::Lab => &OF_FEATURES,
        }
    }

    pub fn inspects(self) -> bool {
        self.record().inspects
    }

    pub fn shows_pair(self) -> bool {
        self.record().sides.contains(&Side::B)
    }

    /// Whether it shows a burst, and has nothing to show while none is open.
    pub fn needs_burst(self) -> bool {
        !self.record().sides.is_empty()
    }

    /// Bursts whose features are found by key; those of A also where no burst is on show.
    pub fn detects(self) -> &'static [Side] {
        if self.shows_pair() { &Side::BOTH } else { &[Side::A] }
    }

    pub fn probes(self) -> bool {
        self.inspects() || self.shows_pair()
    }
}

impl Document {
    pub fn compares_methods(&self) -> bool {
        self.workspace.inspects() && self.panes.open == PaneGroup::Methods
    }

    /// Index of the selected feature, or of the selected match where two bursts are on show.
    pub fn selected_row(&self) -> Option<usize> {
        (self.workspace.record().selected)(self)
    }

    pub fn select_row(&mut self, row: Option<usize>) {
        (self.workspace.record().select)(self, row);
    }

    /// Puts the tool away that is in hand; without one selects nothing.
    pub fn clear_selection(&mut self) {
        match self.measure.tool {
            Tool::Pan => (self.workspace.record().clear_selection)(self),
            tool => self.measure.toggle(tool),
        }
    }
}
