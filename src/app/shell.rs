//! Where everything is: menus and toolbar above, the open workspace in the middle, the status below.

use super::actions::{ActionId, Queue, menu::menu_bar_ui};
use super::dataset::{CutChoice, cut_offer_ui, filmstrip};
use super::settings::Recent;
use super::window::BurstscopeApp;
use crate::app::panel;
use crate::app::project::workspace::Workspace;
use egui::{CentralPanel, Frame, Margin, Panel};

/// Draws the whole window except what floats over it.
pub fn shell_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui, queue: &mut Queue) {
    let mut open_recent = None;
    let mut open_burst = None;
    let bar = |ui: &egui::Ui| Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 3));

    Panel::top("menu bar").frame(bar(ui)).show(ui, |ui| {
        ui.horizontal(|ui| {
            menu_bar_ui(ui, &app.model, app.remembered(), queue, &mut open_recent);
            crate::app::workspace::switch_ui(ui, &app.model, queue);
        });
    });
    Panel::top("toolbar").frame(bar(ui)).show(ui, |ui| panel::toolbar::toolbar_ui(ui, &app.model, queue));
    Panel::bottom("status bar")
        .frame(bar(ui))
        .show(ui, |ui| panel::status::status_ui(ui, &app.model, app.readout().as_deref(), queue));

    if let Some(length) = app.offered_cut() {
        let frames = app.model.frame_count();
        let choice = Panel::top("cut offer").frame(bar(ui)).show(ui, |ui| cut_offer_ui(ui, frames, length)).inner;
        match choice {
            Some(CutChoice::Cut) => app.cut_open_burst(length),
            Some(CutChoice::Ask) => queue.push(ActionId::CutSequence),
            Some(CutChoice::Keep) => app.keep_burst_whole(),
            None => {}
        }
    }
    if app.model.datasets.open.is_some() && app.model.panels.filmstrip {
        Panel::bottom("filmstrip").frame(bar(ui)).exact_size(filmstrip::HEIGHT).show(ui, |ui| {
            open_burst = filmstrip::filmstrip_ui(ui, &mut app.model, &mut app.thumbnails, queue).open;
        });
    }
    if app.model.burst.is_none() && app.model.workspace.needs_burst() {
        CentralPanel::default().show(ui, |ui| {
            panel::welcome::welcome_ui(ui, &app.model, app.remembered(), queue, &mut open_recent);
        });
    } else {
        crate::app::workspace::workspace_ui(app, ui, queue);
    }
    let whole = ui.ctx().content_rect();
    match app.pair_panels.rect_b.filter(|_| app.model.workspace == Workspace::Pair && app.model.burst.is_some()) {
        Some(b) => {
            let a = b.translate(egui::vec2(-b.width(), 0.0));
            panel::welcome::drop_hint_ui(ui.ctx(), &[(a, "Let go to open as A"), (b, "Let go to open as B")]);
        }
        None => panel::welcome::drop_hint_ui(ui.ctx(), &[(whole, "Let go to open")]),
    }
    if let Some(place) = open_burst {
        app.open_burst_at(place);
    }
    match open_recent {
        Some(Recent::Burst(source)) => app.open(source),
        Some(Recent::Dataset(source)) => app.open_dataset(source),
        None => {}
    }
}
