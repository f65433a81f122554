//! The document of the window: all that the user has set, and nothing that was computed from it.

pub mod action;
pub mod journal;

pub use action::{Action, Pointed, Queue};
pub use journal::{Journal, Playback, Steps};

use crate::app::pane::Panes;
use crate::app::project::figure::FigureChoice;
use crate::app::project::film::FilmChoice;
use crate::app::project::filter::{Filter, Order};
use crate::app::project::lab::Lab;
use crate::app::project::look::Look;
use crate::app::project::measure::Measure;
use crate::app::project::panels::Panels;
use crate::app::project::set_up::SetUpState;
use crate::app::view::ColourBy;
use crate::burst::OpenOptions;
use crate::detector::{DetectorParams, Quantity, SearchParams, SlopeChoice};
use crate::teach::{BottomTab, Workspace};

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Document {
    pub workspace: Workspace,
    pub calibration: OpenOptions,
    /// They may be invalid while they are edited. If slopes are to be found, their grid is the one found last.
    pub params: DetectorParams,
    pub slopes: SlopeChoice,
    pub auto_detect: bool,
    pub panes: Panes,
    pub look: Look,
    pub colour_by: ColourBy,
    pub filter: Filter,
    pub order: Order<Quantity>,
    /// Index of the selected feature of A.
    pub selected: Option<usize>,
    pub set_up: SetUpState,
    pub lab: Lab,
    pub measure: Measure,
    pub figure: FigureChoice,
    pub film: FilmChoice,
    pub panels: Panels,
    pub bottom_tab: BottomTab,
    pub theme: egui::ThemePreference,
    pub playing: bool,
}

impl Document {
    pub fn set_search(&mut self, params: SearchParams) {
        (self.params, self.slopes) = (params.detector, params.slopes);
    }
}
