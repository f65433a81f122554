//! Things planted in the open burst: how faint a thing is seen at each place, and what became of one.

use super::{FOUND, MISSED};
use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::{Action, Lab};
use crate::app::panel::widgets::{WHOLE, dots_ui, draw_plane, named, only_ui, weak_ui};
use crate::app::results::Read;
use crate::detector::Test;
use crate::inspect::words::number;
use crate::plane::display::{ColourMap, Display};
use crate::recover::{Planted, RecoverReport};
use egui::{Label, Rect, RichText, Sense, Stroke, Ui, vec2};

/// Maximum distance of the pointer from a thing, in points of the window.
const REACH_UI: f32 = 10.0;

pub fn lab_planted_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let Some((_, report)) = model.results.studies.recovered() else {
        let text = "Press Run study: things are planted in copies of the open burst and searched for. Here is then how faint a thing is seen at each place.";
        return only_ui(ui, text);
    };
    key_ui(ui, report);
    let chosen = map_ui(ui, model, report);
    if let Some(outlook) = report.outlook() {
        weak_ui(ui, outlook);
    }
    for fate in &report.fates {
        ui.label(RichText::new(format!("{} missed: {}", fate.count, fate.reason)).small());
    }
    let mut selected = chosen.or(model.document.lab.selected_thing);
    let missed = next_missed(report, selected);
    let next = ui.add_enabled(missed.is_some(), egui::Button::new("Next missed"));
    if next.on_hover_text("Look at the next thing in the range of the slopes that was missed").clicked() {
        selected = missed;
    }
    queue.set(&model.document.lab.selected_thing, selected, |selected_thing| {
        Action::SetLab(Box::new(Lab { selected_thing, ..model.document.lab.clone() }))
    });
    match model.selected_thing() {
        None => _ = weak_ui(ui, "Click a thing to see what became of it."),
        Some(one) => {
            ui.add(Label::new(thing_text(one)).wrap());
            button_ui(ui, model, queue, ActionId::OpenPlanted, None);
        }
    }
}

fn key_ui(ui: &mut Ui, report: &RecoverReport) {
    let found = report.planted.iter().filter(|one| one.found.is_some()).count();
    dots_ui(ui, [(FOUND, format!("{found} found")), (MISSED, format!("{} missed", report.planted.len() - found))]);
    if let Some([min, max]) = report.map_range() {
        let percent = |x: f64| number((100.0 * x) as f32, 3);
        let (min, max) = (percent(min), percent(max));
        weak_ui(ui, format!("Half are found from {min} % (dark) to {max} % (bright) of full scale"));
    }
}

/// Draws the map with the things; returns the one that was clicked.
fn map_ui(ui: &mut Ui, model: Read<'_>, report: &RecoverReport) -> Option<(u64, usize)> {
    let [width, height] = report.size.map(|n| n as f32);
    let scale = ui.available_width() / width;
    let (rect, response) = ui.allocate_exact_size(vec2(width, height) * scale, Sense::click());
    let plane = &report.map.plane;
    let cells = vec2(plane.width() as f32, plane.height() as f32) * (report.map.cell_px as f32 * scale);
    let [min, max] = report.map_range().unwrap_or([0.0, 1.0]).map(|x| x as f32);
    let display = Display { map: ColourMap::Viridis, ..Display::default() }.with_range(min, max.max(1.001 * min));
    let painter = ui.painter().with_clip_rect(rect);
    ui.scope(|ui| {
        ui.set_clip_rect(rect.intersect(ui.clip_rect()));
        let named_rect = ("lab planted", Rect::from_min_size(rect.min, cells));
        draw_plane(ui, named_rect, display, Some((plane.into(), WHOLE, || (**plane).clone())));
    });
    let pos_ui = |one: &Planted| rect.min + scale * vec2(one.truth.u as f32 + 0.5, one.truth.v as f32 + 0.5);
    let in_range = || report.planted.iter().filter(|one| one.is_in_range);
    for one in in_range() {
        let radius = if model.document.lab.selected_thing == Some((one.seed, one.truth.id)) { 5.0 } else { 2.2 };
        match one.found {
            Some(_) => painter.circle_filled(pos_ui(one), radius, FOUND),
            None => painter.circle_stroke(pos_ui(one), radius, Stroke::new(1.2, MISSED)),
        };
    }
    named(&response, egui::Role::Image, format!("Map of {} planted things", report.planted.len()));
    let pos = response.hover_pos()?;
    let pointed = crate::app::view::nearest(in_range().map(|one| (pos_ui(one).distance(pos), one)), REACH_UI)?;
    let clicked = response.clicked().then_some((pointed.seed, pointed.truth.id));
    response.on_hover_text_at_pointer(thing_text(pointed));
    clicked
}

fn next_missed(report: &RecoverReport, selected: Option<(u64, usize)>) -> Option<(u64, usize)> {
    let missed: Vec<(u64, usize)> = (report.planted.iter())
        .filter(|one| one.is_in_range && one.found.is_none() && one.failed != Some(Test::MaxFeatures))
        .map(|one| (one.seed, one.truth.id))
        .collect();
    let after = missed.iter().position(|one| Some(*one) == selected).map_or(0, |at| at + 1);
    missed.get(after).or(missed.first()).copied()
}

fn thing_text(one: &Planted) -> String {
    let t = &one.truth;
    let (snr, frames) = (number(one.snr as f32, 3), one.frames);
    let [radius, u, v] = [t.radius, t.u, t.v].map(|px| number(px as f32, 1));
    let [slope_u, slope_v] = [t.slope_u, t.slope_v].map(|slope| number(slope as f32, 2));
    let slope = format!("slope ({slope_u}, {slope_v}) px/frame at ({u}, {v})");
    let what = format!("SNR {snr}, radius {radius} px, {slope}, in {frames} frames");
    let expected = one.expected_snr_d.map(|snr| format!("; {} σ in D expected", number(snr as f32, 1)));
    let expected = expected.unwrap_or_default();
    match one.found {
        Some(found) => format!("Found with {} σ: {what}{expected}", number(found.snr, 1)),
        None => format!("Missed, {}: {what}{expected}", one.why),
    }
}
