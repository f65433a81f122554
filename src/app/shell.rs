//! Where everything is: menus and toolbar above, the open room in the middle, the status below.

use super::actions::{Queue, menu::menu_bar_ui};
use super::panels;
use super::window::BurstscopeApp;
use egui::{CentralPanel, Frame, Margin, Panel};

/// Draws the whole window except what floats over it.
pub fn shell_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui, queue: &mut Queue) {
    let mut open_recent = None;
    let bar = |ui: &egui::Ui| Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 3));

    Panel::top("menu bar").frame(bar(ui)).show(ui, |ui| {
        ui.horizontal(|ui| {
            menu_bar_ui(ui, &app.model, app.recent(), queue, &mut open_recent);
            super::rooms::switch_ui(ui, &app.model, queue);
        });
    });
    Panel::top("toolbar").frame(bar(ui)).show(ui, |ui| panels::toolbar::toolbar_ui(ui, &app.model, queue));
    Panel::bottom("status bar")
        .frame(bar(ui))
        .show(ui, |ui| panels::status::status_ui(ui, &app.model, app.readout(), queue));

    if app.model.burst.is_none() {
        CentralPanel::default().show(ui, |ui| {
            panels::welcome::welcome_ui(ui, &app.model, app.recent(), queue, &mut open_recent);
        });
    } else {
        super::rooms::room_ui(app, ui, queue);
    }
    panels::welcome::drop_hint_ui(ui.ctx());
    if let Some(source) = open_recent {
        app.open(source);
    }
}
