//! Place under the pointer, marked in all linked panes, with the value there.

use super::pane_ui::{Drawn, full_scale};
use super::widgets::{PaneWidgets, PlaceValue};
use crate::app::canvas::CanvasOutput;
use crate::app::pane::{Link, PaneId, place_in};
use crate::app::panel::picture::readout_of;
use crate::app::project::Model;
use egui::{Align2, Color32, FontId, Pos2, Stroke, vec2};

/// Draws the marks over the drawn panes, and puts the values into `widgets`.
pub(super) fn marks_ui(model: &Model, widgets: &mut PaneWidgets, drawn: &[(PaneId, Drawn)]) {
    widgets.values.clear();
    let pointed = drawn.iter().find_map(|(id, drawn)| Some((*id, drawn, drawn.output.hover_image?)));
    let Some((from, first, pos_image)) = pointed else { return };
    widgets.values.extend(value_at(model, widgets, from, first.shown, pos_image));
    let is_linked = |id: PaneId| model.panes.get(id).is_some_and(|pane| pane.links.has(Link::Place));
    if !is_linked(from) {
        return;
    }
    for (id, other) in drawn.iter().filter(|(id, _)| *id != from && is_linked(*id)) {
        let Some(pos) = same_place(model, first.shown, other.shown, pos_image) else { continue };
        let value = value_at(model, widgets, *id, other.shown, pos);
        let text = value.map(|value| value.readout.short_text());
        mark(&other.output, pos, text.as_deref());
        widgets.values.extend(value);
    }
}

/// Maps the place `pos_image` of pane `from` to pane `to`.
pub(in crate::app) fn same_place(model: &Model, from: PaneId, to: PaneId, pos_image: Pos2) -> Option<Pos2> {
    let (a, b) = (model.panes.get(from)?, model.panes.get(to)?);
    let kinds = [a, b].map(|pane| pane.picture.as_ref().map(|picture| picture.request.kind));
    let used = model.usable_params_of(a.side).used_frames(model.burst_of(a.side)?.burst.len());
    Some(place_in(pos_image, (kinds[0]?, &a.cursor), (kinds[1]?, &b.cursor), &used))
}

/// Value at `pos_image` in the picture of `shown`, which pane `id` shows.
fn value_at(model: &Model, widgets: &PaneWidgets, id: PaneId, shown: PaneId, pos_image: Pos2) -> Option<PlaceValue> {
    let picture = model.panes.get(shown)?.picture.as_ref()?;
    let canvas = widgets.get(shown)?.picture.shown()?;
    let readout = readout_of(picture, canvas, pos_image, full_scale(model, shown))?;
    Some(PlaceValue { id, number: model.panes.number(id)?, readout })
}

/// Draws a cross with a gap in its middle, so that the marked place can be seen, and a text beside it.
fn mark(output: &CanvasOutput, pos_image: Pos2, text: Option<&str>) {
    let (painter, rect) = (&output.painter, output.response.rect);
    let centre = output.ui_from_image.pos(pos_image);
    if !rect.contains(centre) {
        return;
    }
    for (width, colour) in [(3.0, Color32::from_black_alpha(150)), (1.2, Color32::from_rgb(255, 214, 90))] {
        for direction in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
            painter.line_segment([centre + 3.0 * direction, centre + 10.0 * direction], Stroke::new(width, colour));
        }
    }
    let Some(text) = text else { return };
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::monospace(11.0), Color32::WHITE);
    // Beside the mark, on the side with enough space.
    let right = centre.x + 14.0 + galley.size().x < rect.right();
    let anchor = if right { Align2::LEFT_BOTTOM } else { Align2::RIGHT_BOTTOM };
    let at = centre + vec2(if right { 8.0 } else { -8.0 }, -5.0);
    let ground = anchor.anchor_size(at, galley.size() + vec2(6.0, 2.0));
    painter.rect_filled(ground, 3.0, Color32::from_black_alpha(180));
    painter.galley(ground.min + vec2(3.0, 1.0), galley, Color32::WHITE);
}
