//! Advice after a detection with few or no features, in one line.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::project::Model;
use crate::app::project::workspace::Workspace;
use egui::{Label, RichText, Ui};

/// Draws the reason why there are no or few features, or why most lie at the slope limit, while the features belong to
/// the present parameters.
pub(crate) fn advice_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    let advice =
        model.slots.a.found.as_ref().filter(|_| model.stale().is_none()).and_then(|found| found.advice.as_ref());
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
