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
    // The text's place stays free without it, so that the fields below do not move under the pointer.
    let height_id = egui::Id::unique("height of the found slopes");
    let found_label = |text: &str| egui::Label::new(RichText::new(text).small().weak()).wrap();
    match (finding.filter(|_| choice.is_auto()), ui.data(|data| data.get_temp::<f32>(height_id))) {
        (Some(text), _) => {
            let height = ui.add(found_label(text)).rect.height();
            ui.data_mut(|data| data.insert_temp(height_id, height));
        }
        (None, Some(height)) => {
            let (place, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), height), egui::Sense::hover());
            if !choice.is_auto() {
                ui.put(place, found_label("As given in the fields below"));
            }
        }
        (None, None) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fields_stay_in_place_when_slopes_are_given_instead_of_found() {
        let ctx = egui::Context::default();
        let height = |mut choice: SlopeChoice, finding: Option<&str>| {
            let mut height = 0.0;
            let mut output = ctx.run_ui(egui::RawInput::default(), |ui| {
                let table = rows::ParamTable { error: None, defaults: DetectorParams::default(), frame_count: 5 };
                let drawn = ui.vertical(|ui| {
                    ui.set_width(240.0);
                    slopes_ui(ui, &table, &mut choice, finding);
                });
                height = drawn.response.rect.height();
            });
            output.textures_delta.clear();
            height
        };
        let text = "Found in 12 steps: a text that is so long that it needs more than one line of the panel";
        let never_found = height(SlopeChoice::Given, None);
        let found = height(SlopeChoice::AUTO, Some(text));
        assert!(found > never_found + 15.0, "{found} against {never_found}");
        assert_eq!(height(SlopeChoice::Given, Some(text)), found);
        assert_eq!(height(SlopeChoice::AUTO, None), found, "while they are searched again");
    }
}
