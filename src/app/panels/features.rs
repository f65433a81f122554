//! The features over the picture: drawn, pointed at, selected, and what their colours mean.

use super::picture::PictureState;
use crate::app::canvas::{CanvasOutput, overlay};
use crate::app::state::Model;
use crate::detector::{Detection, Feature, SlopeGrid};
use crate::engine::{Picture, PictureKind};
use egui::{Color32, Frame, Margin, Rect, RichText, Ui, UiBuilder, vec2};

/// Draws the features over the canvas that answered `output`, and lets the pointer choose among them.
pub fn features_ui(ui: &mut Ui, model: &mut Model, state: &mut PictureState, output: &CanvasOutput) {
    if !model.look.overlay {
        return;
    }
    let Some(found) = &model.found else { return };
    let detection = found.detection.clone();
    // In a frame, features are drawn where they are at its time; everywhere else where they are at mid-burst.
    let in_frame = frames_from_middle(model.picture.as_ref(), &detection);
    let placed: Vec<Feature> = match in_frame {
        Some(dt) => detection.features.iter().map(|f| at_time(f, dt)).collect(),
        None => detection.features.clone(),
    };
    let features = &placed;
    let scale = state.colour_scale(model);
    let shown = model.listed_flags();
    let pointed =
        output.pointer_ui.and_then(|pos| overlay::feature_at(features, Some(&shown), output.ui_from_image, pos));
    if output.pointer_ui.is_some() {
        model.hovered = pointed;
    }
    let style = overlay::OverlayStyle {
        shown: Some(&shown),
        selected: model.selected,
        hovered: model.hovered,
        stale: model.stale().is_some(),
        orientations: model.look.orientations,
        motion: model.look.motion_vectors,
        ..overlay::OverlayStyle::new(&scale, detection.frames_used.len())
    };
    if in_frame.is_some() {
        // The way over the whole burst stays where it is; the circles move along it.
        let ways = overlay::OverlayStyle { circles: false, orientations: false, ..style };
        overlay::draw_features(output, &detection.features, &ways);
        overlay::draw_features(output, features, &overlay::OverlayStyle { motion: false, ..style });
    } else {
        draw(model, features, &shown, &style, output, near_slope(&detection.slopes));
    }
    if output.response.clicked() {
        model.selected = pointed;
    }
    if let Some(i) = pointed
        && !output.response.dragged()
    {
        tip_ui(ui, i, &features[i]);
    }
    if model.look.legend && !features.is_empty() {
        legend_ui(ui, &scale, model.slope_in_picture().is_some(), output.response.rect);
    }
}

/// How many frames the frame in `picture` is after the middle of those that were searched; `None` when it is no frame.
pub(in crate::app) fn frames_from_middle(picture: Option<&Picture>, detection: &Detection) -> Option<f32> {
    match picture?.request.kind {
        PictureKind::Frame(t) => {
            let used = &detection.frames_used;
            Some(t as f32 - 0.5 * (used.start + used.end - 1) as f32)
        }
        PictureKind::Stack { .. } | PictureKind::Dog { .. } => None,
    }
}

/// The feature where it is `dt` frames after mid-burst.
pub(in crate::app) fn at_time(feature: &Feature, dt: f32) -> Feature {
    Feature { u: feature.u + dt * feature.slope.u, v: feature.v + dt * feature.slope.v, ..*feature }
}

/// In a picture that was shifted by a slope, what moves that way is sharp and the rest is smeared: features of other slopes are drawn faintly.
fn draw(
    model: &Model,
    features: &[Feature],
    shown: &[bool],
    style: &overlay::OverlayStyle<'_>,
    output: &CanvasOutput,
    reach: f32,
) {
    let slope = model.slope_in_picture().unwrap_or(model.scrub.slope);
    let belongs = |i: usize, f: &Feature| {
        (f.slope.u - slope.u).hypot(f.slope.v - slope.v) <= reach || [model.selected, model.hovered].contains(&Some(i))
    };
    let flags = |wanted: bool| -> Vec<bool> {
        features.iter().enumerate().map(|(i, f)| shown[i] && belongs(i, f) == wanted).collect()
    };
    let (faint, full) = (flags(false), flags(true));
    let below = overlay::OverlayStyle {
        shown: Some(&faint),
        stale: true,
        orientations: false,
        motion: false,
        selected: None,
        hovered: None,
        ..*style
    };
    overlay::draw_features(output, features, &below);
    overlay::draw_features(output, features, &overlay::OverlayStyle { shown: Some(&full), ..*style });
}

/// Features within this distance in slope belong to the picture, in pixels per frame: half-way to the grid's next slope, and a little.
fn near_slope(grid: &SlopeGrid) -> f32 {
    (0.55 * grid.u.step().max(grid.v.step())).max(0.1)
}

/// The numbers of the feature under the pointer.
fn tip_ui(ui: &Ui, index: usize, f: &Feature) {
    let text = format!(
        "#{}  σ {:.2} px\nslope ({:+.2}, {:+.2}) px/frame\nresponse {:+.4}  SNR {:.1}",
        index + 1,
        f.sigma,
        f.slope.u,
        f.slope.v,
        f.response,
        f.snr
    );
    let (id, anchor) = (egui::Id::unique("feature tip"), egui::PopupAnchor::Pointer);
    egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), id, anchor)
        .gap(14.0)
        .show(|ui| ui.label(RichText::new(text).monospace()));
}

/// What the colours mean, in the lower left corner; smaller where the picture is small.
fn legend_ui(ui: &mut Ui, scale: &overlay::ColourScale, some_are_faint: bool, rect: Rect) {
    let fill = if ui.visuals().dark_mode { Color32::from_black_alpha(190) } else { Color32::from_white_alpha(225) };
    let frame = Frame::new().fill(fill).corner_radius(5).inner_margin(Margin::symmetric(8, 6));
    let roomy = rect.height() > 340.0 && rect.width() > 480.0;
    let key = if scale.by == overlay::ColourBy::SlopeDirection { 54.0 } else { 28.0 };
    let texts = if roomy { 1 + usize::from(some_are_faint) } else { 0 };
    let height = key + 12.0 + 18.0 * texts as f32;
    let corner = rect.left_bottom() + vec2(10.0, -10.0);
    let room = Rect::from_min_max(corner - vec2(0.0, height), corner + vec2(210.0, 0.0));
    ui.scope_builder(UiBuilder::new().max_rect(room), |ui| {
        ui.spacing_mut().item_spacing.y = 4.0;
        frame.show(ui, |ui| {
            if roomy {
                ui.label(RichText::new(scale.by.name()).small());
            }
            scale.legend_ui(ui);
            if roomy && some_are_faint {
                ui.label(RichText::new("Faint: found at other slopes").small().weak());
            }
        });
    });
}
