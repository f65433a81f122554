//! Selected feature: all its numbers, its patch in the motion stack at its slope and in one frame, its descriptor.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::canvas::signed_number;
use crate::app::panel::descriptor::descriptor_ui;
use crate::app::panel::patch::{PatchTexture, PatchView};
use crate::app::panel::widgets::{number_row_ui, section_ui};
use crate::app::project::Model;
use crate::app::project::workspace::Workspace;
use crate::detector::Feature;
use crate::requests::PictureKind;
use egui::{RichText, Sense, Ui, Vec2};

/// State of the panel, kept between passes: the two patches.
#[derive(Default)]
pub struct SelectionState {
    stack: PatchTexture,
    frame: PatchTexture,
}

/// Draws the buttons that walk through the listed features or matches.
pub(in crate::app) fn walk_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        button_ui(ui, model, queue, ActionId::PreviousFeature, Some("Previous"));
        button_ui(ui, model, queue, ActionId::NextFeature, Some("Next"));
        button_ui(ui, model, queue, ActionId::GoToFeature, Some("Go to"));
        button_ui(ui, model, queue, ActionId::ClearSelection, Some("Clear"));
        if model.workspace == Workspace::Inspect && model.selected.is_some() {
            button_ui(ui, model, queue, ActionId::ProbeFeature, Some("Why?"));
        }
    });
}

/// Draws the section.
pub fn selection_ui(ui: &mut Ui, model: &mut Model, state: &mut SelectionState, queue: &mut Queue) {
    section_ui(ui, "Selected feature", |ui| {
        walk_ui(ui, model, queue);
        let (Some(index), Some(feature)) = (model.selected, model.selected_feature().copied()) else {
            ui.add_space(4.0);
            ui.weak("Click a feature in the picture or a row of the table.");
            return;
        };
        if model.stale().is_some() {
            ui.label(RichText::new("Stale: found with other parameters").color(crate::app::style::warning(ui)));
        }
        ui.add_space(4.0);
        patches_ui(ui, model, state, &feature);
        ui.add_space(4.0);
        numbers_ui(ui, index, &feature, model.coherence_text(index));
        ui.add_space(6.0);
        let descriptor = model.slots.a.found.as_ref().and_then(|f| f.detection.descriptors.get(index).copied());
        if let Some(descriptor) = descriptor {
            ui.label(RichText::new("Descriptor").small().weak());
            let side = ui.available_width().min(200.0);
            let colour = ui.visuals().hyperlink_color;
            descriptor_ui(ui, "Descriptor", &descriptor, side, colour);
        }
    });
}

fn numbers_ui(ui: &mut Ui, index: usize, f: &Feature, coherence: Option<String>) {
    egui::Grid::new("numbers").num_columns(2).spacing([12.0, 2.0]).striped(true).min_col_width(96.0).show(ui, |ui| {
        let mut row = |name: &str, help: &str, value: String| number_row_ui(ui, name, help, &value);
        row("Rank", "By |D|·√SNR, from 1", format!("{}", index + 1));
        row(
            "Place (u, v)",
            "At mid-burst, pixels; the centre of the first pixel is (0, 0)",
            format!("{:.2}, {:.2} px", f.u, f.v),
        );
        row("Scale σ", "Of the blob, in input pixels", format!("{:.2} px", f.sigma));
        row("Orientation", "From +u towards +v, clockwise on screen", format!("{:.1}°", f.orientation.to_degrees()));
        row(
            "Slope (u, v)",
            "Apparent motion, refined between the grid's slopes",
            format!("{:+.3}, {:+.3} px/frame", f.slope.u, f.slope.v),
        );
        row("Speed", "Length of the slope", format!("{:.3} px/frame", f.slope.magnitude()));
        row(
            "Response",
            "Interpolated DoG value; bright blobs are negative",
            format!("{} of full scale", signed_number(f.response, 4)),
        );
        row("SNR", "|response| over the noise in D", format!("{:.1}", f.snr));
        if let Some(coherence) = coherence {
            row(
                "Coherence",
                "How well the single frames agree along its motion: 1 if all respond alike, less for a ghost",
                coherence,
            );
        }
        row("Octave, level", "Where in the scale space it was found", format!("{}, {}", f.octave, f.level));
        row(
            "Slope index",
            "Index of the slope of the grid at which it was found, from 0",
            format!("{}", f.slope_index),
        );
        row(
            "At slope limit",
            "Whether its slope is at the end of the searched range; its true motion may then lie beyond",
            if f.at_slope_limit { "yes" } else { "no" }.to_owned(),
        );
    });
}

fn patches_ui(ui: &mut Ui, model: &Model, state: &mut SelectionState, feature: &Feature) {
    let Some(burst) = &model.slots.a.burst else { return };
    let display = model.look.ranges.intensity;
    let side = (0.5 * (ui.available_width() - 8.0)).clamp(60.0, 150.0);
    let stack = model
        .patch
        .as_ref()
        .filter(|p| p.request.burst.id == burst.id && p.request.kind == PictureKind::Stack { slope: feature.slope });
    ui.horizontal(|ui| {
        ui.vertical(|ui| {
            ui.set_width(side);
            match stack {
                Some(picture) => {
                    let name = "Patch in the motion stack";
                    let view = PatchView { name, plane: &picture.plane, feature: *feature, turned: false, display };
                    view.ui(ui, &mut state.stack, side);
                }
                None => {
                    ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
                }
            }
            ui.label(RichText::new("Motion stack").small().weak());
        });
        ui.vertical(|ui| {
            ui.set_width(side);
            let t = model.cursor().frame.min(burst.burst.len() - 1);
            let used = model.slots.a.found.as_ref().map_or(0..burst.burst.len(), |f| f.detection.frames_used.clone());
            // In a frame the feature lies further along its slope, away from the middle of the frames used.
            let dt = t as f32 - (used.start + used.end - 1) as f32 / 2.0;
            let (u, v) = (feature.u + dt * feature.slope.u, feature.v + dt * feature.slope.v);
            let plane = &burst.burst.frames[t];
            let name = "Patch in one frame";
            let feature = Feature { u, v, ..*feature };
            PatchView { name, plane, feature, turned: false, display }.ui(ui, &mut state.frame, side);
            ui.label(RichText::new(format!("Frame {t}")).small().weak());
        });
    });
}
