//! Layout of the window: menus and toolbar above, the open workspace in the middle, the status bar below.

use super::actions::{ActionId, Queue, menu::menu_bar_ui};
use super::dataset::{CutChoice, cut_offer_ui, filmstrip};
use super::lesson::{Wish, lesson_ui};
use super::settings::Recent;
use super::window::BurstscopeApp;
use crate::app::panel;
use crate::app::project::side::Side;
use crate::app::workspace::{switch_ui, workspace_ui};
use egui::{CentralPanel, Frame, Margin, Panel};

/// Draws the whole window except its overlays. Returns the wish of the user about the open lesson.
pub fn shell_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui, queue: &mut Queue) -> Option<Wish> {
    let mut open_recent = None;
    let mut open_burst = None;
    let mut start_lesson = None;
    let bar = |ui: &egui::Ui| Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 3));

    Panel::top("menu bar").frame(bar(ui)).show(ui, |ui| {
        ui.horizontal(|ui| {
            menu_bar_ui(ui, &app.model, app.remembered(), queue, &mut open_recent);
            switch_ui(ui, &app.model, queue);
        });
    });
    Panel::top("toolbar").frame(bar(ui)).show(ui, |ui| panel::toolbar::toolbar_ui(ui, &app.model, queue));
    Panel::bottom("status bar")
        .frame(bar(ui))
        .show(ui, |ui| panel::status::status_ui(ui, &app.model, app.readout().as_deref(), queue));

    if let Some(offer) = app.offered_session() {
        let offer_ui = |ui: &mut egui::Ui| panel::status::recovery_ui(ui, &offer);
        let choice = Panel::top("recovery offer").frame(bar(ui)).show(ui, offer_ui).inner;
        choice.into_iter().for_each(|choice| app.settle_offer(choice));
    }
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
    let wish = lesson_panel_ui(app, ui);
    if app.model.slots.a.burst.is_none() && app.model.workspace.needs_burst() {
        CentralPanel::default().show(ui, |ui| {
            let chosen =
                panel::welcome::welcome_ui(ui, &app.model, app.remembered(), &app.lessons, queue, &mut open_recent);
            start_lesson = chosen;
        });
    } else {
        let wishes = workspace_ui(ui, &mut app.workspace_parts(queue));
        wishes.changes.into_iter().for_each(|change| app.change_panes(change));
        if wishes.compare_again {
            app.model.compare_trajectories_again(&app.engine);
        }
        if let Some(label) = wishes.camera {
            app.look_at_camera(&label);
        }
    }
    let places = app.drop_places();
    if places.is_empty() {
        panel::welcome::drop_hint_ui(ui.ctx(), &[(ui.ctx().content_rect(), "Let go to open")]);
    } else {
        let hint = |side: Side| if side == Side::A { "Let go to open as A" } else { "Let go to open as B" };
        let hints: Vec<_> = places.into_iter().map(|(rect, side)| (rect, hint(side))).collect();
        panel::welcome::drop_hint_ui(ui.ctx(), &hints);
    }
    if let Some(place) = open_burst {
        app.open_burst_at(place);
    }
    match open_recent {
        Some(Recent::Burst(source)) => app.open(source),
        Some(Recent::Dataset(source)) => app.open_dataset(source),
        None => {}
    }
    if let Some(lesson) = start_lesson {
        app.start_lesson(lesson);
    }
    wish
}

/// Draws the panel of the open lesson, if there is one.
fn lesson_panel_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui) -> Option<Wish> {
    app.lessons.open.as_ref()?;
    let width = (0.27 * ui.available_width()).clamp(290.0, 360.0);
    let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin { left: 12, right: 10, top: 8, bottom: 2 });
    let clicks = Panel::right("lesson")
        .frame(frame)
        .default_size(width)
        .size_range(270.0..=520.0)
        .show(ui, |ui| lesson_ui(ui, &mut app.lessons, &mut app.model, &mut app.captions))
        .inner;
    if let Some(word) = &clicks.word {
        app.overlays.glossary.open(Some(word));
    }
    clicks.wish
}
