//! Centre of *Inspect*, *Two bursts* and *Methods*: panes in any arrangement, their content and links.
//!
//! `egui_tiles` draws the arrangement and lets it be dragged; this module draws the content of a pane: its header, its
//! picture with features, another picture over it, and the mark of the place under the pointer of another pane.
//! Requests of a pane's menu or buttons that change other panes are collected as [`Change`]s and run after all panes
//! are drawn.

mod behaviour;
mod empty;
mod header;
mod icons;
mod joined;
mod marks;
mod menu;
mod menu_place;
mod method;
mod names;
mod pane_ui;
mod picture_menu;
mod probe_marks;
mod slice_ui;
mod widgets;

pub use joined::{JoinedPanes, joined_panes};
pub(in crate::app) use marks::same_place;
pub use menu::Change;
pub use names::compact_description;
pub use pane_ui::Drawn;
pub(in crate::app) use pane_ui::chip_ui;
pub(in crate::app) use picture_menu::{copy_ui, match_menu_ui};
pub(in crate::app) use probe_marks::is_with_shift;
pub use widgets::{PaneWidget, PaneWidgets, PlaceValue};

use super::actions::Queue;
use super::pane::{PaneId, arrangement_of, tree_of};
use crate::app::project::Model;
use crate::app::project::workspace::Workspace;
use behaviour::Inspector;
use egui::Ui;

/// Result of drawing all panes.
pub struct Inspected {
    /// Drawn panes with a picture, in the order of drawing.
    pub drawn: Vec<(PaneId, Drawn)>,
    /// Requested changes of the set of panes.
    pub changes: Vec<Change>,
}

/// Draws all panes of the open workspace.
pub fn inspector_ui(ui: &mut Ui, model: &mut Model, widgets: &mut PaneWidgets, queue: &mut Queue) -> Inspected {
    widgets.begin_pass();
    let mut tree = tree_of(model.panes.arrangement());
    let mut inspector = Inspector { model, widgets, queue, drawn: Vec::new(), changes: Vec::new() };
    tree.ui(&mut inspector, ui);
    let Inspector { model, widgets, drawn, changes, .. } = inspector;
    if let Some(arrangement) = arrangement_of(&tree) {
        model.panes.rearrange(arrangement);
    }
    marks::marks_ui(model, widgets, &drawn);
    if matches!(model.workspace, Workspace::Inspect | Workspace::Pair) {
        probe_marks::probe_ui(ui, model, &drawn);
    }
    Inspected { drawn, changes }
}
