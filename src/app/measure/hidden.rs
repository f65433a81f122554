//! Outlines of the hidden parts of frames, drawn with the pointer over a picture, which become a mask's file.

use super::{Tool, strokes};
use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::canvas::CanvasOutput;
use crate::app::document::Action;
use crate::app::document::side::Side;
use crate::app::pane::PaneId;
use crate::app::results::Read;
use crate::burst::Burst;
use egui::{Align, Frame, Layout, Margin, Pos2, Rect, Sense, Shape, Ui, UiBuilder, vec2};

/// Greys of a mask of `burst`, row by row: 0 inside an `outline` and where all of its frames are masked, otherwise 255.
pub fn mask_of(burst: &Burst, outlines: &[Vec<Pos2>]) -> Vec<u8> {
    let (width, height) = burst.size();
    let hides = |u: usize, v: usize| burst.frames.iter().all(|frame| frame.is_hidden_at(u, v));
    let are_masked = burst.frames.iter().all(|frame| frame.mask().is_some());
    let grey = |k: usize| if are_masked && hides(k % width, k / width) { 0 } else { 255 };
    let mut greys: Vec<u8> = (0..width * height).map(grey).collect();
    for outline in outlines {
        for (v, row) in greys.chunks_mut(width).enumerate() {
            for [from, to] in inside(outline, v as f32) {
                // Pixels whose centres lie between the two crossings.
                let [from, to] = [from, to].map(|u| (u.ceil().max(0.0) as usize).min(width));
                row[from..to].fill(0);
            }
        }
    }
    greys
}

fn inside(outline: &[Pos2], v: f32) -> Vec<[f32; 2]> {
    let next = outline.iter().cycle().skip(1);
    let crossing = |(a, b): (&Pos2, &Pos2)| {
        // Half-open, so that a corner that lies on the row counts once.
        let crosses = (a.y <= v) != (b.y <= v);
        crosses.then(|| a.x + (v - a.y) / (b.y - a.y) * (b.x - a.x))
    };
    let mut crossings: Vec<f32> = outline.iter().zip(next).filter_map(crossing).collect();
    crossings.sort_by(f32::total_cmp);
    crossings.chunks_exact(2).map(|two| [two[0], two[1]]).collect()
}

pub(super) fn outlines_ui(model: Read<'_>, id: PaneId, output: &CanvasOutput) {
    if model.document.panes.get(id).is_none_or(|pane| pane.side != Side::A) {
        return;
    }
    for outline in &model.document.measure.hidden {
        let points: Vec<Pos2> = outline.iter().map(|pos| output.ui_from_image.pos(*pos)).collect();
        for stroke in strokes() {
            output.painter.add(Shape::closed_line(points.clone(), stroke));
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
                ui.label("Drag around what is not to be seen");
                button_ui(ui, model, queue, ActionId::UseMask, Some("Use as mask…"));
                let mut measure = model.document.measure.clone();
                let back = egui::Button::new("Take back");
                if ui.add_enabled(!measure.hidden.is_empty(), back).on_hover_text("Remove the last outline").clicked() {
                    measure.hidden.pop();
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
    use crate::plane::{Mask, Plane};
    use egui::pos2;
    use std::sync::Arc;

    #[test]
    fn a_mask_hides_what_lies_inside_of_outlines_and_what_no_frame_shows() {
        let plain = Plane::zeros(12, 8);
        let burst = Burst::from_planes("plain", vec![plain.clone(); 2]);
        let square = vec![pos2(1.5, 1.5), pos2(4.5, 1.5), pos2(4.5, 3.5), pos2(1.5, 3.5)];
        let greys = mask_of(&burst, std::slice::from_ref(&square));
        let hidden: Vec<usize> = (0..96).filter(|k| greys[*k] == 0).collect();
        assert_eq!(hidden, [26, 27, 28, 38, 39, 40]);
        // A rectangle beyond the picture's rim, and an empty rectangle.
        let beyond = vec![pos2(-9.0, -9.0), pos2(99.0, -9.0), pos2(99.0, 99.0), pos2(-9.0, 99.0)];
        assert!(mask_of(&burst, &[beyond]).iter().all(|grey| *grey == 0));
        assert!(mask_of(&burst, &[vec![pos2(3.0, 3.0)], Vec::new()]).iter().all(|grey| *grey == 255));
        let mask = |column: usize| Mask::new(Plane::from_fn(12, 8, |u, _| f32::from(u != 0 && u != column)));
        let masked = [5, 6].map(|column| Arc::new(plain.clone().masked(mask(column)))).to_vec();
        let greys = mask_of(&Burst { frames: masked, ..burst }, &[]);
        assert!((0..96).all(|k| (greys[k] == 0) == (k % 12 == 0)), "what one frame shows is seen");
    }
}
