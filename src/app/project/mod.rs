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
use crate::detector::{DetectorParams, SearchParams, SlopeChoice};
use crate::engine::Wanted;
use crate::figures::FiguresJob;
use crate::requests::{Picture, PictureRequest};
use compare::Compare;
use datasets::Datasets;
use explained::{CoherenceState, ExplainedState};
use figure::FigureChoice;
use film::FilmChoice;
use filter::{Column, Filter, Order};
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

/// Everything that the window shows.
#[derive(Debug, Default)]
pub struct Model {
    /// Options with which bursts are opened: bias and flat frame, black and full scale, linear light.
    pub calibration: OpenOptions,
    /// The open workspace.
    pub workspace: Workspace,
    /// The two bursts with what was found in each.
    pub slots: Sides<Slot>,
    /// The parameters as they are being edited; they may be invalid for the moment. If slopes are to be found, their
    /// grid is the one found last.
    pub params: DetectorParams,
    /// Choice of the slopes: found or given.
    pub slopes: SlopeChoice,
    /// The panes that show pictures, each with its own cursor.
    pub panes: Panes,
    /// The motion-stack image at the selected feature's slope.
    pub patch: Option<Picture>,
    /// The request for this image.
    pub wanted_patch: Wanted<PictureRequest>,
    /// Requests for the pictures of panes.
    pub(in crate::app) wanted_pictures: HashMap<PaneId, Wanted<PictureRequest>>,
    /// Index of the selected feature.
    pub selected: Option<usize>,
    /// Index of the feature under the pointer, in the picture or in the table.
    pub hovered: Option<usize>,
    /// Feature to be selected when the next detection ends.
    pub reselect: Option<SavedSelection>,
    /// Filter of the features that are shown.
    pub filter: Filter,
    /// The table's order.
    pub order: Order<Column>,
    /// Indices of the features that pass the filter, in the table's order; see [`Model::refresh_listed`].
    pub listed: Vec<usize>,
    /// The ranges and maps that panes share, and what is drawn over pictures.
    pub look: Look,
    /// Property by which features are coloured.
    pub colour_by: ColourBy,
    /// Light, dark, or as the system.
    pub theme: egui::ThemePreference,
    /// Whether a detection starts automatically after a change.
    pub auto_detect: bool,
    /// Whether the cursor is playing through the slopes.
    pub playing: bool,
    /// Open parts of the window.
    pub panels: Panels,
    /// Width of the window, in points.
    pub window_width_points: f32,
    /// The open tab below the picture.
    pub bottom_tab: BottomTab,
    /// The second burst, and the matches with it.
    pub pair: PairState,
    /// Several methods on the same burst.
    pub compare: Compare,
    /// Errors and the last note.
    pub messages: Messages,
    /// Contents and style of figures.
    pub figure: FigureChoice,
    /// Contents, rate and size of a film.
    pub film: FilmChoice,
    /// Steps that can be undone and redone.
    pub history: History,
    /// A line and a rectangle on a picture.
    pub measure: Measure,
    /// Explanations of the detection on show: slopes and candidates.
    pub explained: ExplainedState,
    /// Coherences of the features: how evenly the frames contribute to each.
    pub coherence: CoherenceState,
    /// The place that is probed.
    pub probe: ProbeModel,
    /// Whether a lesson is open; everything here then belongs to it.
    pub in_lesson: bool,
    /// The request for the figures of the paper.
    pub figures: Wanted<FiguresJob>,
    /// The open dataset, and the work on it.
    pub datasets: Datasets,
    /// An estimated and a true trajectory.
    pub trajectories: Trajectories,
    /// Studies of charts.
    pub lab: lab::Lab,
    /// Camera and scene, from which slopes are computed and by which slopes are read as depths.
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

    /// Number of frames of the open burst; 0 without one.
    pub fn frame_count(&self) -> usize {
        self.slots.a.burst.as_ref().map_or(0, |b| b.burst.len())
    }

    /// Parameters for a detection now. Slopes that are to be found are not part of them.
    pub fn asked(&self) -> SearchParams {
        self.asked_of(Side::A)
    }

    /// Sets the detector's parameters and the choice of slopes from `params`.
    pub fn set_search(&mut self, params: SearchParams) {
        (self.params, self.slopes) = (params.detector, params.slopes);
    }

    /// Whether `side` has an open burst and valid parameters, but no detection with these parameters.
    pub fn needs_detection(&self, side: Side) -> bool {
        let slot = &self.slots[side];
        let is_made = |found: &FoundFeatures| found.asked == self.asked_of(side);
        slot.burst.is_some() && slot.param_error.is_none() && !slot.found.as_ref().is_some_and(is_made)
    }
}

#[cfg(test)]
pub(in crate::app) mod tests;
