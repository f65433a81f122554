//! What each method looks at, as a picture with its features, in a pane of its own or over another.

use crate::app::canvas::overlay::{self, ColourScale, OverlayStyle};
use crate::app::canvas::{self, Canvas, CanvasOutput, Picture, RectTransform, View};
use crate::app::inspector::chip_ui;
use crate::app::pane::PaneId;
use crate::app::panel::features::{at_time, frames_from_middle};
use crate::app::panel::picture::canvas_picture;
use crate::app::project::Model;
use crate::app::project::compare::Contender;
use crate::app::project::look::RangeClass;
use crate::app::project::pair::Side;
use crate::detector::Feature;
use crate::plane::Plane;
use crate::plane::display::Display;
use egui::{Align2, RichText, Ui};
use std::collections::HashMap;
use std::sync::Arc;

/// The pictures that were shown last: the same pixels keep their name, so that the card gets them once.
#[derive(Default)]
pub struct ComparePictures {
    shown: HashMap<(Contender, Side), Picture>,
    /// From image pixels to points of the window, as each method's picture was last drawn.
    pub drawn: HashMap<(Contender, Side), RectTransform>,
}

/// A method's picture, with how it looks.
pub struct MethodPicture {
    /// The picture; `None` while there is none.
    pub picture: Option<Picture>,
    /// Its range and colours.
    pub display: Display,
    /// Whether it is still of something else.
    pub stale: bool,
    /// The file's value of 1.0.
    pub full_scale: f32,
}

impl ComparePictures {
    /// What `method` looks at on `side`: a frame, the merged image, the sharp image, or the motion stack at the
    /// cursor's slope.
    pub fn of(&mut self, model: &Model, method: Contender, side: Side) -> MethodPicture {
        let burst = model.method_burst(method, side);
        let full_scale = burst.map_or(1.0, |open| open.burst.full_scale);
        let intensity = model.ranges_of_side(side).display(RangeClass::Intensity);
        let none = |display| MethodPicture { picture: None, display, stale: false, full_scale };
        let found = model.method_found(method, side);
        match method {
            Contender::Buff1d | Contender::Buff2d => {
                let Some(picture) = model.picture_of(side) else { return none(intensity) };
                let display = model.display_of(PaneId::of(side));
                let stale = !model.is_current(PaneId::of(side));
                let picture = self.kept(method, side, &picture.plane, || canvas_picture(picture));
                MethodPicture { picture: Some(picture), display, stale, full_scale }
            }
            Contender::Merge => {
                let Some(image) = found.and_then(|f| f.image.clone()) else { return none(intensity) };
                let picture = self.kept(method, side, &image, || Picture::new(image.clone(), "Merged frames"));
                MethodPicture { picture: Some(picture), display: intensity, stale: false, full_scale }
            }
            Contender::Sift | Contender::Gold => {
                let Some(open) = burst else { return none(intensity) };
                let t = model.method_params(method, side).used_frames(open.burst.len()).start;
                let Some(frame) = open.burst.frames.get(t).cloned() else { return none(intensity) };
                let label = if method == Contender::Gold { "Sharp image".to_owned() } else { format!("Frame {t}") };
                let picture = self.kept(method, side, &frame, || Picture::new(frame.clone(), label));
                let gold = model.compare.gold[side as usize].as_ref().filter(|_| method == Contender::Gold);
                let display = gold.map_or(intensity, |gold| gold.display);
                MethodPicture { picture: Some(picture), display, stale: false, full_scale }
            }
        }
    }

    fn kept(&mut self, method: Contender, side: Side, plane: &Arc<Plane>, make: impl FnOnce() -> Picture) -> Picture {
        match self.shown.get(&(method, side)) {
            Some(picture) if Arc::ptr_eq(&picture.plane, plane) => picture.clone(),
            _ => {
                let picture = make();
                self.shown.insert((method, side), picture.clone());
                picture
            }
        }
    }

    /// A canvas for it, called `name`.
    pub fn canvas<'a>(shown: &'a MethodPicture, name: &'a str) -> Canvas<'a> {
        Canvas::new(name)
            .picture(shown.picture.as_ref())
            .display(&shown.display)
            .dim(shown.stale)
            .full_scale(shown.full_scale)
            .empty_text("Not made yet")
    }

    /// Draws a pane of its own for `method`, with its features and its name. Answers what the canvas says.
    pub fn pane_ui(
        &mut self,
        ui: &mut Ui,
        model: &Model,
        (method, side): (Contender, Side),
        view: &mut View,
    ) -> CanvasOutput {
        let shown = self.of(model, method, side);
        let name = format!("{}: {}", side.name(), method.label());
        let output = Self::canvas(&shown, &name).show(ui, view);
        self.drawn.insert((method, side), output.ui_from_image);
        features_ui(ui, model, method, side, &output);
        label_ui(ui, &output, model, (method, side), Align2::LEFT_TOP);
        output
    }
}

/// The features that `method` found, over its picture.
pub fn features_ui(ui: &Ui, model: &Model, method: Contender, side: Side, output: &CanvasOutput) {
    let Some(found) = model.method_found(method, side).filter(|_| model.compare.look.features) else { return };
    let is_buff = matches!(method, Contender::Buff1d | Contender::Buff2d);
    // Where burst features are in the frame that is shown, if one is.
    let dt = frames_from_middle(model.picture_of(side), &found.detection).filter(|_| is_buff).unwrap_or(0.0);
    let features: Vec<Feature> = found.detection.features.iter().map(|f| at_time(f, dt)).collect();
    let scale = ColourScale::of(model.colour_by, &found.detection.features);
    let hovered = output
        .pointer_ui
        .filter(|pos| output.painter.clip_rect().contains(*pos))
        .and_then(|pos| overlay::feature_at(&features, None, output.ui_from_image, pos));
    let style = OverlayStyle {
        hovered,
        orientations: false,
        motion: model.look.motion_vectors && is_buff,
        ..OverlayStyle::new(&scale, found.detection.frames_used.len())
    };
    overlay::draw_features(output, &features, &style);
    if let Some(f) = hovered.filter(|_| !output.response.dragged()).map(|i| features[i]) {
        let text = format!(
            "{}\nσ {:.2} px  slope ({:+.2}, {:+.2}) px/frame\nresponse {}  SNR {:.1}",
            method.label(),
            f.sigma,
            f.slope.u,
            f.slope.v,
            canvas::number(f.response, 3),
            f.snr
        );
        let (id, anchor) = (egui::Id::unique("compare tip"), egui::PopupAnchor::Pointer);
        egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), id, anchor)
            .gap(14.0)
            .show(|ui| ui.label(RichText::new(text).monospace()));
    }
}

/// Which method it is and how much it found, in a corner of its picture.
pub fn label_ui(ui: &Ui, output: &CanvasOutput, model: &Model, (method, side): (Contender, Side), corner: Align2) {
    let count = model.method_found(method, side).map_or_else(
        || if model.compare.problem(method).is_some() { "not searched".to_owned() } else { "…".to_owned() },
        |found| crate::inspect::words::counted(found.detection.features.len(), "feature"),
    );
    chip_ui(ui, output, corner, &format!("{}  ·  {count}", method.label()), (method, side, corner));
}
