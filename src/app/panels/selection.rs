//! The selected feature: all its numbers, its patch where the burst agrees and where one frame shows it, its descriptor.

use super::descriptor::descriptor_ui;
use super::widgets::{number_row_ui, section_ui};
use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::canvas::overlay::circle_radius_image;
use crate::app::state::Model;
use crate::detector::Feature;
use crate::engine::PictureKind;
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use crate::plane::sample::sample_patch;
use egui::{Color32, Rect, RichText, Sense, Stroke, TextureHandle, TextureOptions, Ui, Vec2};
use std::sync::Arc;

/// Samples on a side of a patch.
const PATCH_SAMPLES: usize = 72;
/// A patch reaches this many σ to each side.
const PATCH_SIGMAS: f32 = 6.0;

/// What the panel keeps from pass to pass: the two patches as textures, and what they show.
#[derive(Default)]
pub struct SelectionState {
    stack: Option<(PatchKey, TextureHandle)>,
    frame: Option<(PatchKey, TextureHandle)>,
}

#[derive(Clone, Copy, PartialEq)]
struct PatchKey {
    plane: usize,
    centre: (f32, f32),
    half_width_px: f32,
    display: Display,
    dark: bool,
}

/// Draws the section.
pub fn selection_ui(ui: &mut Ui, model: &mut Model, state: &mut SelectionState, queue: &mut Queue) {
    section_ui(ui, "Selected feature", |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            button_ui(ui, model, queue, ActionId::PreviousFeature, Some("Previous"));
            button_ui(ui, model, queue, ActionId::NextFeature, Some("Next"));
            button_ui(ui, model, queue, ActionId::GoToFeature, Some("Go to"));
            button_ui(ui, model, queue, ActionId::ClearSelection, Some("Clear"));
        });
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
        numbers_ui(ui, index, &feature);
        ui.add_space(6.0);
        let descriptor = model.found.as_ref().and_then(|f| f.detection.descriptors.get(index).copied());
        if let Some(descriptor) = descriptor {
            ui.label(RichText::new("Descriptor").small().weak());
            let side = ui.available_width().min(200.0);
            let colour = ui.visuals().hyperlink_color;
            descriptor_ui(ui, &descriptor, side, colour);
        }
    });
}

fn numbers_ui(ui: &mut Ui, index: usize, f: &Feature) {
    egui::Grid::new("numbers").num_columns(2).spacing([12.0, 2.0]).striped(true).min_col_width(96.0).show(ui, |ui| {
        let mut row = |name: &str, help: &str, value: String| number_row_ui(ui, name, help, &value);
        row("Rank", "By strength of the response", format!("{}", index + 1));
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
            format!("{:+.5} of full scale", f.response),
        );
        row("SNR", "|response| over the noise in D", format!("{:.1}", f.snr));
        row("Octave, level", "Where in the scale space it was found", format!("{}, {}", f.octave, f.level));
        row("Slope index", "Running index of the grid's slope at which it was found", format!("{}", f.slope_index));
        row(
            "At slope limit",
            "On the rim of the grid: the true motion may lie outside",
            if f.at_slope_limit { "yes" } else { "no" }.to_owned(),
        );
    });
}

fn patches_ui(ui: &mut Ui, model: &Model, state: &mut SelectionState, feature: &Feature) {
    let Some(burst) = &model.burst else { return };
    let (display, dark) = (model.look.intensity, ui.visuals().dark_mode);
    let half_width_px = (PATCH_SIGMAS * feature.sigma).max(4.0);
    let side = (0.5 * (ui.available_width() - 8.0)).clamp(60.0, 150.0);
    let stack = model
        .patch
        .as_ref()
        .filter(|p| p.request.burst.id == burst.id && p.request.kind == PictureKind::Stack { slope: feature.slope });
    ui.horizontal(|ui| {
        ui.vertical(|ui| {
            ui.set_width(side);
            let centre = (feature.u, feature.v);
            match stack {
                Some(picture) => {
                    let key =
                        PatchKey { plane: Arc::as_ptr(&picture.plane) as usize, centre, half_width_px, display, dark };
                    patch_ui(ui, "Patch in the motion stack", &mut state.stack, key, &picture.plane, feature, side);
                }
                None => {
                    ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
                }
            }
            ui.label(RichText::new("Motion stack").small().weak());
        });
        ui.vertical(|ui| {
            ui.set_width(side);
            let t = model.scrub.frame.min(burst.burst.len() - 1);
            let used = model.found.as_ref().map_or(0..burst.burst.len(), |f| f.detection.frames_used.clone());
            // Frames move the feature along its slope away from the middle of those used.
            let dt = t as f32 - (used.start + used.end - 1) as f32 / 2.0;
            let centre = (feature.u + dt * feature.slope.u, feature.v + dt * feature.slope.v);
            let plane = &burst.burst.frames[t];
            let key = PatchKey { plane: Arc::as_ptr(plane) as usize, centre, half_width_px, display, dark };
            patch_ui(ui, "Patch in one frame", &mut state.frame, key, plane, feature, side);
            ui.label(RichText::new(format!("Frame {t}")).small().weak());
        });
    });
}

/// A patch with the feature's circle, as large as the feature is in it.
fn patch_ui(
    ui: &mut Ui,
    name: &str,
    cached: &mut Option<(PatchKey, TextureHandle)>,
    key: PatchKey,
    plane: &Plane,
    feature: &Feature,
    side: f32,
) {
    if cached.as_ref().is_none_or(|(k, _)| *k != key) {
        let patch = sample_patch(plane, key.centre, key.half_width_px, PATCH_SAMPLES);
        let mut rgba = to_rgba8(&patch, &key.display);
        let beside = if ui.visuals().dark_mode { 20 } else { 206 };
        for (pixel, value) in rgba.pixels_mut().zip(patch.data()) {
            if value.is_nan() {
                // Beside the picture: the same neutral grey as around it.
                pixel.0 = [beside, beside, beside, 255];
            }
        }
        let image = egui::ColorImage::from_rgba_unmultiplied([PATCH_SAMPLES; 2], rgba.as_raw());
        *cached = Some((key, ui.ctx().load_texture(name, image, TextureOptions::NEAREST)));
    }
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
    if let Some((_, texture)) = cached {
        let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        ui.painter().image(texture.id(), rect, whole, Color32::WHITE);
    }
    let points_per_px = 0.5 * side / key.half_width_px;
    let radius = circle_radius_image(feature) * points_per_px;
    for (width, colour) in [(3.0, Color32::from_black_alpha(140)), (1.4, Color32::from_rgb(255, 214, 90))] {
        ui.painter().circle_stroke(rect.center(), radius, Stroke::new(width, colour));
        let tip = rect.center() + radius * Vec2::angled(feature.orientation);
        ui.painter().line_segment([rect.center(), tip], Stroke::new(width, colour));
    }
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    response.on_hover_text(format!("{name}: {:.0} px to each side", key.half_width_px));
}
