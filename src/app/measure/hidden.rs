//! Outlines of the hidden parts of frames, drawn with the pointer over a picture, which become a mask's file.

use super::{Hidden, MaskShape, Measure, STROKES, Tool};
use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::canvas::CanvasOutput;
use crate::app::document::{Action, Side};
use crate::app::pane::PaneId;
use crate::app::panel::widgets::named;
use crate::app::results::Read;
use crate::burst::Burst;
use egui::{Align, Frame, Layout, Margin, Pos2, Rect, Sense, Shape, Stroke, Ui, UiBuilder, vec2};

/// Greys of a mask of `burst`, row by row: 0 where something `drawn` hides it and where all of its frames are masked,
/// otherwise 255.
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
        let before = turns;
        turns += turn;
        match (before, turns) {
            (0, _) => from = u,
            (_, 0) => parts.push([from, u]),
            _ => {}
        }
    }
    parts
}

/// Least distance between two corners of an outline, points.
const CORNER_POINTS: f32 = 4.0;
/// Distance from the first corner of a polygon, points, at which a click ends it.
const CLOSE_POINTS: f32 = 9.0;

/// Whether an outline is more than a line, and so was not drawn by mistake.
pub(super) fn hides_something(hidden: &Hidden) -> bool {
    let Hidden::Outline(outline) = hidden else { return true };
    let sides = outline.iter().zip(outline.iter().cycle().skip(1));
    let area: f32 = sides.map(|(a, b)| 0.5 * (a.x * b.y - b.x * a.y)).sum();
    let length: f32 = outline.windows(2).map(|two| two[0].distance(two[1])).sum();
    // A stroke that is meant as a line is never quite straight: less than a pixel wide on average, it is one.
    outline.len() > 2 && area.abs() > 0.4 * length
}

/// What a drag begins at the place of its press.
pub(super) fn begun(measure: &Measure, press: Pos2) -> Hidden {
    match measure.shape {
        MaskShape::Brush => Hidden::Stroke { path: vec![press], radius_px: measure.brush_px },
        _ => Hidden::Outline(vec![press]),
    }
}

/// Goes on with what a drag draws, from the place of its press to `to`; with Shift it is a rectangle.
pub(super) fn draw_to(measure: &mut Measure, from: Pos2, to: Pos2, output: &CanvasOutput) {
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
pub(super) fn add_corner(measure: &mut Measure, output: &CanvasOutput) {
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

pub(super) fn outlines_ui(model: Read<'_>, id: PaneId, output: &CanvasOutput) {
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
                let colour = super::COLOUR.gamma_multiply(0.45);
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
