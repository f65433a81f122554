//! Verdict on the search, below the parameters of *One burst*: why there are few features, or whether the slopes fit the burst, with the
//! change that mends it.

use super::piece_ui;
use crate::app::actions::Queue;
use crate::app::panel::status::advice_ui;
use crate::app::project::{BottomTab, Model, Visibility};
use crate::app::style;
use egui::{Button, Frame, Margin, RichText, Ui};

/// Draws the verdict on the features of the present parameters; nothing while there are none.
pub fn verdict_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    let has_advice =
        model.stale().is_none() && model.slots.a.found.as_ref().is_some_and(|found| found.advice.is_some());
    let spectrum = model.spectrum().cloned();
    if !has_advice && spectrum.is_none() {
        return;
    }
    let fill = ui.visuals().faint_bg_color;
    Frame::new().fill(fill).corner_radius(4).inner_margin(Margin::symmetric(8, 5)).show(ui, |ui| {
        ui.set_width(ui.available_width());
        if has_advice {
            advice_ui(ui, model, queue);
        }
        let Some(spectrum) = spectrum else { return };
        if let Some(advice) = spectrum.advice.first() {
            if !has_advice {
                piece_ui(ui, model, "Apply the advice", advice);
            }
        } else {
            ui.label(RichText::new("The slopes fit").color(style::good(ui)));
        }
        let details = Button::new(RichText::new("Slopes…").small().weak()).frame(false);
        if ui.add(details).on_hover_text("Features and evidence at each slope, and all advice").clicked() {
            (model.bottom_tab, model.panels.bottom) = (BottomTab::Slopes, Visibility::Open);
        }
    });
}
