//! Drawing of a line or a rectangle with the pointer, and its display in every measured pane.

use super::values::{mapped, measured_panes};
use super::{MeasuredLine, MeasuredRegion, Tool};
use crate::app::canvas::CanvasOutput;
use crate::app::pane::PaneId;
use crate::app::project::{BottomTab, Model};
use egui::{Color32, PointerButton, Pos2, Rect, Stroke, StrokeKind};

/// Colour of the line and the rectangle.
const COLOUR: Color32 = Color32::from_rgb(255, 214, 90);

/// Handles the pointer on the canvas of pane `id`, while a measuring tool is active.
pub fn draw_ui(model: &mut Model, id: PaneId, output: &CanvasOutput) {
    let response = &output.response;
    let place = |pos: Pos2| output.image_from_ui.pos(pos);
    if model.measure.tool == Tool::Pan {
        return;
    }
    if response.drag_started_by(PointerButton::Primary)
        && let Some(pos) = response.interact_pointer_pos()
    {
        // Place of the press, not the place where the drag was recognised.
        let press = pos - response.total_drag_delta().unwrap_or_default();
        model.measure.drag = Some((id, place(press)));
    }
    let Some((_, from)) = model.measure.drag.filter(|(on, _)| *on == id) else { return };
    if let Some(pos) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        let to = place(pos);
        match model.measure.tool {
            Tool::Line => model.measure.line = Some(MeasuredLine { pane: id, from_image: from, to_image: to }),
            Tool::Region => {
                model.measure.region = Some(MeasuredRegion { pane: id, rect_image: Rect::from_two_pos(from, to) });
            }
            Tool::Pan => {}
        }
    }
    if response.drag_stopped() {
        model.measure.drag = None;
        model.bottom_tab = if model.measure.tool == Tool::Line { BottomTab::Profile } else { BottomTab::Region };
        model.panels.bottom = true;
    }
}

/// Shows the line and the rectangle over the canvas of pane `id`.
pub fn measure_ui(model: &Model, id: PaneId, output: &CanvasOutput) {
    let pos_ui = |pos: Pos2| output.ui_from_image.pos(pos);
    let strokes = [Stroke::new(3.0, Color32::from_black_alpha(150)), Stroke::new(1.2, COLOUR)];
    if let Some(line) = model.measure.line
        && measured_panes(model, line.pane).contains(&id)
        && let [Some(from), Some(to)] = [line.from_image, line.to_image].map(|pos| mapped(model, line.pane, id, pos))
    {
        for stroke in strokes {
            output.painter.line_segment([pos_ui(from), pos_ui(to)], stroke);
        }
        // A ring marks the start of the line.
        output.painter.circle_stroke(pos_ui(from), 3.5, strokes[1]);
    }
    if let Some(region) = model.measure.region
        && measured_panes(model, region.pane).contains(&id)
    {
        let rect = region.rect_image;
        let corners = [rect.min, rect.max].map(|pos| mapped(model, region.pane, id, pos));
        if let [Some(min), Some(max)] = corners {
            let rect = Rect::from_min_max(pos_ui(min), pos_ui(max));
            for stroke in strokes {
                output.painter.rect_stroke(rect, 0.0, stroke, StrokeKind::Middle);
            }
        }
    }
}
