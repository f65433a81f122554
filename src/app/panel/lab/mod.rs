//! Panels of the Lab: the settings of a study, the curves, and the chart behind a point of a curve.

/// Draws a field of a grid: its name, help and widget.
macro_rules! field {
    ($ui:expr, $name:literal, $help:literal, $widget:expr) => {{
        let label = $ui.label($name).on_hover_text($help);
        $ui.add($widget).on_hover_text($help).labelled_by(label.id);
        $ui.end_row();
    }};
}

pub mod chart;
pub mod curves;
pub mod planted;

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::Action;
use crate::app::document::lab::{Lab, LabQuestion};
use crate::app::panel::widgets::{dot_ui, error_ui, name_field, progress_text, progress_ui, section_ui};
use crate::app::results::Read;
use crate::app::results::studies::Studies;
use crate::evaluate::BurstMethod;
use crate::synth::Motion;
use egui::{Color32, DragValue, Grid, Label, RichText, TextEdit, Ui};

/// Colour `#rrggbb` of the figures as drawn here: lighter on a dark background.
fn curve_colour(ui: &Ui, [r, g, b]: [u8; 3]) -> Color32 {
    let colour = Color32::from_rgb(r, g, b);
    if ui.visuals().dark_mode { colour.lerp_to_gamma(Color32::WHITE, 0.3) } else { colour }
}

pub fn lab_settings_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let mut lab = model.document.lab.clone();
    section_ui(ui, "Study", |ui| {
        question_ui(ui, &mut lab);
        ui.add_space(4.0);
        start_ui(ui, model, queue);
    });
    if !model.results.studies.kept.is_empty() {
        section_ui(ui, "Kept curves", |ui| kept_ui(ui, &model.results.studies, queue));
    }
    if model.document.lab.question.counts_frames() {
        section_ui(ui, "Frames", |ui| counts_ui(ui, &mut lab));
    }
    if model.document.lab.question.needs_charts() {
        section_ui(ui, "Charts", |ui| charts_ui(ui, &mut lab));
    }
    if model.document.lab.question == LabQuestion::InBurst {
        section_ui(ui, "Planted things", |ui| planted::planted_settings_ui(ui, &mut lab.planted));
    }
    if model.document.lab.question.compares_methods() {
        section_ui(ui, "Methods", |ui| methods_ui(ui, &mut lab));
    }
    section_ui(ui, "Dark copy of A", |ui| dark_copy_ui(ui, model, &mut lab, queue));
    queue.edit(model.document, Action::SetLab(Box::new(lab)));
    let text = "All methods use the detector's parameters of this window. Only the method 'slopes found' finds the slopes \
                of each burst; the others search the given range, or ±3 px/frame.";
    ui.add(Label::new(RichText::new(text).small().weak()).wrap());
}

fn question_ui(ui: &mut Ui, lab: &mut Lab) {
    ui.horizontal_wrapped(|ui| {
        for (question, name, help) in LabQuestion::ALL {
            ui.selectable_value(&mut lab.question, question, name).on_hover_text(help);
        }
    });
}

fn start_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    if let Some(running) = model.results.studies.wanted.running() {
        progress_ui(ui, &running, None, &progress_text(&running));
        button_ui(ui, model, queue, ActionId::CancelStudy, None);
        return;
    }
    ui.horizontal(|ui| {
        button_ui(ui, model, queue, ActionId::RunStudy, None);
        button_ui(ui, model, queue, ActionId::KeepCurves, None);
    });
    if let Some(problem) = model.lab_study().err().or_else(|| model.results.studies.problem.clone()) {
        error_ui(ui, problem);
    }
}

fn charts_ui(ui: &mut Ui, lab: &mut Lab) {
    Grid::new("lab charts").num_columns(2).show(ui, |ui| {
        let label =
            ui.label("SNR").on_hover_text("Ratios of signal to noise of one pixel in one frame, separated by commas");
        let text = TextEdit::singleline(&mut lab.snrs_text).desired_width(130.0);
        let response = ui.add(text).labelled_by(label.id);
        name_field(&response, "SNR", &lab.snrs_text);
        ui.end_row();
        field!(
            ui,
            "Charts",
            "Charts per ratio; more give smoother curves and smaller errors",
            DragValue::new(&mut lab.seeds).range(1..=1000).suffix(" each")
        );
        field!(
            ui,
            "First seed",
            "Seed of the first chart; the next charts count up from it",
            DragValue::new(&mut lab.first_seed)
        );
        let counts_frames = lab.question.counts_frames();
        let chart = &mut lab.chart;
        field!(ui, "Discs", "Discs per chart", DragValue::new(&mut chart.discs).range(1..=2000));
        let label = ui.label("Radius").on_hover_text("Min and max radius of the discs, pixels");
        ui.horizontal(|ui| {
            let (mut least, mut most) = (*chart.radius.start(), *chart.radius.end());
            let field = |value| DragValue::new(value).speed(0.1).max_decimals(1).suffix(" px");
            let first = ui.add(field(&mut least).range(0.5..=200.0)).labelled_by(label.id);
            ui.label("to");
            let second = ui.add(field(&mut most).range(0.5..=200.0)).labelled_by(label.id);
            if first.changed() || second.changed() {
                chart.radius = least.min(most)..=least.max(most);
            }
        });
        ui.end_row();
        field!(
            ui,
            "Contrast",
            "Intensity of a disc over the background's; above 1 is brighter",
            DragValue::new(&mut chart.contrast).range(0.0..=8.0).speed(0.01).max_decimals(2)
        );
        if !counts_frames {
            field!(ui, "Frames", "Frames of a burst", DragValue::new(&mut chart.frames).range(2..=200));
        }
        field!(
            ui,
            "Max slope",
            "Discs move with slopes up to this in both directions, px/frame",
            DragValue::new(&mut chart.max_slope).range(0.0..=30.0).speed(0.05).max_decimals(2).suffix(" px/frame")
        );
        ui.label("Motion").on_hover_text("Whether discs move horizontally only, or in any direction");
        ui.horizontal(|ui| {
            ui.selectable_value(&mut chart.motion, Motion::OneD, "1D");
            ui.selectable_value(&mut chart.motion, Motion::TwoD, "2D");
        });
        ui.end_row();
        let label = ui.label("Size").on_hover_text("Columns and rows of a frame, pixels");
        ui.horizontal(|ui| {
            ui.add(DragValue::new(&mut chart.width).range(64..=4096)).labelled_by(label.id);
            ui.label("×");
            ui.add(DragValue::new(&mut chart.height).range(64..=4096)).labelled_by(label.id);
        });
        ui.end_row();
    });
    let tip = "Chart of the published measurements: 90 discs, 10 frames of 800 × 600";
    if ui.button("Published chart").on_hover_text(tip).clicked() {
        lab.chart = crate::synth::ChartParams::default();
    }
}

fn counts_ui(ui: &mut Ui, lab: &mut Lab) {
    ui.horizontal(|ui| {
        let help = "Numbers of frames, separated by commas; of the open burst the middle frames are taken";
        let label = ui.label("Numbers").on_hover_text(help);
        let response = ui.add(TextEdit::singleline(&mut lab.counts_text).desired_width(190.0)).labelled_by(label.id);
        name_field(&response, "Numbers of frames", &lab.counts_text);
    });
}

fn methods_ui(ui: &mut Ui, lab: &mut Lab) {
    for method in BurstMethod::ALL {
        let mut on = lab.methods.contains(&method);
        ui.horizontal(|ui| {
            dot_ui(ui, curve_colour(ui, method.line().0));
            if ui.checkbox(&mut on, method.label()).changed() {
                lab.methods.retain(|m| *m != method);
                lab.methods.extend(on.then_some(method));
            }
        });
    }
}

fn dark_copy_ui(ui: &mut Ui, model: Read<'_>, lab: &mut Lab, queue: &mut Queue) {
    let noise = &mut lab.dark_copy;
    ui.horizontal(|ui| {
        let help = "Ratio of the frames' contrast to the noise of one pixel in one frame";
        let label = ui.label("SNR of the copy").on_hover_text(help);
        let field = DragValue::new(&mut noise.snr).range(0.05..=50.0).speed(0.01).max_decimals(2);
        ui.add(field).on_hover_text(help).labelled_by(label.id);
        let label = ui.label("seed").on_hover_text("Seed of its noise");
        ui.add(DragValue::new(&mut noise.seed)).labelled_by(label.id);
    });
    button_ui(ui, model, queue, ActionId::OpenDarkCopy, None);
}

fn kept_ui(ui: &mut Ui, studies: &Studies, queue: &mut Queue) {
    for (index, kept) in studies.kept.iter().enumerate() {
        let (mut is_shown, mut name) = (kept.is_shown, kept.name.clone());
        ui.horizontal(|ui| {
            let shown = ui.checkbox(&mut is_shown, "").on_hover_text(kept.result.report.summary());
            shown.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::CheckBox, true, is_shown, format!("Show {name}"))
            });
            let field = ui.add(TextEdit::singleline(&mut name).desired_width(120.0));
            name_field(&field, "Name of kept curves", &name);
            if ui.small_button("Remove").on_hover_text("Remove these curves").clicked() {
                queue.push(Action::ForgetKept(index));
            }
        });
        queue.set(&kept.is_shown, is_shown, |shown| Action::ShowKept(index, shown));
        queue.set(&kept.name, name, |name| Action::NameKept(index, name));
    }
}
