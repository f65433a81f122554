//! The model of the window, as plain values: bursts, parameters, panes, features, messages.
//!
//! The [`Model`] draws nothing. Panels read and change it; in each pass it takes the engine's answers, and then
//! requests what is missing.

pub mod against;
mod asking;
pub mod compare;
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
pub mod pair;
pub mod panels;
pub mod panes;
mod pictures;
pub mod probe;
pub mod set_up;
pub mod side;
pub mod slot;
pub mod trajectories;

pub use crate::teach::BottomTab;
pub use effect::Effect;
pub use panels::{Panels, Visibility};
pub use slot::{FoundFeatures, SavedSelection, Stale};

pub mod workspace {
    pub use crate::teach::Workspace;
}

use crate::app::pane::{PaneId, Panes};
use crate::app::project::history::History;
use crate::app::view::ColourBy;
use crate::burst::OpenOptions;
use crate::detector::{DetectorParams, Quantity, SearchParams, SlopeChoice};
use crate::engine::Wanted;
use crate::figures::FiguresJob;
use crate::requests::{Picture, PictureRequest};
use compare::Compare;
use datasets::Datasets;
use explained::{CoherenceState, ExplainedState};
use figure::FigureChoice;
use film::FilmChoice;
use filter::{Filter, Order};
use look::Look;
use measure::Measure;
use messages::Messages;
use pair::PairState;
use probe::ProbeModel;
use set_up::SetUpState;
use side::{Side, Sides};
use slot::Slot;
use std::collections::HashMap;
use trajectories::Trajectories;
use workspace::Workspace;

#[derive(Debug, Default)]
pub struct Model {
    pub calibration: OpenOptions,
    pub workspace: Workspace,
    pub slots: Sides<Slot>,
    /// They may be invalid while they are edited. If slopes are to be found, their grid is the one found last.
    pub params: DetectorParams,
    pub slopes: SlopeChoice,
    pub panes: Panes,
    pub patch: Option<Picture>,
    pub wanted_patch: Wanted<PictureRequest>,
    pub(in crate::app) wanted_pictures: HashMap<PaneId, Wanted<PictureRequest>>,
    pub selected: Option<usize>,
    pub hovered: Option<usize>,
    pub reselect: Option<SavedSelection>,
    pub filter: Filter,
    pub order: Order<Quantity>,
    /// Indices of the features that pass the filter, in the table's order; see [`Model::refresh_listed`].
    pub listed: Vec<usize>,
    pub look: Look,
    pub colour_by: ColourBy,
    pub theme: egui::ThemePreference,
    pub auto_detect: bool,
    pub playing: bool,
    pub panels: Panels,
    pub window_width_points: f32,
    pub bottom_tab: BottomTab,
    pub pair: PairState,
    pub compare: Compare,
    pub messages: Messages,
    pub figure: FigureChoice,
    pub film: FilmChoice,
    pub history: History,
    pub measure: Measure,
    pub explained: ExplainedState,
    pub coherence: CoherenceState,
    pub probe: ProbeModel,
    pub in_lesson: bool,
    pub figures: Wanted<FiguresJob>,
    pub datasets: Datasets,
    pub trajectories: Trajectories,
    pub lab: lab::Lab,
    pub set_up: SetUpState,
    play: panes::Play,
    set_explicitly: panes::SetExplicitly,
    listed_for: Option<filter::ListedFor>,
}

impl Model {
    /// (columns, rows) of the open burst's frames; (0, 0) without one.
    pub fn size(&self) -> (usize, usize) {
        self.slots.a.burst.as_ref().map_or((0, 0), |b| b.burst.size())
    }

    pub fn frame_count(&self) -> usize {
        self.slots.a.burst.as_ref().map_or(0, |b| b.burst.len())
    }

    pub fn asked(&self) -> SearchParams {
        self.asked_of(Side::A)
    }

    pub fn set_search(&mut self, params: SearchParams) {
        (self.params, self.slopes) = (params.detector, params.slopes);
    }

    pub fn needs_detection(&self, side: Side) -> bool {
        let slot = &self.slots[side];
        let is_made = |found: &FoundFeatures| found.asked == self.asked_of(side);
        slot.burst.is_some() && slot.param_error.is_none() && !slot.found.as_ref().is_some_and(is_made)
    }
}

#[cfg(test)]
pub(in crate::app) mod tests;
