//! Noise of the burst as the last detection estimated it: over brightness, as a map, and what is wrong with it.

use crate::app::document::{Action, Queue, Side};
use crate::app::panel::widgets::{instead_ui, small_text, warning_ui};
use crate::app::results::{FoundFeatures, Read};
use crate::app::{canvas::number, canvas::overlay::rgb};
use crate::detector::noise_model::NoiseModel;
use crate::requests::ViewKind;
use egui::{Align2, Painter, Pos2, Rect, RichText, ScrollArea, Sense, Stroke, Ui, vec2};

/// Size of the plot and of the map, points.
const PLOT: egui::Vec2 = vec2(280.0, 130.0);
const MAP_CELLS: usize = 64;

pub fn summary(_: Read<'_>, found: &FoundFeatures) -> Option<[String; 2]> {
    let noise = &found.detection.noise;
    let sigma = number(noise.frame_noise, 3);
    let text = if noise.is_local {
        let (all, kept) = (noise.frames.len(), noise.frames.iter().filter(|f| f.left_out.is_none()).count());
        format!("Measured in {kept} of {all} frames  ·  σ {sigma} of full scale at middle brightness")
    } else {
        format!("White noise  ·  σ {sigma} of full scale")
    };
    Some([text.clone(), text])
}

pub fn noise_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let Some(found) = &model.results.slots.a.found else {
        return instead_ui(ui, model.without_features(Side::A, "Press Detect to measure the noise"));
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        warnings_ui(ui, found);
        if found.detection.noise.is_local {
            show_ui(ui, model, &found.detection.noise, queue);
            ui.horizontal(|ui| {
                curve_ui(ui, &found.detection.noise);
                ui.add_space(16.0);
                map_ui(ui, model, &found.detection.noise);
            });
        } else {
            ui.weak("The noise was not measured by place: the noise model is white, or the burst is too small. At least two frames of 20 × 20 pixels are needed.");
        }
    });
}

fn show_ui(ui: &mut Ui, model: Read<'_>, noise: &NoiseModel, queue: &mut Queue) {
    let curve = &noise.transfer;
    ui.horizontal_wrapped(|ui| {
        let text = format!("σ² = a·I + b:  a = {}, b = {}", number(curve.slope, 3), number(curve.dark, 3));
        ui.label(text).on_hover_text(
            "Variance of a frame's noise at intensity I, both as fractions of full scale: a is the shot noise per unit \
             of intensity, b the variance in the dark",
        );
        let tip = format!("{} (Shift+N)", ViewKind::Noise.about().help);
        let response = ui.button("Show σ in the picture").on_hover_text(tip);
        queue.push_if(response.clicked(), Action::Show(model.document.focus(), ViewKind::Noise));
    });
}

pub fn warnings_ui(ui: &mut Ui, found: &FoundFeatures) {
    for warning in &found.detection.noise.warnings {
        ui.add_space(4.0);
        warning_ui(ui, format!("Noise: {}.", warning.text));
    }
}

/// Draws a frame with a heading, for a plot of size [`PLOT`]; returns its inside.
fn plot_frame(ui: &mut Ui, heading: &str, hover: &str) -> (Rect, Painter) {
    ui.vertical(|ui| {
        ui.label(RichText::new(heading).small());
        let (rect, response) = ui.allocate_exact_size(PLOT, Sense::hover());
        response.on_hover_text(hover);
        ui.painter().rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
        (rect, ui.painter().with_clip_rect(rect))
    })
    .inner
}

/// Draws σ of a frame over brightness: the fitted curve, and a point for each group of places.
fn curve_ui(ui: &mut Ui, noise: &NoiseModel) {
    let hover = "Standard deviation of a frame's noise, which grows with brightness; each point is a group of places of similar brightness";
    let (rect, painter) = plot_frame(ui, "σ of a frame over brightness (of full scale)", hover);
    let points = &noise.transfer.points;
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
    let span = (last.brightness - first.brightness).max(1e-3);
    let (low, high) = (first.brightness - 0.05 * span, last.brightness + 0.05 * span);
    let sigma_at = |brightness: f32| noise.transfer.variance(brightness).sqrt();
    let sigmas = points.iter().map(|p| p.variance.sqrt()).chain([low, high].map(sigma_at));
    let top = sigmas.fold(1e-6, f32::max) * 1.15;
    let inner = rect.shrink2(vec2(8.0, 18.0));
    let place = |brightness: f32, sigma: f32| -> Pos2 {
        let part = vec2((brightness - low) / (high - low), -sigma / top);
        inner.left_bottom() + part * inner.size()
    };
    let steps = (0..=60).map(|i| low + (high - low) * i as f32 / 60.0);
    let curve = steps.map(|brightness| place(brightness, sigma_at(brightness))).collect();
    painter.line(curve, Stroke::new(1.5, crate::app::style::ACCENT));
    for point in points {
        painter.circle_filled(place(point.brightness, point.variance.sqrt()), 2.5, ui.visuals().text_color());
    }
    small_text(ui, &painter, rect.left_top() + vec2(4.0, 2.0), Align2::LEFT_TOP, &number(top, 3));
    small_text(ui, &painter, rect.left_bottom() + vec2(4.0, -2.0), Align2::LEFT_BOTTOM, &number(low.max(0.0), 3));
    small_text(ui, &painter, rect.right_bottom() + vec2(-4.0, -2.0), Align2::RIGHT_BOTTOM, &number(high, 3));
}

fn map_ui(ui: &mut Ui, model: Read<'_>, noise: &NoiseModel) {
    let Some(burst) = &model.results.slots.a.burst else { return };
    let (width, height) = burst.burst.size();
    let hover = "σ of a frame's noise by place, at the finest octave: bright is more";
    let (rect, painter) = plot_frame(ui, "σ of a frame by place", hover);
    let cell_px = (width.max(height) as f32 / MAP_CELLS as f32).max(1.0);
    let map = noise.sigma_map((width, height), cell_px);
    let (min, max) = map.data().iter().fold((f32::INFINITY, 0.0f32), |(a, b), &x| (a.min(x), b.max(x)));
    let lut = crate::plane::display::ColourMap::Viridis.lut();
    let side = ((rect.width() - 8.0) / map.width() as f32).min((rect.height() - 24.0) / map.height() as f32);
    for y in 0..map.height() {
        for x in 0..map.width() {
            let t = if max > min { (map.at(x, y) - min) / (max - min) } else { 0.0 };
            let corner = rect.left_top() + vec2(4.0 + x as f32 * side, 4.0 + y as f32 * side);
            let cell = Rect::from_min_size(corner, vec2(side + 0.5, side + 0.5));
            painter.rect_filled(cell, 0.0, rgb(lut[(t * 255.0) as usize]));
        }
    }
    let (low, high) = (number(min, 3), number(max, 3));
    let range = if max > min * 1.001 { format!("{low} … {high}") } else { format!("{high} everywhere") };
    small_text(ui, &painter, rect.left_bottom() + vec2(4.0, -2.0), Align2::LEFT_BOTTOM, &range);
}
