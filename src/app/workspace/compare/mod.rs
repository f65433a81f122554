//! Several methods on one burst: their choice and layout on the left, a pane for each, or any other arrangement of
//! their inputs, in the centre, the table of their numbers below.

mod controls;
mod lines;
mod table;

use crate::app::inspector::{Change, inspector_ui};
use crate::app::panel;
use crate::app::workspace::{WorkspaceParts, bottom_panel, side_frame, side_width};
use egui::{CentralPanel, Frame, Panel, ScrollArea, Ui};

/// Draws the workspace. Returns the panes' requests.
pub(super) fn compare_workspace_ui(ui: &mut Ui, parts: &mut WorkspaceParts<'_>) -> Vec<Change> {
    let WorkspaceParts { model, widgets, queue, .. } = parts;
    let width = side_width(ui);
    let mut changes = Vec::new();
    if model.panels.left {
        let panel = Panel::left("compare left").frame(side_frame(ui)).default_size(width).size_range(250.0..=420.0);
        panel.show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                changes.extend(controls::controls_ui(ui, model, queue));
                panel::cursor::cursor_ui(ui, model, queue);
                panel::parameters::parameters_ui(ui, model, queue);
            });
        });
    }
    if model.panels.right {
        let panel = Panel::right("compare right").frame(side_frame(ui)).default_size(width).size_range(250.0..=460.0);
        panel.show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| panel::display::ranges_ui(ui, model, widgets));
        });
    }
    if model.panels.bottom {
        bottom_panel(ui, "compare bottom", 233.0, |ui| table::table_ui(ui, model));
    }
    CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
        if model.contenders().is_empty() {
            ui.centered_and_justified(|ui| ui.weak("Choose methods in the table below"));
            return;
        }
        let inspected = inspector_ui(ui, model, widgets, queue);
        lines::lines_ui(ui, model, &inspected.drawn);
        changes.extend(inspected.changes);
    });
    changes
}
