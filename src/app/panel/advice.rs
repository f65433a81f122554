//! What a detection with little or nothing in it advises, in one line.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::project::Model;
use crate::app::project::workspace::Workspace;
use egui::{Label, RichText, Ui};

/// Why there is nothing or little, or most of it at the slope limit, as long as that is so with the present parameters.
pub(crate) fn advice_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    let advice = model.slots.a.found.as_ref().filter(|_| model.stale().is_none()).and_then(|found| found.advice.as_ref());
    if let Some(advice) = advice {
        let text = RichText::new(advice.for_window()).color(crate::app::style::warning(ui));
        ui.horizontal_wrapped(|ui| {
            ui.add(Label::new(text).wrap()).on_hover_text(advice.parameter.help());
            if model.features().is_empty() && model.workspace == Workspace::Inspect {
                button_ui(ui, model, queue, ActionId::ProbeStrongest, None);
            }
        });
    }
}
