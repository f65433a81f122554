//! Chart behind a point of a curve: the mean of its frames, with the found and missed discs and the false features.

use super::{FOUND, MISSED};
use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::{Action, Lab};
use crate::app::panel::widgets::{WHOLE, dashed_circle, dots_ui, draw_plane, named, only_ui};
use crate::app::{results::Read, view::nearest};
use crate::inspect::{result::Scored, words::number};
use crate::study::{ShownChart, StudyPoint};
use egui::{Color32, ComboBox, Pos2, Sense, Stroke, Ui, vec2};

const FALSE: Color32 = Color32::from_rgb(213, 94, 0);

pub fn lab_chart_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let mut lab = model.document.lab.clone();
    choice_ui(ui, model, &mut lab);
    chosen_ui(ui, model, &mut lab, queue);
    queue.edit(model.document, Action::SetLab(Box::new(lab)));
}

fn chosen_ui(ui: &mut Ui, model: Read<'_>, lab: &mut Lab, queue: &mut Queue) {
    if model.document.lab.selected.is_none() {
        return match model.document.lab.question.needs_charts() {
            true => only_ui(ui, "Click a point of a curve to look at its chart."),
            false => only_ui(ui, "These points are measured on the open burst, so there is no chart to show."),
        };
    }
    let Some(shown) = model.current_chart() else {
        ui.horizontal(|ui| {
            ui.spinner();
            ui.weak("Making the chart again…");
        });
        return;
    };
    let judged = shown.judged(model.document.lab.all_detected);
    key_ui(ui, shown, &judged);
    picture_ui(ui, shown, &judged);
    ui.horizontal(|ui| {
        button_ui(ui, model, queue, ActionId::OpenChart, None);
        ui.checkbox(&mut lab.all_detected, "All detections").on_hover_text(
            "Otherwise only those above the threshold at which the curves compare methods: a tenth of them is false",
        );
    });
}

fn choice_ui(ui: &mut Ui, model: Read<'_>, lab: &mut Lab) {
    let results = model.lab_results().into_iter();
    let sets: Vec<_> = results.map(|(set, name, _)| (set, name.unwrap_or("This study").to_owned())).collect();
    let Some((first, _)) = sets.first() else { return };
    let set = lab.selected.map_or(*first, |(set, _)| set);
    let Some(result) = model.results.studies.result(set) else { return };
    let mut points: Vec<(Option<StudyPoint>, String)> = vec![];
    for curve in result.report.plots(usize::MAX).iter().flat_map(|plot| &plot.curves) {
        for point in &curve.line.points {
            let of = StudyPoint { row_value: curve.row_value(point), method: curve.method };
            if points.iter().all(|(there, _)| *there != Some(of)) {
                let method = curve.method.map_or_else(String::new, |method| format!("{}, ", method.label()));
                points.push((Some(of), format!("{method}{}", result.report.row_label(of.row_value))));
            }
        }
    }
    let Some((first_seed, seeds)) = result.study.seeds() else { return };
    let (mut chosen, mut chosen_set) = (lab.selected.map(|(_, point)| point), set);
    if sets.len() > 1 {
        list_ui(ui, ComboBox::from_label("Curves"), &mut chosen_set, &sets, "");
    }
    list_ui(ui, ComboBox::from_label("Point").width(190.0), &mut chosen, &points, "none");
    if chosen.is_some() {
        let chart = &mut lab.selected_chart;
        ui.horizontal(|ui| {
            if ui.button("◀").on_hover_text("Previous chart of the same ratio").clicked() {
                *chart = (*chart + seeds - 1) % seeds;
            }
            let shown = (*chart).min(seeds - 1);
            ui.label(format!("chart {} of {seeds}, seed {}", shown + 1, first_seed.saturating_add(shown)));
            if ui.button("▶").on_hover_text("Next chart of the same ratio").clicked() {
                *chart = (*chart + 1) % seeds;
            }
        });
    }
    lab.selected = chosen.map(|point| (chosen_set, point));
}

/// Draws a list of choices, each with its name, that unfolds; `none` stands there where no choice is the chosen one.
fn list_ui<T: PartialEq + Copy>(ui: &mut Ui, list: ComboBox, chosen: &mut T, choices: &[(T, String)], none: &str) {
    let text = choices.iter().find(|(of, _)| of == chosen).map_or(none, |(_, text)| text.as_str());
    list.selected_text(text).show_ui(ui, |ui| {
        for (of, text) in choices {
            ui.selectable_value(chosen, *of, text);
        }
    });
}

fn key_ui(ui: &mut Ui, shown: &ShownChart, judged: &[Scored]) {
    let found = judged.iter().filter(|judged| judged.disc.is_some()).count();
    let counts = [
        (FOUND, format!("{found} found")),
        (MISSED, format!("{} missed", shown.looked.truth.features.len() - found)),
        (FALSE, format!("{} false", judged.len() - found)),
    ];
    dots_ui(ui, counts);
}

fn picture_ui(ui: &mut Ui, shown: &ShownChart, judged: &[Scored]) {
    let (width, height) = shown.mean.size();
    let scale = ui.available_width() / width as f32;
    let (rect, response) = ui.allocate_exact_size(vec2(width as f32, height as f32) * scale, Sense::hover());
    let display = crate::plane::display::Display::stretched(&shown.mean);
    draw_plane(ui, ("lab chart", rect), display, Some(((&shown.mean).into(), WHOLE, || (*shown.mean).clone())));
    let pos_ui = |u: f32, v: f32| rect.min + scale * vec2(u + 0.5, v + 0.5);
    let painter = ui.painter().with_clip_rect(rect);
    let looked = &shown.looked;
    let mut found = vec![false; looked.truth.features.len()];
    let mut marks: Vec<(Pos2, f32, String)> = Vec::new();
    for judged in judged {
        let feature = &looked.detection.features[judged.feature];
        if let Some(disc) = judged.disc {
            found[disc] = true;
            continue;
        }
        let (centre, radius) = (pos_ui(feature.u, feature.v), (feature.circle_radius_px() * scale).max(2.0));
        painter.circle_stroke(centre, radius, Stroke::new(1.2, FALSE));
        let text = format!("False: σ {} px, snr {}", number(feature.sigma, 2), number(feature.snr, 1));
        marks.push((centre, radius, text));
    }
    for (disc, found) in looked.truth.features.iter().zip(&found) {
        let (centre, radius) = (pos_ui(disc.u as f32, disc.v as f32), (disc.radius as f32 * scale).max(2.0));
        let what = if *found {
            painter.circle_stroke(centre, radius, Stroke::new(1.2, FOUND));
            "Found"
        } else {
            dashed_circle(&painter, centre, radius, Stroke::new(1.4, MISSED), (4.0, 3.0));
            "Missed"
        };
        let slope = [disc.slope_u, disc.slope_v].map(|slope| number(slope as f32, 2)).join(", ");
        let px = number(disc.radius as f32, 1);
        marks.push((centre, radius, format!("{what}: disc of radius {px} px, slope ({slope}) px/frame")));
    }
    named(&response, egui::Role::Image, format!("Chart with {} discs", looked.truth.features.len()));
    let Some(pos) = response.hover_pos() else { return };
    let pointed = marks.iter().filter(|(centre, radius, _)| centre.distance(pos) <= radius.max(4.0));
    if let Some(text) = nearest(pointed.map(|(centre, _, text)| (centre.distance(pos), text)), f32::INFINITY) {
        response.on_hover_text_at_pointer(text);
    }
}
