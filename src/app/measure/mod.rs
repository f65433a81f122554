//! Measuring line and rectangle, for all linked panes together, and outlines of what the frames do not show.

mod panels;

pub use crate::app::document::panes::{Hidden, MaskShape, Measure, MeasuredLine, MeasuredRegion, Tool};
pub use panels::{profile_ui, region_ui};

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::canvas::{CanvasOutput, Picture};
use crate::app::document::{Action, Side};
use crate::app::inspector::{PaneWidgets, same_place, short_description};
use crate::app::pane::{Link, PaneId};
use crate::app::{panel::widgets::named, results::Read};
use crate::burst::Burst;
use crate::plane::sample::{ProfileSample, profile};
use crate::plane::statistics::Region;
use crate::teach::BottomTab;
use egui::{Align, Color32, Frame, Layout, Margin, Pos2, Rect, Sense, Shape, Stroke, StrokeKind, Ui, UiBuilder, vec2};

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
    shown.into_iter().filter(|id| *id == drawn_on || (is_linked(&drawn_on) && is_linked(id))).collect()
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
        let picture = widgets.get(id)?.picture.shown.as_ref()?;
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
    let picture = widgets.get(id)?.picture.shown.clone()?;
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
        add_corner(&mut measure, output);
        return queue.edit(model.document, Action::SetMeasure(measure));
    }
    if response.drag_started_by(egui::PointerButton::Primary)
        && let Some(pos) = response.interact_pointer_pos()
    {
        // Place of the press, not the place where the drag was recognised.
        let press = pos - response.total_drag_delta().unwrap_or_default();
        measure.drag = Some((id, place(press)));
        if measure.tool == Tool::Mask {
            measure.hidden.push(match measure.shape {
                MaskShape::Brush => Hidden::Stroke { path: vec![place(press)], radius_px: measure.brush_px },
                _ => Hidden::Outline(vec![place(press)]),
            });
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
            Tool::Mask => draw_to(&mut measure, from, to, output),
            Tool::Pan => {}
        }
    }
    if response.drag_stopped() {
        measure.drag = None;
        match measure.tool {
            Tool::Line => queue.push(Action::OpenTab(BottomTab::Profile)),
            Tool::Region => queue.push(Action::OpenTab(BottomTab::Region)),
            Tool::Mask => measure.hidden.retain(hides_something),
            Tool::Pan => {}
        }
    }
    queue.edit(model.document, Action::SetMeasure(measure));
}

pub fn measure_ui(model: Read<'_>, id: PaneId, output: &CanvasOutput) {
    let pos_ui = |pos: Pos2| output.ui_from_image.pos(pos);
    outlines_ui(model, id, output);
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

/// Greys of a mask of `burst`, row by row: 0 where something `drawn` hides it or all frames are masked, otherwise 255.
pub fn mask_of(burst: &Burst, drawn: &[Hidden]) -> Vec<u8> {
    let (width, height) = burst.size();
    let hides = |u: usize, v: usize| burst.frames.iter().all(|frame| frame.is_hidden_at(u, v));
    let are_masked = burst.frames.iter().all(|frame| frame.mask().is_some());
    let grey = |k: usize| if are_masked && hides(k % width, k / width) { 0 } else { 255 };
    let mut greys: Vec<u8> = (0..width * height).map(grey).collect();
    for hidden in drawn {
        for (v, row) in greys.chunks_mut(width).enumerate() {
            for [from, to] in hidden_in(hidden, v as f32) {
                // Pixels whose centres lie between the two ends.
                let [from, to] = [from.ceil(), to.floor() + 1.0].map(|u| (u.max(0.0) as usize).min(width));
                row[from..to.max(from)].fill(0);
            }
        }
    }
    greys
}

fn hidden_in(hidden: &Hidden, v: f32) -> Vec<[f32; 2]> {
    match hidden {
        Hidden::Outline(outline) => inside(outline, v),
        // The discs along the path lie so densely that their union is smooth to a hundredth of a pixel or so.
        Hidden::Stroke { path, radius_px } => {
            let ends = path.iter().zip(path.iter().skip(1).chain(path.last()));
            let discs = ends.flat_map(|(from, to)| {
                let count = (from.distance(*to) / (0.25 * radius_px).max(0.25)).ceil().max(1.0);
                (0..=count as usize).map(move |i| from.lerp(*to, i as f32 / count))
            });
            let row = |disc: Pos2| {
                let half = (radius_px * radius_px - (disc.y - v).powi(2)).sqrt();
                (!half.is_nan()).then_some([disc.x - half, disc.x + half])
            };
            discs.filter_map(row).collect()
        }
    }
}

/// Parts of row `v` around which a closed outline winds: also what it goes around twice.
fn inside(outline: &[Pos2], v: f32) -> Vec<[f32; 2]> {
    let next = outline.iter().cycle().skip(1);
    let crossing = |(a, b): (&Pos2, &Pos2)| {
        // Half-open, so that a corner that lies on the row counts once.
        let crosses = (a.y <= v) != (b.y <= v);
        crosses.then(|| (a.x + (v - a.y) / (b.y - a.y) * (b.x - a.x), if a.y <= v { 1 } else { -1 }))
    };
    let mut crossings: Vec<(f32, i32)> = outline.iter().zip(next).filter_map(crossing).collect();
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut parts, mut turns, mut from) = (Vec::new(), 0, 0.0);
    for (u, turn) in crossings {
        match (turns, turns + turn) {
            (0, _) => from = u,
            (_, 0) => parts.push([from, u]),
            _ => {}
        }
        turns += turn;
    }
    parts
}

/// Least distance between two corners of an outline, points.
const CORNER_POINTS: f32 = 4.0;
/// Distance from the first corner of a polygon, points, at which a click ends it.
const CLOSE_POINTS: f32 = 9.0;

/// Whether an outline is more than a line, and so was not drawn by mistake.
fn hides_something(hidden: &Hidden) -> bool {
    let Hidden::Outline(outline) = hidden else { return true };
    let sides = outline.iter().zip(outline.iter().cycle().skip(1));
    let area: f32 = sides.map(|(a, b)| 0.5 * (a.x * b.y - b.x * a.y)).sum();
    let length: f32 = outline.windows(2).map(|two| two[0].distance(two[1])).sum();
    // A stroke that is meant as a line is never quite straight: less than a pixel wide on average, it is one.
    outline.len() > 2 && area.abs() > 0.4 * length
}

/// Goes on with what a drag draws, from the place of its press to `to`; with Shift it is a rectangle.
fn draw_to(measure: &mut Measure, from: Pos2, to: Pos2, output: &CanvasOutput) {
    let is_rectangle = measure.shape == MaskShape::Rectangle || output.response.ctx.input(|i| i.modifiers.shift);
    let Some(hidden) = measure.hidden.last_mut() else { return };
    if let Hidden::Outline(outline) = hidden
        && is_rectangle
    {
        let rect = Rect::from_two_pos(from, to);
        *outline = vec![rect.left_top(), rect.right_top(), rect.right_bottom(), rect.left_bottom()];
        return;
    }
    let points = hidden.points_mut();
    let ui = |pos: Pos2| output.ui_from_image.pos(pos);
    if points.last().is_none_or(|last| ui(*last).distance(ui(to)) >= CORNER_POINTS) {
        points.push(to);
    }
}

/// Adds a corner to the polygon that is being drawn, or begins or ends it, where the pointer clicked.
fn add_corner(measure: &mut Measure, output: &CanvasOutput) {
    let response = &output.response;
    let Some(pos) = response.interact_pointer_pos().filter(|_| response.clicked()) else { return };
    let (at, is_open) = (output.image_from_ui.pos(pos), measure.is_open);
    match measure.hidden.last_mut().map(Hidden::points_mut).filter(|_| is_open) {
        None => {
            measure.hidden.push(Hidden::Outline(vec![at]));
            measure.is_open = true;
        }
        Some(corners) => {
            let is_first = output.ui_from_image.pos(corners[0]).distance(pos) <= CLOSE_POINTS;
            if !is_first && !response.double_clicked() {
                corners.push(at);
            } else {
                measure.is_open = false;
                measure.hidden.retain(hides_something);
            }
        }
    }
}

fn outlines_ui(model: Read<'_>, id: PaneId, output: &CanvasOutput) {
    if !model.document.panes.is_on(id, Side::A) {
        return;
    }
    let ui = |points: &[Pos2]| points.iter().map(|pos| output.ui_from_image.pos(*pos)).collect::<Vec<Pos2>>();
    for hidden in &model.document.measure.hidden {
        match hidden {
            Hidden::Outline(outline) => {
                STROKES.into_iter().for_each(|stroke| _ = output.painter.add(Shape::closed_line(ui(outline), stroke)));
            }
            Hidden::Stroke { path, radius_px } => {
                let colour = COLOUR.gamma_multiply(0.45);
                let radius = radius_px * output.ui_from_image.scale();
                let path = ui(path);
                for end in path.first().into_iter().chain(path.last()) {
                    output.painter.circle_filled(*end, radius, colour);
                }
                output.painter.add(Shape::line(path, Stroke::new(2.0 * radius, colour)));
            }
        }
    }
}

/// Says over the picture in `rect` how to draw, while the tool is chosen, and offers the mask.
pub fn hidden_ui(ui: &mut Ui, model: Read<'_>, rect: Rect, queue: &mut Queue) {
    if model.document.measure.tool != Tool::Mask {
        return;
    }
    let room = Rect::from_min_max(rect.left_top() + vec2(10.0, 10.0), rect.right_top() + vec2(-10.0, 44.0));
    // A press on a button must not begin an outline on the picture below.
    let builder = UiBuilder::new().max_rect(room).layout(Layout::left_to_right(Align::Min)).sense(Sense::drag());
    ui.scope_builder(builder, |ui| {
        Frame::popup(ui.style()).inner_margin(Margin::symmetric(8, 4)).show(ui, |ui| {
            ui.set_max_width(room.width() - 20.0);
            ui.horizontal_wrapped(|ui| {
                ui.label("Hide");
                let mut measure = model.document.measure.clone();
                for shape in MaskShape::ALL {
                    let [name, help] = shape.words();
                    ui.selectable_value(&mut measure.shape, shape, name).on_hover_text(help);
                }
                if measure.shape == MaskShape::Brush {
                    let radius = egui::DragValue::new(&mut measure.brush_px).range(1.0..=200.0).suffix(" px");
                    named(&ui.add(radius), egui::Role::SpinButton, "Radius of the brush");
                }
                measure.is_open &= measure.shape == MaskShape::Polygon;
                button_ui(ui, model, queue, ActionId::UseMask, Some("Use as mask…"));
                let back = ui.add_enabled(!measure.hidden.is_empty(), egui::Button::new("Take back"));
                if back.on_hover_text("Remove what was drawn last").clicked() {
                    measure.take_back();
                }
                queue.edit(model.document, Action::SetMeasure(measure));
                button_ui(ui, model, queue, ActionId::ClearMeasure, Some("Close"));
            });
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::pane::Direction;

    #[test]
    fn a_line_stays_when_other_panes_take_the_place_of_its_own() {
        let mut model = crate::app::results::Model::default();
        crate::app::apply::opening::take_burst(&mut model, crate::app::apply::bench::open((64, 48), 5));
        let first = model.document.focus();
        assert_eq!(measured_panes(Read::of(&model), first), [first]);
        let second = model.document.panes.split(first, Direction::Right).expect("there is space");
        model.document.panes.close(first);
        assert_eq!(measured_panes(Read::of(&model), first), [second]);
        assert_eq!(measured_on(Read::of(&model), first), second);
        // In another workspace it is not drawn.
        model.document.open_workspace(crate::teach::Workspace::Pair);
        assert_eq!(measured_panes(Read::of(&model), PaneId(99)), []);
    }
}
