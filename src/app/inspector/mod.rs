//! The inspector's middle: panes in any arrangement, what each of them shows, and what they share.
//!
//! `egui_tiles` draws the arrangement and lets it be dragged; everything in a pane is drawn here: its header, its
//! picture with features, another picture over it, and the marks of the place that is pointed at elsewhere. What a menu
//! or button of a pane asks for that changes other panes is collected as [`Change`]s and done after all panes are
//! drawn.

mod behaviour;
mod header;
mod icons;
mod marks;
mod menu;
mod menu_place;
mod pane_ui;
mod picture_menu;
mod probe_marks;
mod slice_ui;
mod widgets;

pub use header::compact_description;
pub(in crate::app) use marks::same_place;
pub use menu::Change;
pub(in crate::app) use pane_ui::chip_ui;
pub use pane_ui::{Drawn, over_handle_ui, picture_ui};
pub(in crate::app) use picture_menu::copy_ui;
pub use widgets::{PaneWidget, PaneWidgets, PlaceValue};

use super::actions::Queue;
use super::pane::{arrangement_of, tree_of};
use crate::app::project::Model;
use behaviour::Inspector;
use egui::Ui;

/// Draws all panes. Answers what is to be changed in other panes than the one that asked.
pub fn inspector_ui(ui: &mut Ui, model: &mut Model, widgets: &mut PaneWidgets, queue: &mut Queue) -> Vec<Change> {
    let mut tree = tree_of(model.panes.arrangement());
    let mut inspector = Inspector { model, widgets, queue, drawn: Vec::new(), changes: Vec::new() };
    tree.ui(&mut inspector, ui);
    let Inspector { model, widgets, drawn, changes, .. } = inspector;
    if let Some(arrangement) = arrangement_of(&tree) {
        model.panes.rearrange(arrangement);
    }
    marks::marks_ui(model, widgets, &drawn);
    probe_marks::probe_ui(ui, model, &drawn);
    changes
}
