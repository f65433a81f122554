//! Where everything is: menus and toolbar above, scrubbing and parameters left, the picture in the middle with the table below it, the selected
//! feature and the display right, the status below.

use super::actions::{Queue, menu::menu_bar_ui};
use super::dataset::filmstrip;
use super::panels;
use super::settings::Recent;
use super::window::BurstscopeApp;
use egui::{CentralPanel, Frame, Margin, Panel, ScrollArea};

/// Draws the whole window except what floats over it.
pub fn shell_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui, queue: &mut Queue) {
    let mut open_recent = None;
    let mut open_burst = None;
    // On a small screen the picture needs the room more than the panels do.
    let side_width = (0.235 * ui.available_width()).clamp(256.0, 300.0);
    let bar = |ui: &egui::Ui| Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 3));
    let side =
        |ui: &egui::Ui| Frame::side_top_panel(ui.style()).inner_margin(Margin { left: 8, right: 5, top: 6, bottom: 4 });

    Panel::top("menu bar").frame(bar(ui)).show(ui, |ui| {
        ui.horizontal(|ui| {
            menu_bar_ui(ui, &app.model, app.remembered(), queue, &mut open_recent);
        });
    });
    Panel::top("toolbar").frame(bar(ui)).show(ui, |ui| panels::toolbar::toolbar_ui(ui, &app.model, queue));
    Panel::bottom("status bar")
        .frame(bar(ui))
        .show(ui, |ui| panels::status::status_ui(ui, &app.model, app.pictures.readout.as_ref(), queue));

    if app.model.datasets.open.is_some() && app.model.panels.filmstrip {
        Panel::bottom("filmstrip").frame(bar(ui)).exact_size(filmstrip::HEIGHT).show(ui, |ui| {
            open_burst = filmstrip::filmstrip_ui(ui, &mut app.model, &mut app.thumbnails, queue).open;
        });
    }
    if app.model.burst.is_none() {
        CentralPanel::default().show(ui, |ui| {
            panels::welcome::welcome_ui(ui, &app.model, app.remembered(), queue, &mut open_recent);
        });
    } else {
        if app.model.panels.left {
            Panel::left("left").frame(side(ui)).default_size(side_width).size_range(250.0..=420.0).show(ui, |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    panels::scrub::scrub_ui(ui, &mut app.model, queue);
                    panels::parameters::parameters_ui(ui, &mut app.model, queue);
                });
            });
        }
        if app.model.panels.right {
            Panel::right("right").frame(side(ui)).default_size(side_width).size_range(250.0..=460.0).show(ui, |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    panels::display::display_ui(ui, &mut app.model, &app.pictures, &mut app.display);
                    panels::selection::selection_ui(ui, &mut app.model, &mut app.selection, queue);
                });
            });
        }
        if app.model.panels.bottom {
            Panel::bottom("bottom")
                .frame(Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 4)))
                .resizable(true)
                .default_size(190.0)
                .size_range(90.0..=500.0)
                .show(ui, |ui| panels::bottom::bottom_ui(ui, &mut app.model, queue));
        }
        CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
            panels::picture::picture_ui(ui, &mut app.model, &mut app.view, &mut app.pictures, queue);
        });
    }
    panels::welcome::drop_hint_ui(ui.ctx());
    if let Some(place) = open_burst {
        app.open_burst_at(place);
    }
    match open_recent {
        Some(Recent::Burst(source)) => app.open(source),
        Some(Recent::Dataset(source)) => app.open_dataset(source),
        None => {}
    }
}
