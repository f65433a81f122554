//! Verdict on the search, below the parameters of *One burst*: why there are few features, or whether the slopes fit the
//! burst, with the change that mends it.

use super::{piece_ui, sentence_of};
use crate::app::actions::Queue;
use crate::app::panel::status::advice_ui;
use crate::app::project::{BottomTab, Model, Visibility};
use crate::app::style;
use egui::{Button, Frame, Label, Margin, RichText, Ui};

/// Draws the verdict on the features of the present parameters; nothing while there are none.
pub fn verdict_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    let has_advice =
        model.stale().is_none() && model.slots.a.found.as_ref().is_some_and(|found| found.advice.is_some());
    let judgement = model.slope_judgement().cloned();
    if !has_advice && judgement.is_none() {
        return;
    }
    let fill = ui.visuals().faint_bg_color;
    Frame::new().fill(fill).corner_radius(4).inner_margin(Margin::symmetric(8, 5)).show(ui, |ui| {
        ui.set_width(ui.available_width());
        if has_advice {
            advice_ui(ui, model, queue);
        }
        let Some(judgement) = judgement else { return };
        match &judgement.advice {
            None => {
                ui.add(Label::new(RichText::new(sentence_of(&judgement.sentence)).color(style::good(ui))).wrap());
            }
            Some(advice) if !has_advice => piece_ui(ui, model, "Apply slopes", advice),
            // Without features it comes second; the tab has it.
            Some(_) => {}
        }
        let details = Button::new(RichText::new("Slopes…").small().weak()).frame(false);
        if ui.add(details).on_hover_text("Features and evidence at each slope, and all advice").clicked() {
            (model.bottom_tab, model.panels.bottom) = (BottomTab::Slopes, Visibility::Open);
        }
    });
}
