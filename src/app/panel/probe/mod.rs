//! Probe panel: the candidates at a place, the reasons for their fates, and what would change them.
//!
//! It shows the answers of [`crate::inspect`]: the fates of the candidates near the place, the response over slope and
//! scale, each frame's share, and suspicions about a feature.

mod fates;
mod map_area;
mod response;
mod shares;
mod suspicions;
mod texture;

pub use texture::PlaneTexture;

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::panel::widgets::section_ui;
use crate::app::parts::mark;
use crate::app::project::Model;
use crate::app::style;
use crate::detector::ParamChange;
use crate::inspect::words::{counted_from_one, number};
use crate::requests::Probed;
use crate::teach::Part;
use egui::{Label, ProgressBar, RichText, ScrollArea, Ui};

/// State of the panel, kept between passes: its pictures as textures.
#[derive(Default)]
pub struct ProbePanel {
    response: PlaneTexture,
    plane: PlaneTexture,
    patches: PlaneTexture,
}

/// Draws the two tabs of the right panel.
pub fn tabs_ui(ui: &mut Ui, model: &mut Model) {
    ui.horizontal(|ui| {
        ui.selectable_value(&mut model.probe.is_open, false, "Display and feature")
            .on_hover_text("The value range of the pictures, and the selected feature");
        ui.selectable_value(&mut model.probe.is_open, true, "Probe")
            .on_hover_text("Why there is a feature at a place, or why there is none");
    });
    ui.separator();
}

/// Draws the panel.
pub fn probe_ui(ui: &mut Ui, model: &mut Model, panel: &mut ProbePanel, queue: &mut Queue) {
    mark(ui, Part::Probe, ui.max_rect());
    tools_ui(ui, model, queue);
    busy_ui(ui, model);
    if let Some(problem) = &model.probe.problem {
        ui.add(Label::new(RichText::new(problem).color(style::warning(ui))).wrap());
    }
    let Some(answer) = model.probe.answer.clone() else {
        if model.probe.question.is_none() {
            ui.add_space(4.0);
            ui.add(Label::new(RichText::new(HOW).weak()).wrap());
        }
        return;
    };
    ScrollArea::vertical().id_salt("probe").auto_shrink(false).show(ui, |ui| {
        let [u, v] = answer.probe.pos_image;
        ui.label(RichText::new(format!("Place ({}, {})", number(u, 1), number(v, 1))).strong())
            .on_hover_text("At mid-burst, pixels; the centre of the first pixel is (0, 0)");
        stale_ui(ui, model, queue);
        ui.add(Label::new(counted_from_one(&answer.probe.summary)).wrap());
        ui.add_space(4.0);
        suspicions::suspicions_ui(ui, model, &answer, queue);
        section_ui(ui, "Candidates here", |ui| fates::fates_ui(ui, model, &answer, queue));
        section_ui(ui, "Response over slope and scale", |ui| {
            response::response_ui(ui, model, &answer, &mut panel.response, &mut panel.plane);
            mark(ui, Part::Response, ui.min_rect());
        });
        section_ui(ui, "Each frame's response", |ui| {
            shares::shares_ui(ui, model, &answer, &mut panel.patches);
            mark(ui, Part::Shares, ui.min_rect());
        });
    });
}

const HOW: &str = "Shift+click a place of a picture to see why there is a feature, or why there is none.";

fn tools_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        button_ui(ui, model, queue, ActionId::ProbeFollow, Some("Follow pointer"));
        button_ui(ui, model, queue, ActionId::ProbeFeature, Some("Selected"));
        button_ui(ui, model, queue, ActionId::ProbeStrongest, Some("Strongest"));
        button_ui(ui, model, queue, ActionId::CloseProbe, Some("Clear probe"));
    });
    ui.add_space(2.0);
}

fn busy_ui(ui: &mut Ui, model: &Model) {
    let waits = model.probe.question.is_some() && model.probe.answer.is_none() && model.probe.problem.is_none();
    match (model.probe.wanted_trail.running(), model.slots.a.detecting.running()) {
        (Some(running), _) | (None, Some(running)) if model.probe.is_on() => {
            let fraction = running.progress.map_or(0.0, |p| p.fraction);
            ui.add(ProgressBar::new(fraction).text(format!("Searching  {:.0} %", 100.0 * fraction)));
        }
        _ if waits => {
            ui.weak("Probing…");
        }
        _ => {}
    }
}

/// Draws a warning when the answer belongs to other parameters.
fn stale_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    if model.probe_is_stale() && !model.slots.a.detecting.is_pending() {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("Stale: found with other parameters").color(style::warning(ui)));
            if ui.small_button("Detect again").on_hover_text("Search with the parameters as they are now").clicked() {
                queue.push(ActionId::Detect);
            }
        });
    }
}

/// Draws a button that changes a parameter and searches again.
fn apply_ui(ui: &mut Ui, model: &mut Model, change: &ParamChange, queue: &mut Queue) {
    let response = ui.button("Apply").on_hover_text(format!(
        "Set {} and detect again; Undo reverts it\n{}",
        change.label(),
        change.option()
    ));
    let name = format!("Apply {}", change.label());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    if response.clicked() {
        model.apply_change(change);
        if !model.auto_detect {
            queue.push(ActionId::Detect);
        }
    }
}

/// Text of a response's strength: in σ of its noise, or D itself where there is no noise.
fn strength_text(answer: &Probed, value: f32) -> String {
    if answer.probe.response.is_noiseless { format!("{value:+.1e}") } else { format!("{value:+.1} σ") }
}
