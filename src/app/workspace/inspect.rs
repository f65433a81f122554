//! One burst: cursor and parameters on the left, the panes in the centre with the table below them, the selected
//! feature and the display on the right.

use crate::app::inspector::{Change, inspector_ui};
use crate::app::panel;
use crate::app::project::BottomTab;
use crate::app::workspace::{WorkspaceParts, bottom_panel, side_frame, side_width};
use egui::{CentralPanel, Frame, Panel, ScrollArea};

/// Draws the workspace. Returns the panes' requests.
pub(super) fn inspect_workspace_ui(ui: &mut egui::Ui, parts: &mut WorkspaceParts<'_>) -> Vec<Change> {
    let WorkspaceParts { model, widgets, selection, probe, regions, queue, .. } = parts;
    let width = side_width(ui);
    if model.panels.left {
        Panel::left("left").frame(side_frame(ui)).default_size(width).size_range(250.0..=420.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                panel::cursor::cursor_ui(ui, model, queue);
                panel::parameters::parameters_ui(ui, model, queue);
            });
        });
    }
    if model.panels.right {
        Panel::right("right").frame(side_frame(ui)).default_size(width).size_range(250.0..=460.0).show(ui, |ui| {
            let other = ("Display and feature", "The value range of the pictures, and the selected feature");
            if panel::probe::probe_tab_ui(ui, model, probe, other, queue) {
                return;
            }
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                panel::display::display_ui(ui, model, widgets);
                panel::selection::selection_ui(ui, model, selection, queue);
            });
        });
    }
    let mut over_rows = None;
    if model.panels.bottom {
        let show = |ui: &mut egui::Ui| panel::bottom::bottom_ui(ui, model, widgets, regions, queue);
        let is_over = bottom_panel(ui, "bottom", 276.0, show);
        over_rows = Some(model.bottom_tab).filter(|_| is_over);
    }
    let pictures = CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
        crate::app::parts::mark(ui, crate::teach::Part::Pictures, ui.max_rect());
        inspector_ui(ui, model, widgets, queue)
    });
    // A hovered feature stays marked while the pointer is over it, in a picture or in a row of the open table.
    if pictures.inner.drawn.iter().all(|(_, drawn)| drawn.output.pointer_ui.is_none()) {
        model.hovered = model.hovered.filter(|_| over_rows == Some(BottomTab::Table));
        let against = &mut model.slots.a.against;
        against.hovered = against.hovered.filter(|_| over_rows == Some(BottomTab::Compared));
        model.explained.pointed = None;
    }
    pictures.inner.changes
}
