//! Picture of one pane, and another one over it.

use super::widgets::PaneWidgets;
use crate::app::canvas::{Canvas, CanvasOutput};
use crate::app::measure::Tool;
use crate::app::pane::{Over, PaneId};
use crate::app::panel::features::{FeatureOptions, features_ui};
use crate::app::panel::picture::readout_of;
use crate::app::project::Model;
use crate::app::project::look::RangeClass;
use crate::app::project::workspace::Workspace;
use crate::requests::Request;
use egui::{Align2, Color32, CursorIcon, Rect, Sense, Stroke, Ui, pos2, vec2};

/// Drawn pane.
pub struct Drawn {
    /// Pane whose picture is shown: the pane itself or, flipped, another.
    pub shown: PaneId,
    /// Output of the canvas; of a wipe, that of its left part.
    pub output: CanvasOutput,
    /// Pane and canvas of the right part of a wipe.
    pub right: Option<(PaneId, CanvasOutput)>,
}

impl Drawn {
    /// Whether the pointer acted on it: a click, a drag or the wheel.
    pub fn is_touched(&self, ui: &Ui) -> bool {
        let response = &self.output.response;
        let scrolled = response.contains_pointer()
            && ui.input(|i| i.smooth_scroll_delta() != egui::Vec2::ZERO || i.zoom_delta() != 1.0);
        response.clicked() || response.secondary_clicked() || response.drag_started() || scrolled
    }
}

/// Draws the picture of pane `id` on a canvas called `name`; flipped, that of the pane laid over it.
pub(super) fn picture_ui(ui: &mut Ui, model: &mut Model, id: PaneId, widgets: &mut PaneWidgets, name: &str) -> Drawn {
    let over = model.panes.over(id);
    let shown = match over {
        Some(Over::Flip { other, flipped: true }) => other,
        _ => id,
    };
    let picture = model.panes.get(shown).and_then(|pane| pane.picture.as_ref());
    let state = &mut widgets.of(shown).picture;
    state.refresh(picture);
    let problem = problem_of(model, shown);
    let mut view = model.panes.get(id).map(|pane| pane.view).unwrap_or_default();
    let output = canvas_of(model, shown, name)
        .picture(state.shown().filter(|_| problem.is_none()))
        .empty_text(problem.unwrap_or("Computing the picture…"))
        .primary_pans(model.workspace != Workspace::Inspect || model.measure.tool == Tool::Pan)
        .show(ui, &mut view);
    let state = &mut widgets.of(shown).picture;
    let picture = model.panes.get(shown).and_then(|pane| pane.picture.as_ref());
    state.paint_colours(ui, picture, &output);
    state.readout = match (picture, state.shown(), output.hover_image) {
        (Some(picture), Some(canvas), Some(pos)) => readout_of(picture, canvas, pos, full_scale(model, shown)),
        _ => None,
    };
    let visible = state.shown().is_some().then_some(output.visible_image);
    let state = &mut widgets.of(id).picture;
    (state.ui_from_image, state.visible_image) = (Some(output.ui_from_image), visible);
    model.panes.get_mut(id).into_iter().for_each(|pane| pane.view = view);
    Drawn { shown, output, right: None }
}

/// Draws the other picture of a wipe over the drawn one, with its features; the drawn one ends at the line.
pub(super) fn over_ui(ui: &mut Ui, model: &mut Model, id: PaneId, widgets: &mut PaneWidgets, drawn: &mut Drawn) {
    let Some(Over::Wipe { other, at }) = model.panes.over(id) else { return };
    let rect = drawn.output.response.rect;
    let x = egui::lerp(rect.x_range(), at);
    let picture = model.panes.get(other).and_then(|pane| pane.picture.as_ref());
    let state = &mut widgets.of(other).picture;
    state.refresh(picture);
    let right = Rect::from_min_max(pos2(x, rect.top()), rect.max);
    let over = canvas_of(model, other, "Wipe, right side").picture(state.shown()).show_over(ui, &drawn.output, right);
    state.paint_colours(ui, picture, &over);
    drawn.output.painter.set_clip_rect(Rect::from_min_max(rect.min, pos2(x, rect.bottom())));
    features_ui(ui, model, other, &mut widgets.of(other).picture, &over, FeatureOptions { legend: false });
    drawn.right = Some((other, over));
}

/// Draws the names of the pictures, and the line of a wipe, which can be dragged.
pub(super) fn over_names_ui(ui: &Ui, model: &mut Model, id: PaneId, drawn: &Drawn) {
    let name = |model: &Model, id: PaneId| {
        let number = model.panes.number(id).map_or_else(String::new, |number| format!("{number}  ·  "));
        format!("{number}{}", super::compact_description(model, id))
    };
    match model.panes.over(id) {
        None => {}
        Some(Over::Flip { .. }) => {
            chip_ui(ui, &drawn.output, Align2::LEFT_TOP, &name(model, drawn.shown), ("flip", id));
        }
        Some(Over::Wipe { mut at, .. }) => {
            chip_ui(ui, &drawn.output, Align2::LEFT_TOP, &name(model, id), ("wipe left", id));
            if let Some((other, over)) = &drawn.right {
                chip_ui(ui, over, Align2::RIGHT_TOP, &name(model, *other), ("wipe right", id));
            }
            over_handle_ui(ui, &mut at, drawn.output.response.rect);
            if let Some(Over::Wipe { at: now, .. }) = model.panes.get_mut(id).and_then(|pane| pane.over.as_mut()) {
                *now = at;
            }
        }
    }
}

/// Canvas for the picture of `id`, without the picture.
fn canvas_of<'a>(model: &Model, id: PaneId, name: &'a str) -> Canvas<'a> {
    Canvas::new(name).display(&model.display_of(id)).dim(!model.is_current(id)).full_scale(full_scale(model, id))
}

/// Value in the file that became 1.0, of the burst of `id`; 1 where the picture's values are not the file's.
pub(super) fn full_scale(model: &Model, id: PaneId) -> f32 {
    if matches!(model.range_class(id), RangeClass::Share | RangeClass::Motion) {
        return 1.0;
    }
    let burst = model.panes.get(id).and_then(|pane| model.burst_in(pane));
    burst.map_or(1.0, |open| open.burst.full_scale)
}

/// Reason why the picture that `id` needs now cannot be made.
fn problem_of(model: &Model, id: PaneId) -> Option<&str> {
    let wanted = model.wanted(id)?;
    let (request, why) = model.panes.get(id)?.problem.as_ref()?;
    request.is_same(&wanted).then_some(why.as_str())
}

/// Draws the line of a wipe over `rect`, which can be dragged; `at` is 0 … 1 from the left.
fn over_handle_ui(ui: &Ui, at: &mut f32, rect: Rect) {
    let x = egui::lerp(rect.x_range(), *at);
    let line = Rect::from_center_size(pos2(x, rect.center().y), vec2(12.0, rect.height()));
    let response = ui.interact(line, ui.scope_id().with("wipe handle"), Sense::drag());
    if let Some(pos) = response.interact_pointer_pos() {
        *at = ((pos.x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
    }
    let lit = response.hovered() || response.dragged();
    let painter = ui.painter_at(rect);
    for (width, colour) in [(5.0, Color32::from_black_alpha(140)), (if lit { 3.0 } else { 2.0 }, Color32::WHITE)] {
        painter.vline(x, rect.y_range(), Stroke::new(width, colour));
    }
    let grip = pos2(x, rect.center().y);
    painter.circle_filled(grip, 9.0, Color32::from_black_alpha(170));
    painter.circle_stroke(grip, 9.0, Stroke::new(1.5, Color32::WHITE));
    for sign in [-1.0, 1.0] {
        let tip = grip + vec2(6.0 * sign, 0.0);
        for turn in [-1.0, 1.0] {
            painter.line_segment([tip, tip + vec2(-3.0 * sign, 3.0 * turn)], Stroke::new(1.5, Color32::WHITE));
        }
    }
    let value = f64::from(*at);
    response.widget_info(|| egui::WidgetInfo::slider(true, value, "Wipe line"));
    response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
}

/// Draws a text on a dark background in a corner of a picture. `salt` makes its id unique.
pub(in crate::app) fn chip_ui(
    ui: &Ui,
    output: &CanvasOutput,
    corner: Align2,
    text: &str,
    salt: impl std::hash::Hash + std::fmt::Debug,
) {
    let painter = &output.painter;
    let rect = output.response.rect.intersect(painter.clip_rect());
    let galley = painter.layout_no_wrap(text.to_owned(), egui::FontId::proportional(13.0), Color32::WHITE);
    let ground = corner.align_size_within_rect(galley.size() + vec2(14.0, 6.0), rect.shrink(8.0));
    painter.rect_filled(ground, 4.0, Color32::from_black_alpha(190));
    painter.galley(ground.min + vec2(7.0, 3.0), galley, Color32::WHITE);
    let response = ui.interact(ground, output.response.id.with(salt), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, text));
}
