//! The middle of the window: the picture, the features over it, and what says what is on show.

use super::features::features_ui;
use crate::app::actions::{ActionId, Queue};
use crate::app::canvas::{self, Canvas, Readout, View, overlay};
use crate::app::state::look::RangeClass;
use crate::app::state::{Model, Stale};
use crate::app::style;
use crate::engine::{Picture, PictureKind};
use egui::{Align, Frame, Label, Layout, Margin, Rect, RichText, Ui, UiBuilder, vec2};
use std::sync::Arc;

/// What the picture's widget keeps from pass to pass.
#[derive(Default)]
pub struct PictureState {
    /// The value under the pointer.
    pub readout: Option<Readout>,
    /// What of the image plane is visible, in image pixels.
    pub visible_image: Option<Rect>,
    /// From image pixels to points of the window, as last drawn.
    pub ui_from_image: Option<canvas::RectTransform>,
    shown: Option<canvas::Picture>,
    scale: Option<(usize, overlay::ColourBy, overlay::ColourScale)>,
}

impl PictureState {
    /// The picture as the canvas knows it. The same pixels keep their name, so that the card gets them once.
    pub(in crate::app) fn refresh(&mut self, picture: Option<&Picture>) {
        let Some(picture) = picture else {
            self.shown = None;
            return;
        };
        let same = self.shown.as_ref().is_some_and(|s| Arc::ptr_eq(&s.plane, &picture.plane));
        match (&mut self.shown, same) {
            (Some(shown), true) => shown.label = describe(picture),
            _ => self.shown = Some(canvas_picture(picture)),
        }
    }

    /// The picture on show.
    pub fn shown(&self) -> Option<&canvas::Picture> {
        self.shown.as_ref()
    }

    /// The colours of the features, the same until the next detection or another choice.
    pub fn colour_scale(&mut self, model: &Model) -> overlay::ColourScale {
        let detection = model.found.as_ref().map_or(0, |f| Arc::as_ptr(&f.detection) as usize);
        match &self.scale {
            Some((of, by, scale)) if (*of, *by) == (detection, model.colour_by) => scale.clone(),
            _ => {
                let scale = overlay::ColourScale::of(model.colour_by, model.features());
                self.scale = Some((detection, model.colour_by, scale.clone()));
                scale
            }
        }
    }
}

/// A picture as a canvas knows it, with a fresh name.
pub(in crate::app) fn canvas_picture(picture: &Picture) -> canvas::Picture {
    let (plane, label) = (picture.plane.clone(), describe(picture));
    match picture.request.kind {
        PictureKind::Dog { octave, .. } => {
            canvas::Picture::of_octave(plane, octave, picture.request.burst.burst.size(), label)
        }
        PictureKind::Frame(_) | PictureKind::Stack { .. } => canvas::Picture::new(plane, label),
    }
}

/// What a picture shows, in one line.
pub fn describe(picture: &Picture) -> String {
    let burst = &picture.request.burst.burst;
    match picture.request.kind {
        PictureKind::Frame(index) => {
            let name = burst.frame_names.get(index).map_or("", String::as_str);
            let place = format!("Frame {index} of {} (0 … {})", burst.len(), burst.len() - 1);
            // Bursts without files call their frames by their number, which was said already.
            if name.is_empty() || *name == format!("frame {index}") { place } else { format!("{place}  ·  {name}") }
        }
        PictureKind::Stack { slope } => format!("Motion stack  ·  slope ({:.2}, {:.2}) px/frame", slope.u, slope.v),
        PictureKind::Dog { octave, level, slope } => {
            format!("DoG  ·  octave {octave}, level {level}  ·  slope ({:.2}, {:.2}) px/frame", slope.u, slope.v)
        }
    }
}

/// Draws the picture with everything over it.
pub fn picture_ui(ui: &mut Ui, model: &mut Model, view: &mut View, state: &mut PictureState, queue: &mut Queue) {
    state.refresh(model.picture.as_ref());
    let class = RangeClass::of(model.picture.as_ref().map_or(model.scrub.picture_kind(), |p| p.request.kind));
    let display = model.look.display(class);
    let header = Frame::new().inner_margin(Margin::symmetric(8, 3)).fill(ui.visuals().panel_fill);
    let current = model.picture_is_current();
    ui.spacing_mut().item_spacing.y = 0.0;
    header.show(ui, |ui| header_ui(ui, state.shown.as_ref(), current, view, (display.min, display.max)));
    let full_scale = model.burst.as_ref().map_or(1.0, |b| b.burst.full_scale);
    let output = Canvas::new("Picture")
        .picture(state.shown.as_ref())
        .display(&display)
        .dim(!current)
        .full_scale(full_scale)
        .empty_text("The picture is being made…")
        .show(ui, view);
    state.readout = match (&state.shown, output.hover_image) {
        (Some(shown), Some(pos)) => canvas::readout(shown, pos, full_scale),
        _ => None,
    };
    state.ui_from_image = Some(output.ui_from_image);
    state.visible_image = state.shown.is_some().then_some(output.visible_image);
    features_ui(ui, model, state, &output);
    stale_ui(ui, model, output.response.rect, queue);
}

fn header_ui(ui: &mut Ui, shown: Option<&canvas::Picture>, current: bool, view: &View, range: (f32, f32)) {
    ui.horizontal(|ui| {
        let label = shown.map_or("", |s| s.label.as_str());
        ui.add(Label::new(RichText::new(label).strong()).truncate());
        if shown.is_some() && !current {
            ui.label(RichText::new("updating…").small().color(style::warning(ui)));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let percent = 100.0 * view.points_per_pixel() * ui.ctx().pixels_per_point();
            ui.weak(format!("{percent:.0} %")).on_hover_text("Zoom: screen pixels per image pixel");
            ui.weak("·");
            let (min, max) = (canvas::number(range.0, 3), canvas::number(range.1, 3));
            ui.weak(format!("{min} … {max}"))
                .on_hover_text("The value range that is shown, as a fraction of full scale; fixed until you change it");
        });
    });
}

fn stale_ui(ui: &mut Ui, model: &Model, rect: Rect, queue: &mut Queue) {
    let Some(stale) = model.stale() else { return };
    if !model.look.overlay || model.busy.detecting.is_some() {
        return;
    }
    let text = match stale {
        Stale::Parameters => "Stale features: the parameters changed",
        Stale::InvalidParameters => "Stale features: the parameters make no sense",
    };
    let room = Rect::from_min_max(rect.left_top() + vec2(10.0, 10.0), rect.right_top() + vec2(-10.0, 44.0));
    ui.scope_builder(UiBuilder::new().max_rect(room).layout(Layout::left_to_right(Align::Min)), |ui| {
        let colour = style::warning(ui);
        Frame::popup(ui.style()).stroke(egui::Stroke::new(1.0, colour)).inner_margin(Margin::symmetric(8, 4)).show(
            ui,
            |ui| {
                ui.label(RichText::new(text).color(colour));
                if stale == Stale::Parameters && ui.small_button("Detect again").clicked() {
                    queue.push(ActionId::Detect);
                }
            },
        );
    });
}
