//! Measuring line and rectangle, for all linked panes together, and outlines of what the frames do not show.

mod hidden;
mod panels;

pub use crate::app::document::panes::{Hidden, MaskShape, Measure, MeasuredLine, MeasuredRegion, Tool};
pub use hidden::{hidden_ui, mask_of};
pub use panels::{profile_ui, region_ui};

use crate::app::canvas::{CanvasOutput, Picture};
use crate::app::document::{Action, Queue};
use crate::app::inspector::{PaneWidgets, same_place, short_description};
use crate::app::pane::{Link, PaneId};
use crate::app::results::Read;
use crate::plane::sample::{ProfileSample, profile};
use crate::plane::statistics::Region;
use crate::teach::BottomTab;
use egui::{Color32, PointerButton, Pos2, Rect, Stroke, StrokeKind};

#[derive(Debug, Clone)]
pub struct PaneRegion {
    pub id: PaneId,
    pub number: usize,
    pub name: String,
    pub picture: Picture,
    pub region: Region,
}

/// Number of a pane, and its name in a list: that number, and what the pane shows.
fn name_of(model: Read<'_>, id: PaneId) -> Option<(usize, String)> {
    let number = model.document.panes.number(id)?;
    Some((number, format!("{number}  {}", short_description(model, id, false))))
}

/// The pane drawn on; where other panes took its place, the focused pane, which shows the same burst.
fn measured_on(model: Read<'_>, drawn_on: PaneId) -> PaneId {
    let is_replaced = model.document.workspace.inspects() && !model.document.panes.shown().contains(&drawn_on);
    if is_replaced { model.document.focus() } else { drawn_on }
}

/// The pane that was drawn on and those linked with it by place, in reading order.
pub fn measured_panes(model: Read<'_>, drawn_on: PaneId) -> Vec<PaneId> {
    let (shown, drawn_on) = (model.document.panes.shown(), measured_on(model, drawn_on));
    if !shown.contains(&drawn_on) {
        return Vec::new();
    }
    let is_linked = |id: &PaneId| model.document.panes.has_link(*id, Link::Place);
    let alone = !is_linked(&drawn_on);
    shown.into_iter().filter(|id| *id == drawn_on || (!alone && is_linked(id))).collect()
}

fn mapped(model: Read<'_>, drawn_on: PaneId, to: PaneId, pos_image: Pos2) -> Option<Pos2> {
    let drawn_on = measured_on(model, drawn_on);
    if drawn_on == to { Some(pos_image) } else { same_place(model, drawn_on, to, pos_image) }
}

/// Values along the line in each pane that it is drawn in, with the pane's number and name; places in image pixels.
pub fn profiles_of(
    model: Read<'_>,
    widgets: &PaneWidgets,
    line: &MeasuredLine,
) -> Vec<(usize, String, Vec<ProfileSample>)> {
    let of = |id: PaneId| {
        let picture = widgets.get(id)?.picture.shown()?;
        // Each pane shows the line at the same place of the scene.
        let ends = [line.from_image, line.to_image].map(|pos| mapped(model, line.pane, id, pos));
        let (from, to) = (ends[0]?, ends[1]?);
        let samples = profile(&picture.plane, from.into(), to.into(), picture.image_from_picture_scale);
        let (number, name) = name_of(model, id)?;
        Some((number, name, samples))
    };
    measured_panes(model, line.pane).into_iter().filter_map(of).collect()
}

fn rect_in(model: Read<'_>, region: &MeasuredRegion, id: PaneId) -> Option<Rect> {
    let corner = |pos| mapped(model, region.pane, id, pos);
    Some(Rect::from_min_max(corner(region.rect_image.min)?, corner(region.rect_image.max)?))
}

pub fn region_in(model: Read<'_>, widgets: &PaneWidgets, region: &MeasuredRegion, id: PaneId) -> Option<PaneRegion> {
    let picture = widgets.get(id)?.picture.shown()?.clone();
    let region = picture.region(rect_in(model, region, id)?);
    let (number, name) = name_of(model, id)?;
    Some(PaneRegion { id, number, name, picture, region })
}

const COLOUR: Color32 = Color32::from_rgb(255, 214, 90);
const STROKES: [Stroke; 2] =
    [Stroke { width: 3.0, color: Color32::from_black_alpha(150) }, Stroke { width: 1.2, color: COLOUR }];

pub fn draw_ui(model: Read<'_>, id: PaneId, output: &CanvasOutput, queue: &mut Queue) {
    let response = &output.response;
    let place = |pos: Pos2| output.image_from_ui.pos(pos);
    let mut measure = model.document.measure.clone();
    if measure.tool == Tool::Pan {
        return;
    }
    if measure.tool == Tool::Mask && measure.shape == MaskShape::Polygon {
        hidden::add_corner(&mut measure, output);
        queue.edit(model.document, Action::SetMeasure(measure));
        return;
    }
    if response.drag_started_by(PointerButton::Primary)
        && let Some(pos) = response.interact_pointer_pos()
    {
        // Place of the press, not the place where the drag was recognised.
        let press = pos - response.total_drag_delta().unwrap_or_default();
        measure.drag = Some((id, place(press)));
        if measure.tool == Tool::Mask {
            measure.hidden.push(hidden::begun(&measure, place(press)));
        }
    }
    let Some((_, from)) = measure.drag.filter(|(on, _)| *on == id) else { return };
    if let Some(pos) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        let to = place(pos);
        match measure.tool {
            Tool::Line => measure.line = Some(MeasuredLine { pane: id, from_image: from, to_image: to }),
            Tool::Region => {
                measure.region = Some(MeasuredRegion { pane: id, rect_image: Rect::from_two_pos(from, to) });
            }
            Tool::Mask => hidden::draw_to(&mut measure, from, to, output),
            Tool::Pan => {}
        }
    }
    if response.drag_stopped() {
        measure.drag = None;
        match measure.tool {
            Tool::Line => queue.push(Action::OpenTab(BottomTab::Profile)),
            Tool::Region => queue.push(Action::OpenTab(BottomTab::Region)),
            Tool::Mask => measure.hidden.retain(hidden::hides_something),
            Tool::Pan => {}
        }
    }
    queue.edit(model.document, Action::SetMeasure(measure));
}

pub fn measure_ui(model: Read<'_>, id: PaneId, output: &CanvasOutput) {
    let pos_ui = |pos: Pos2| output.ui_from_image.pos(pos);
    hidden::outlines_ui(model, id, output);
    if let Some(line) = model.document.measure.line
        && measured_panes(model, line.pane).contains(&id)
        && let [Some(from), Some(to)] = [line.from_image, line.to_image].map(|pos| mapped(model, line.pane, id, pos))
    {
        STROKES.into_iter().for_each(|stroke| _ = output.painter.line_segment([pos_ui(from), pos_ui(to)], stroke));
        // A ring marks the start of the line.
        output.painter.circle_stroke(pos_ui(from), 3.5, STROKES[1]);
    }
    if let Some(region) = model.document.measure.region
        && measured_panes(model, region.pane).contains(&id)
        && let Some(rect) = rect_in(model, &region, id)
    {
        let rect = Rect::from_min_max(pos_ui(rect.min), pos_ui(rect.max));
        STROKES.into_iter().for_each(|stroke| _ = output.painter.rect_stroke(rect, 0.0, stroke, StrokeKind::Middle));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::bench::open;
    use crate::app::apply::opening;
    use crate::app::pane::Direction;
    use crate::app::results::Model;
    use crate::teach::Workspace;

    #[test]
    fn a_line_stays_when_other_panes_take_the_place_of_its_own() {
        let mut model = Model::default();
        opening::take_burst(&mut model, open((64, 48), 5));
        let first = model.document.focus();
        assert_eq!(measured_panes(Read::of(&model), first), [first]);
        let second = model.document.panes.split(first, Direction::Right).expect("there is space");
        model.document.panes.close(first);
        assert_eq!(
            (measured_panes(Read::of(&model), first), measured_on(Read::of(&model), first)),
            (vec![second], second)
        );
        // In another workspace it is not drawn.
        model.document.open_workspace(Workspace::Pair);
        assert_eq!(measured_panes(Read::of(&model), PaneId(99)), []);
    }
}
