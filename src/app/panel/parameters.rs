//! Parameters of the detector: all of them, with unit, default, effect of raising it, and error.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::panel::parameter_rows as rows;
use crate::app::panel::widgets::section_ui;
use crate::app::project::Model;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, SlopeChoice, SlopeFinding};
use egui::{Align, Layout, RichText, Ui};

/// Draws the section.
pub fn parameters_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    section_ui(ui, "Detector", |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            button_ui(ui, model, queue, ActionId::Preset1d, Some("BuFF 1D"));
            button_ui(ui, model, queue, ActionId::Preset2d, Some("BuFF 2D"));
            button_ui(ui, model, queue, ActionId::PresetSift, Some("SIFT"));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                button_ui(ui, model, queue, ActionId::ResetParams, Some("Reset all"));
            });
        });
        ui.add_space(4.0);
        let frame_count = model.frame_count();
        let error = model.slots.a.param_error.clone();
        let finding = model.slots.a.found.as_ref().and_then(|found| found.finding.as_ref()).map(slopes_found_text);
        let (p, choice) = (&mut model.params, &mut model.slopes);
        let given = p.slopes;
        let mut defaults = DetectorParams::default();
        if choice.is_auto() {
            // Found slopes have no other default.
            defaults.slopes = given;
        }
        let table = rows::ParamTable { error: error.as_ref(), defaults, frame_count };
        for record in &doc::ALL {
            ui.add_enabled_ui((record.in_use)(p), |ui| {
                if *record == doc::SLOPES {
                    slopes_ui(ui, &table, choice, finding.as_deref());
                } else {
                    table.row(ui, record, p);
                }
            });
        }
        if p.slopes != given {
            *choice = SlopeChoice::Given;
        }
    });
}

/// Text of the found slopes, shown below their switch.
fn slopes_found_text(finding: &SlopeFinding) -> String {
    let summary = finding.summary();
    let (first, rest) = summary.split_at(summary.chars().next().map_or(0, char::len_utf8));
    first.to_uppercase() + rest
}

/// Draws the choice of the slopes, and the slopes found.
fn slopes_ui(
    ui: &mut Ui,
    table: &rows::ParamTable<'_, DetectorParams>,
    choice: &mut SlopeChoice,
    finding: Option<&str>,
) {
    table.row_with(
        ui,
        &doc::SLOPES,
        choice,
        |ui, choice, _| rows::slope_choice_ui(ui, choice),
        |ui, choice| {
            if rows::reset_ui(ui, &doc::SLOPES, *choice != SlopeChoice::AUTO) {
                *choice = SlopeChoice::AUTO;
            }
        },
    );
    if let Some(text) = finding.filter(|_| choice.is_auto()) {
        ui.add(egui::Label::new(RichText::new(text).small().weak()).wrap());
    }
}
