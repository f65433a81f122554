//! Page of a pane whose burst is not open: how to open one.

use crate::app::actions::{ActionId, Queue, tooltip};
use crate::app::project::Model;
use crate::app::project::method::Contender;
use crate::app::project::side::Side;
use egui::{ProgressBar, RichText, Ui, vec2};

/// Draws the page of a pane on `side` that shows the input of `method`.
pub(super) fn empty_ui(ui: &mut Ui, model: &Model, side: Side, method: Option<Contender>, queue: &mut Queue) {
    if method == Some(Contender::Gold) {
        gold_ui(ui, side, queue);
    } else {
        second_ui(ui, model, queue);
    }
}

fn gold_ui(ui: &mut Ui, side: Side, queue: &mut Queue) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.2).max(12.0));
        let text = format!("Open a sharp image of {}'s view, taken with enough light", side.name());
        ui.add(egui::Label::new(RichText::new(text).weak()).wrap());
        let id = if side == Side::A { ActionId::OpenGoldA } else { ActionId::OpenGoldB };
        if ui.button(id.action().label).on_hover_text(tooltip(ui.ctx(), id.action())).clicked() {
            queue.push(id);
        }
    });
}

fn second_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.2).max(12.0));
        ui.label(RichText::new("Open a second burst").size(18.0).strong());
        ui.add(
            egui::Label::new(
                RichText::new("of the same place: its features are matched with those of the first").weak(),
            )
            .wrap(),
        );
        ui.add_space(12.0);
        if let Some(running) = model.slots.b.opening.running() {
            let fraction = running.progress.map_or(0.0, |p| p.fraction);
            ui.add(ProgressBar::new(fraction).desired_width(220.0).text("Opening B…"));
            return;
        }
        for id in [ActionId::OpenFolderB, ActionId::OpenFilesB, ActionId::OpenPathB, ActionId::OpenDemoB] {
            let button = egui::Button::new(id.action().label).min_size(vec2(220.0, 26.0));
            if ui.add(button).on_hover_text(tooltip(ui.ctx(), id.action())).clicked() {
                queue.push(id);
            }
        }
        ui.add_space(8.0);
        ui.weak("or drop it here");
    });
}
