//! The document of the window: all that the user has set, and nothing that was computed from it.

pub mod action;
pub mod comparison;
pub mod cursor;
pub mod datasets;
pub mod export;
pub mod filter;
pub mod history;
pub mod journal;
pub mod lab;
pub mod look;
pub mod method;
pub mod pair;
pub mod panes;
pub mod probe;
pub mod side;
pub mod workspace;

pub use action::{Action, Pointed, Queue, Reselect, Staged};
pub use comparison::{Compared, Comparison, Reference};
pub use cursor::{Cursor, PlayOver, Playing};
pub use datasets::{BurstPair, DatasetChoice, PairChoice, PairColumn, Trajectories};
pub use export::{ExportKind, FigureChoice, FilmChoice, FilmContent, Purpose};
pub use filter::{Filter, Interval, Order, SavedMatch, SavedSelection};
pub use history::History;
pub use journal::{Journal, Playback, Steps};
pub use lab::{Lab, LabQuestion, LabSet};
pub use look::{FeaturesShown, Look, RangeClass, Ranges};
pub use method::{CompareLook, MethodId};
pub use pair::{MatchColumn, MatchLook, MatchesAs, PairTab};
pub use panes::{Destination, Measure, Panels, Visibility};
pub use probe::{PinnedPlace, Probe, SetUpState};
pub use side::{Side, Sides};

use crate::app::{pane::Panes, view::ColourBy};
use crate::burst::OpenOptions;
use crate::detector::params::doc;
use crate::detector::{ParamChange, Quantity, SearchParams, Test};
use crate::evaluate::poses::is_built_in;
use crate::inspect::pair::Lost;
use crate::matching::MatchParams;
use crate::requests::{BurstSource, make_absolute};
use crate::teach::{BottomTab, Workspace};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default = "Document::of_new_window", deny_unknown_fields)]
pub struct Document {
    pub workspace: Workspace,
    /// Options with which A is opened, and B too unless it has its own.
    pub calibration: OpenOptions,
    pub calibration_of_b: Option<OpenOptions>,
    /// They may be invalid while they are edited.
    pub params: SearchParams,
    pub auto_detect: bool,
    pub panes: Panes,
    pub look: Look,
    pub colour_by: ColourBy,
    pub filter: Filter,
    pub order: Order<Quantity>,
    /// Index of the selected feature of A.
    pub selected: Option<usize>,
    pub set_up: SetUpState,
    pub probe: Probe,
    /// Of all bursts: another burst begins without, and a burst that is opened again has its places again.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<PinnedPlace>,
    pub comparisons: Sides<Comparison>,
    /// Test whose rejected candidates are marked.
    pub shown_test: Option<Test>,
    pub selected_candidate: Option<usize>,
    pub matching: MatchParams,
    pub match_look: MatchLook,
    pub match_order: Order<MatchColumn>,
    pub pair_tab: PairTab,
    pub selected_match: Option<usize>,
    /// Feature of A of which the user asks why it has no match.
    pub asked_about: Option<usize>,
    pub hidden_losses: Vec<Lost>,
    pub methods: CompareLook,
    /// Sharp images of A's and of B's view.
    pub gold: Sides<Option<BurstSource>>,
    pub dataset: Option<DatasetChoice>,
    pub pairs: PairChoice,
    pub trajectories: Trajectories,
    pub lab: Lab,
    pub measure: Measure,
    pub figure: FigureChoice,
    pub film: FilmChoice,
    pub panels: Panels,
    pub bottom_tab: BottomTab,
    pub theme: egui::ThemePreference,
    pub playing: bool,
    pub play: Playing,
    /// Whether the place under the pointer is shown at its own motion.
    pub follows_focus: bool,
}

impl Document {
    /// Values that a file leaves out are these too.
    pub fn of_new_window() -> Self {
        Self { theme: egui::ThemePreference::Dark, auto_detect: true, ..Self::default() }
    }

    /// The document with absolute paths, so that it can be opened from any folder.
    #[must_use]
    pub fn with_absolute_paths(mut self) -> Self {
        let [compared_a, compared_b] = [&mut self.comparisons.a.file, &mut self.comparisons.b.file];
        let calibrations = [&mut self.calibration].into_iter().chain(&mut self.calibration_of_b);
        calibrations.flat_map(OpenOptions::paths_mut).for_each(make_absolute);
        for path in self.trajectories.paths_mut().into_iter().chain([compared_a, compared_b]) {
            path.iter_mut().filter(|path| !is_built_in(path)).for_each(make_absolute);
        }
        for side in Side::BOTH {
            self.gold[side] = self.gold[side].as_ref().map(BurstSource::absolute);
        }
        if let Some(DatasetChoice { source, folder, .. }) = &mut self.dataset {
            source.paths.iter_mut().chain(folder).for_each(make_absolute);
        }
        self
    }

    pub fn show_set_up(&mut self) {
        self.open_workspace(Workspace::Inspect);
        (self.bottom_tab, self.panels.bottom) = (BottomTab::Slopes, Visibility::Open);
        self.set_up.is_open = true;
    }

    /// Sets the look but its value ranges; they begin anew where the smoothing changes: less noise spans less.
    pub fn set_look(&mut self, look: Look) {
        if look.smoothing_px != self.look.smoothing_px {
            self.focused_ranges_mut().forget();
        }
        self.look = Look { ranges: self.look.ranges, ..look };
    }

    /// Reads slopes as depths, or no longer; colours that would show depths then show slopes.
    pub fn read_depths(&mut self, reads_depths: bool) {
        self.set_up.reads_depths = reads_depths;
        if !reads_depths && self.colour_by == ColourBy::Of(Quantity::Depth) {
            self.colour_by = ColourBy::default();
        }
    }

    /// Makes changes of single parameters, which may be invalid while they are edited. A range makes slopes given ones.
    pub fn change(&mut self, changes: &[ParamChange]) {
        for ParamChange { parameter, value } in changes {
            // What cannot be read is of no parameter: the value stays.
            let _ = parameter.read(&mut self.params, value);
        }
    }

    /// The action that leads to `after`: changes of the parameters that differ, so that others that are changed in the
    /// same pass stay, or all of them where a value that makes no sense cannot be written.
    pub fn action_to(&self, after: SearchParams) -> Option<Action> {
        let mut reached = Self { params: self.params.clone(), ..Self::default() };
        let mut changes = Vec::new();
        for record in doc::ALL {
            // A line on which slopes are found is written after that they are.
            let begins = record == doc::SLOPES && after.slopes.is_auto() && after.slopes != reached.params.slopes;
            if begins || record.text(&reached.params) != record.text(&after) && record != doc::SLOPES {
                let change = ParamChange::new(record, record.text(&after));
                reached.change(std::slice::from_ref(&change));
                changes.push(change);
            }
        }
        match reached.params == after {
            true => (!changes.is_empty()).then_some(Action::Change(changes)),
            false => Some(Action::SetSearch(Box::new(after))),
        }
    }
}
