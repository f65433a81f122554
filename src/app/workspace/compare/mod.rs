//! Several methods on the same burst: which of them and how they are laid out left, their pictures in the middle, the
//! table of their numbers below.

mod controls;
mod layouts;
mod matches;
mod pane;
mod pictures;
mod table;

use crate::app::actions::Queue;
use crate::app::panel;
use crate::app::window::BurstscopeApp;
use crate::app::workspace::{bottom_frame, side_frame, side_width};
use egui::{CentralPanel, Frame, Panel, ScrollArea};
pub use pictures::ComparePictures;

/// Draws the workspace.
pub fn compare_workspace_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui, queue: &mut Queue) {
    let width = side_width(ui);
    if app.model.panels.left {
        Panel::left("compare left").frame(side_frame(ui)).default_size(width).size_range(250.0..=420.0).show(
            ui,
            |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    controls::controls_ui(ui, &mut app.model, queue);
                    panel::cursor::cursor_ui(ui, &mut app.model, queue);
                    panel::parameters::parameters_ui(ui, &mut app.model, queue);
                });
            },
        );
    }
    if app.model.panels.right {
        Panel::right("compare right").frame(side_frame(ui)).default_size(width).size_range(250.0..=460.0).show(
            ui,
            |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    panel::display::ranges_ui(ui, &mut app.model, &mut app.widgets);
                });
            },
        );
    }
    if app.model.panels.bottom {
        Panel::bottom("compare bottom")
            .frame(bottom_frame(ui))
            .resizable(true)
            .default_size(160.0)
            .size_range(90.0..=400.0)
            .show(ui, |ui| table::table_ui(ui, &mut app.model));
    }
    CentralPanel::default().frame(Frame::new()).show(ui, |ui| layouts::layouts_ui(ui, app));
}
