//! Suspicions about a kept feature, with their evidence.

use super::apply_ui;
use super::fates::sentence;
use crate::app::actions::Queue;
use crate::app::project::Model;
use crate::app::style;
use crate::inspect::suspicion::{Kind, Suspicion};
use crate::inspect::words::counted_from_one;
use crate::requests::Probed;
use egui::{Frame, Label, Margin, RichText, Stroke, Ui};

fn title(kind: Kind) -> (&'static str, &'static str) {
    match kind {
        Kind::Duplicate => ("A duplicate?", "Another feature lies on the same blob"),
        Kind::Ghost => ("A ghost?", "A blob with another motion shows in this slope's motion stack"),
        Kind::AtLimit => {
            ("At the limit?", "Its slope is at the end of the searched range, and its response rises beyond")
        }
        Kind::Alias => ("An alias?", "The texture repeats, and another slope shows it as well"),
    }
}

/// Draws all suspicions.
pub(super) fn suspicions_ui(ui: &mut Ui, model: &mut Model, answer: &Probed, queue: &mut Queue) {
    for suspicion in &answer.probe.suspicions {
        let frame = Frame::new().stroke(Stroke::new(1.0, style::warning(ui))).corner_radius(4);
        frame.inner_margin(Margin::symmetric(6, 4)).show(ui, |ui| {
            ui.set_width(ui.available_width());
            suspicion_ui(ui, model, suspicion, queue);
        });
        ui.add_space(4.0);
    }
}

fn suspicion_ui(ui: &mut Ui, model: &mut Model, suspicion: &Suspicion, queue: &mut Queue) {
    let (name, help) = title(suspicion.kind);
    ui.label(RichText::new(name).strong().color(style::warning(ui))).on_hover_text(help);
    ui.add(Label::new(sentence(&counted_from_one(&suspicion.evidence))).wrap());
    if suspicion.change.is_none() && suspicion.other.is_none() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        if let Some(change) = &suspicion.change {
            apply_ui(ui, model, change, queue);
            ui.label(RichText::new(change.label()).weak());
        }
        if let Some(other) = suspicion.other
            && ui
                .button(format!("Probe feature {}", other + 1))
                .on_hover_text("Show why that feature was kept")
                .clicked()
        {
            model.probe_feature(other);
        }
    });
}
