//! Panels of the Lab: the settings of a study, the curves, and the chart behind a point of a curve.

pub mod chart;
pub mod curves;
mod form;
pub mod planted;

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::canvas::overlay::rgb;
use crate::app::document::{Action, Lab, LabQuestion};
use crate::app::panel::widgets::{dot_ui, error_ui, name_field, progress_text, progress_ui, section_ui, weak_ui};
use crate::app::{results::Read, results::studies::Studies};
use egui::{Color32, DragValue, RichText, Role, TextEdit, Ui};

const FOUND: Color32 = Color32::from_rgb(86, 180, 233);
const MISSED: Color32 = Color32::from_rgb(240, 228, 66);

/// Colour `#rrggbb` of the figures as drawn here: lighter on a dark background.
fn curve_colour(ui: &Ui, colour: [u8; 3]) -> Color32 {
    let colour = rgb(colour);
    if ui.visuals().dark_mode { colour.lerp_to_gamma(Color32::WHITE, 0.3) } else { colour }
}

pub fn lab_settings_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let mut lab = model.document.lab.clone();
    section_ui(ui, "Study", |ui| {
        ui.horizontal_wrapped(|ui| {
            for question in LabQuestion::ALL {
                let [name, help] = question.words();
                ui.selectable_value(&mut lab.question, question, name).on_hover_text(help);
            }
        });
        ui.add_space(4.0);
        start_ui(ui, model, queue);
    });
    if !model.results.studies.kept.is_empty() {
        section_ui(ui, "Kept curves", |ui| kept_ui(ui, &model.results.studies, queue));
    }
    section_ui(ui, "Settings", |ui| form::form_ui(ui, &mut lab));
    if model.document.lab.question.compares_methods() {
        section_ui(ui, "Methods", |ui| {
            for method in crate::evaluate::BurstMethod::ALL {
                let mut on = lab.methods.contains(&method);
                ui.horizontal(|ui| {
                    dot_ui(ui, curve_colour(ui, method.line().0));
                    if ui.checkbox(&mut on, method.label()).changed() {
                        lab.methods.retain(|m| *m != method);
                        lab.methods.extend(on.then_some(method));
                    }
                });
            }
        });
    }
    section_ui(ui, "Dark copy of A", |ui| dark_copy_ui(ui, model, &mut lab, queue));
    queue.edit(model.document, Action::SetLab(Box::new(lab)));
    let text = "All methods use the detector's parameters of this window. Only the method 'slopes found' finds the slopes \
                of each burst; the others search the given range, or ±3 px/frame.";
    weak_ui(ui, RichText::new(text).small());
}

fn start_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    if let Some(running) = model.results.studies.wanted.running {
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
            shown.widget_info(|| egui::WidgetInfo::selected(Role::CheckBox, true, is_shown, format!("Show {name}")));
            let field = ui.add(TextEdit::singleline(&mut name).desired_width(120.0));
            name_field(&field, "Name of kept curves", &name);
            let response = ui.small_button("Remove").on_hover_text("Remove these curves");
            queue.push_if(response.clicked(), Action::ForgetKept(index));
        });
        queue.set(&kept.is_shown, is_shown, |shown| Action::ShowKept(index, shown));
        queue.set(&kept.name, name, |name| Action::NameKept(index, name));
    }
}
