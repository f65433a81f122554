//! Parameters of the detector: all of them, with unit, default, effect of raising it, and error.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::panel::parameter_rows as rows;
use crate::app::panel::widgets::section_ui;
use crate::app::project::Model;
use crate::detector::params::doc;
use crate::detector::{
    DescribeSlope, DetectorParams, Flicker, Interpolation, Localisation, Method, NoiseGate, NoiseModelKind,
    SlopeChoice, SlopeExtrema, SlopeFinding, SlopeNeighbours,
};
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
        let table = rows::ParamTable { error: error.as_ref(), defaults };
        all_rows_ui(ui, &table, p, choice, finding.as_deref(), frame_count);
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

fn method_label(method: Method) -> &'static str {
    match method {
        Method::Buff => "BuFF",
        Method::Sift => "SIFT",
        Method::Merge => "Merge + SIFT",
    }
}

fn all_rows_ui(
    ui: &mut Ui,
    table: &rows::ParamTable<'_, DetectorParams>,
    p: &mut DetectorParams,
    choice: &mut SlopeChoice,
    finding: Option<&str>,
    frame_count: usize,
) {
    let sift = p.method != Method::Buff;
    let adjacent = [(SlopeNeighbours::Adjacent, "Adjacent"), (SlopeNeighbours::All, "All")];
    let interpolation = [
        (Interpolation::Linear, "Linear"),
        (Interpolation::Nearest, "Nearest"),
        (Interpolation::Truncated, "Truncated"),
    ];
    table.row(
        ui,
        &doc::METHOD,
        p,
        |p| &mut p.method,
        |ui, value, label| {
            let names = Method::ALL.map(|m| (m, method_label(m)));
            rows::choice_ui(ui, value, label, &names);
        },
    );
    ui.add_enabled_ui(!sift, |ui| {
        let choices = rows::ParamTable { error: None, defaults: SlopeChoice::AUTO };
        choices.row(ui, &doc::SLOPES, choice, |choice| choice, rows::slope_choice_ui);
        if let Some(text) = finding.filter(|_| choice.is_auto()) {
            ui.add(egui::Label::new(RichText::new(text).small().weak()).wrap());
        }
        table.row(ui, &doc::SLOPES_U, p, |p| &mut p.slopes.u, rows::axis_ui);
        table.row(ui, &doc::SLOPES_V, p, |p| &mut p.slopes.v, rows::axis_ui);
        table.row(
            ui,
            &doc::SLOPE_DIRECTION,
            p,
            |p| &mut p.slopes.direction_deg,
            |ui, value, label| {
                rows::number_ui(ui, egui::DragValue::new(value).speed(0.5).suffix("°").max_decimals(1), label);
            },
        );
    });
    table.row(
        ui,
        &doc::FRAMES,
        p,
        |p| &mut p.frames,
        |ui, value, label| {
            rows::frames_ui(ui, value, label, frame_count);
        },
    );
    table.row(
        ui,
        &doc::OCTAVES,
        p,
        |p| &mut p.octaves,
        |ui, value, label| {
            rows::number_ui(ui, egui::DragValue::new(value).speed(0.05), label);
        },
    );
    table.row(
        ui,
        &doc::LEVELS,
        p,
        |p| &mut p.levels,
        |ui, value, label| {
            rows::number_ui(ui, egui::DragValue::new(value).speed(0.05), label);
        },
    );
    table.row(
        ui,
        &doc::FIRST_OCTAVE,
        p,
        |p| &mut p.first_octave,
        |ui, value, label| {
            rows::number_ui(ui, egui::DragValue::new(value).speed(0.05), label);
        },
    );
    table.row(
        ui,
        &doc::PEAK_THRESHOLD,
        p,
        |p| &mut p.peak_threshold,
        |ui, value, label| {
            rows::number_ui(ui, egui::DragValue::new(value).speed(0.0001).max_decimals(5), label);
        },
    );
    table.row(
        ui,
        &doc::NOISE_GATE,
        p,
        |p| &mut p.noise_gate,
        |ui, value: &mut NoiseGate, label| {
            rows::gate_ui(ui, value, label);
        },
    );
    table.row(
        ui,
        &doc::NOISE_MODEL,
        p,
        |p| &mut p.noise_model,
        |ui, value, label| {
            rows::choice_ui(ui, value, label, &[(NoiseModelKind::Local, "Local"), (NoiseModelKind::White, "White")]);
        },
    );
    table.row(
        ui,
        &doc::FLICKER,
        p,
        |p| &mut p.flicker,
        |ui, value, label| {
            rows::choice_ui(ui, value, label, &[(Flicker::Auto, "Auto"), (Flicker::Off, "Off")]);
        },
    );
    table.row(
        ui,
        &doc::EDGE_THRESHOLD,
        p,
        |p| &mut p.edge_threshold,
        |ui, value, label| {
            rows::number_ui(ui, egui::DragValue::new(value).speed(0.1).max_decimals(2), label);
        },
    );
    ui.add_enabled_ui(!sift, |ui| {
        let extrema = [(SlopeExtrema::Each, "Each"), (SlopeExtrema::Joint, "Joint")];
        table.row(
            ui,
            &doc::SLOPE_EXTREMA,
            p,
            |p| &mut p.slope_extrema,
            |ui, value, label| {
                rows::choice_ui(ui, value, label, &extrema);
            },
        );
        let joint = p.slope_extrema == SlopeExtrema::Joint;
        ui.add_enabled_ui(joint, |ui| {
            table.row(
                ui,
                &doc::SLOPE_NEIGHBOURS,
                p,
                |p| &mut p.slope_neighbours,
                |ui, value, label| {
                    rows::choice_ui(ui, value, label, &adjacent);
                },
            );
        });
        table.row(
            ui,
            &doc::DISTINCT,
            p,
            |p| &mut p.distinct,
            |ui, value, label| {
                rows::distinct_ui(ui, value, label);
            },
        );
        table.row(
            ui,
            &doc::DISTINCT_SCALE,
            p,
            |p| &mut p.distinct_scale,
            |ui, value, label| {
                rows::number_ui(ui, egui::DragValue::new(value).speed(0.01).max_decimals(2), label);
            },
        );
        table.row(
            ui,
            &doc::INTERPOLATION,
            p,
            |p| &mut p.interpolation,
            |ui, value, label| {
                rows::choice_ui(ui, value, label, &interpolation);
            },
        );
    });
    table.row(
        ui,
        &doc::KERNEL_CUT,
        p,
        |p| &mut p.kernel_cut,
        |ui, value, label| {
            rows::number_ui(ui, egui::DragValue::new(value).speed(0.02).max_decimals(2), label);
        },
    );
    table.row(
        ui,
        &doc::LOCALISATION,
        p,
        |p| &mut p.localisation,
        |ui, value, label| {
            let choices = [(Localisation::Continuous, "Continuous"), (Localisation::Quadratic, "Quadratic")];
            rows::choice_ui(ui, value, label, &choices);
        },
    );
    table.row(
        ui,
        &doc::MAX_FEATURES,
        p,
        |p| &mut p.max_features,
        |ui, value, label| {
            let all = |n: f64, _: std::ops::RangeInclusive<usize>| {
                if n < 0.5 { "all".to_owned() } else { format!("{n:.0}") }
            };
            let parse = |text: &str| if text.trim() == "all" { Some(0.0) } else { text.trim().parse().ok() };
            rows::number_ui(
                ui,
                egui::DragValue::new(value).speed(5.0).custom_formatter(all).custom_parser(parse),
                label,
            );
        },
    );
    table.row(
        ui,
        &doc::MAX_ORIENTATIONS,
        p,
        |p| &mut p.max_orientations,
        |ui, value, label| {
            rows::number_ui(ui, egui::DragValue::new(value).speed(0.02), label);
        },
    );
    ui.add_enabled_ui(!sift, |ui| {
        let slopes = [(DescribeSlope::Refined, "Refined"), (DescribeSlope::Grid, "Grid")];
        table.row(
            ui,
            &doc::DESCRIBE_SLOPE,
            p,
            |p| &mut p.describe_slope,
            |ui, value, label| {
                rows::choice_ui(ui, value, label, &slopes);
            },
        );
    });
}
