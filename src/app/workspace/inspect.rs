//! One burst: scrubbing and parameters left, the panes in the middle with the table below them, the selected feature
//! and the display right.

use crate::app::actions::Queue;
use crate::app::inspector::inspector_ui;
use crate::app::panel;
use crate::app::window::BurstscopeApp;
use crate::app::workspace::{bottom_frame, side_frame, side_width};
use egui::{CentralPanel, Frame, Panel, ScrollArea};

/// Draws the workspace.
pub fn inspect_workspace_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui, queue: &mut Queue) {
    let width = side_width(ui);
    if app.model.panels.left {
        Panel::left("left").frame(side_frame(ui)).default_size(width).size_range(250.0..=420.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                panel::cursor::cursor_ui(ui, &mut app.model, queue);
                panel::parameters::parameters_ui(ui, &mut app.model, queue);
            });
        });
    }
    if app.model.panels.right {
        Panel::right("right").frame(side_frame(ui)).default_size(width).size_range(250.0..=460.0).show(ui, |ui| {
            if app.model.probe.is_in_use() {
                panel::probe::tabs_ui(ui, &mut app.model);
            }
            if app.model.probe.is_open {
                panel::probe::probe_ui(ui, &mut app.model, &mut app.probe, queue);
                return;
            }
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                panel::display::display_ui(ui, &mut app.model, &mut app.widgets);
                panel::selection::selection_ui(ui, &mut app.model, &mut app.selection, queue);
            });
        });
    }
    if app.model.panels.bottom {
        Panel::bottom("bottom")
            .frame(bottom_frame(ui))
            .resizable(true)
            .default_size(190.0)
            .size_range(90.0..=500.0)
            .show(ui, |ui| {
                panel::bottom::bottom_ui(ui, &mut app.model, &app.widgets, &mut app.regions, queue);
            });
    }
    CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
        for change in inspector_ui(ui, &mut app.model, &mut app.widgets, queue) {
            app.change_panes(change);
        }
    });
}
