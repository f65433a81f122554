//! The model of the window, as plain values: bursts, parameters, panes, features, messages.
//!
//! The [`Model`] draws nothing. Panels read and change it; in each pass it takes the engine's answers, and then
//! requests what is missing.

mod asking;
pub mod compare;
pub mod comparison;
pub mod cursor;
pub mod datasets;
pub mod effect;
pub mod explained;
pub mod figure;
pub mod film;
pub mod filter;
pub mod history;
pub mod lab;
pub mod look;
pub mod measure;
pub mod messages;
pub mod method;
pub mod own;
pub mod pair;
pub mod panels;
pub mod panes;
mod part;
mod pictures;
pub mod probe;
pub mod set_up;
pub mod side;
pub mod slot;
pub mod staged;
pub mod trajectories;

pub use crate::teach::BottomTab;
pub use effect::Effect;
pub use panels::{Panels, Visibility};
pub use slot::{FoundFeatures, SavedSelection, Stale};

pub mod workspace {
    pub use crate::teach::Workspace;
}

use crate::app::document::{Document, Pointed};
use crate::app::pane::PaneId;
use crate::app::project::history::History;
use crate::burst::Positions;
use crate::detector::SearchParams;
use crate::engine::Wanted;
use crate::figures::FiguresJob;
use crate::requests::{Picture, PictureRequest};
use compare::Compare;
use datasets::Datasets;
use explained::{CoherenceState, ExplainedState};
use messages::Messages;
use pair::PairState;
use probe::ProbeResults;
use side::{Side, Sides};
use slot::Slot;
use std::collections::HashMap;
use std::ops::{Deref, DerefMut};
use trajectories::TrajectoryResults;

/// All of the window: the project on show, and what stays when another is shown. All that is read of the project, and
/// of its document, is read as if it were its own.
#[derive(Debug, Default)]
pub struct Model {
    pub project: Project,
    of_user: Option<Box<staged::UserProject>>,
    pub window_width_points: f32,
    pub messages: Messages,
    pub figures: Wanted<FiguresJob>,
    pub datasets: Datasets,
    pub studies: lab::Studies,
}

/// The document, and what the engine answered about its bursts.
#[derive(Debug, Default)]
pub struct Project {
    pub document: Document,
    pub slots: Sides<Slot>,
    pub pictures: HashMap<PaneId, PanePicture>,
    pub patch: Option<Picture>,
    pub wanted_patch: Wanted<PictureRequest>,
    pub hovered: Option<usize>,
    pub reselect: Option<SavedSelection>,
    /// Indices of the features that pass the filter, in the table's order; see [`Model::refresh_listed`].
    pub listed: Vec<usize>,
    pub pair: PairState,
    pub compare: Compare,
    pub history: History,
    pub explained: ExplainedState,
    pub coherence: CoherenceState,
    pub probed: ProbeResults,
    pub poses: TrajectoryResults,
    /// What was set for another burst than the open one, until the user decides on it.
    pub left_behind: Option<own::Own>,
    play: panes::Play,
    listed_for: Option<filter::ListedFor>,
}

/// Picture of a pane: the last one of its burst, why the last request failed, and the request.
#[derive(Debug, Default)]
pub struct PanePicture {
    pub picture: Option<Picture>,
    pub problem: Option<(PictureRequest, String)>,
    pub wanted: Wanted<PictureRequest>,
}

impl Deref for Model {
    type Target = Project;

    fn deref(&self) -> &Project {
        &self.project
    }
}

impl DerefMut for Model {
    fn deref_mut(&mut self) -> &mut Project {
        &mut self.project
    }
}

impl Deref for Project {
    type Target = Document;

    fn deref(&self) -> &Document {
        &self.document
    }
}

impl DerefMut for Project {
    fn deref_mut(&mut self) -> &mut Document {
        &mut self.document
    }
}

impl From<Document> for Model {
    fn from(document: Document) -> Self {
        Self { project: Project { document, ..Project::default() }, ..Self::default() }
    }
}

impl Model {
    /// (columns, rows) of the open burst's frames; (0, 0) without one.
    pub fn size(&self) -> (usize, usize) {
        self.slots.a.burst.as_ref().map_or((0, 0), |b| b.burst.size())
    }

    /// Things under the pointer.
    pub fn pointed(&self) -> impl PartialEq + use<> {
        let probe = (self.probed.pointer, self.probed.as_dots.clone());
        let rows = self.slots.both().map(|slot| slot.comparison.hovered);
        (self.hovered, self.explained.pointed, rows, self.pair.hovered, self.poses.hovered, probe)
    }

    pub fn point_at(&mut self, pointed: Pointed) {
        match pointed {
            Pointed::Feature(index) => self.hovered = index,
            Pointed::Candidate(index) => self.explained.pointed = index,
            Pointed::Row(side, row) => self.slots[side].comparison.hovered = row,
            Pointed::Match(index) => self.pair.hovered = index,
            Pointed::Camera(index) => self.poses.hovered = index,
            Pointed::Place(place) => self.probed.pointer = place,
            Pointed::Dots(features) => self.probed.as_dots = features,
            Pointed::Lines(drawn, all) => self.pair.lines_drawn = (drawn, all),
        }
    }

    pub fn frame_count(&self) -> usize {
        self.slots.a.burst.as_ref().map_or(0, |b| b.burst.len())
    }

    /// Positions of the frames of A that are searched; those of ten frames where nothing is open.
    pub fn used_positions(&self) -> Positions {
        let all = self.slots.a.burst.as_ref().map_or_else(|| Positions::even(10), |open| open.burst.positions.clone());
        all.part(self.params.used_frames(all.len()))
    }

    pub fn asked(&self) -> SearchParams {
        self.asked_of(Side::A)
    }

    pub fn needs_detection(&self, side: Side) -> bool {
        let slot = &self.slots[side];
        let is_made = |found: &FoundFeatures| found.asked == self.asked_of(side);
        slot.burst.is_some() && slot.param_error.is_none() && !slot.found.as_ref().is_some_and(is_made)
    }
}

#[cfg(test)]
pub(in crate::app) mod tests;
