//! Comparison over a picture: drawing, hovering, selection, and the legend.

use super::colour;
use crate::app::canvas::CanvasOutput;
use crate::app::canvas::overlay::{ComparedMark, draw_compared, mark_at};
use crate::app::panel::features::frames_from_middle;
use crate::app::project::Model;
use crate::app::project::against::{Kind, Row, Shown};
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use crate::requests::Picture;
use egui::{Frame, Margin, RichText, Sense, Ui, UiBuilder, pos2, vec2};

/// Marks of the drawn rows, with the rows' indices; in a frame, at the frame's time.
fn marks_of(model: &Model, side: Side, shown: &Shown, picture: Option<&Picture>) -> (Vec<usize>, Vec<ComparedMark>) {
    let dt = frames_from_middle(picture, &shown.detection).unwrap_or(0.0);
    let drawn = shown.rows.iter().enumerate().filter(|(_, row)| model.slots[side].against.shows(row.kind));
    drawn
        .map(|(index, row)| {
            let slope = row.slope.unwrap_or_default();
            let at = |pos: [f32; 2]| pos2(pos[0] + dt * slope.u, pos[1] + dt * slope.v);
            let mark = ComparedMark {
                pos_image: at(row.pos_image),
                sigma: row.sigma,
                from_image: row.from_image.map(at),
                colour: colour(shown.with, row.kind),
                dashed: row.kind == Kind::Theirs,
            };
            (index, mark)
        })
        .unzip()
}

/// Draws the comparison of `side` over the canvas of `output`, and lets the pointer choose among its rows.
pub fn marks_ui(
    ui: &Ui,
    model: &mut Model,
    side: Side,
    shown: &Shown,
    picture: Option<&Picture>,
    output: &CanvasOutput,
) {
    let (rows, marks) = marks_of(model, side, shown, picture);
    let clip = output.painter.clip_rect();
    // Candidates and matches lie on top.
    let is_over_match = model.workspace == Workspace::Pair && model.pair.hovered.is_some();
    let on_top = model.explained.pointed.is_none() && !is_over_match;
    let pointer = output.pointer_ui.filter(|pos| on_top && clip.contains(*pos));
    let pointed = pointer.and_then(|pos| mark_at(output, &marks, pos));
    if pointer.is_some() {
        model.slots[side].against.hovered = pointed.map(|mark| rows[mark]);
        // Features under the marks are not hovered.
        model.hovered = None;
    }
    // A feature selected or hovered elsewhere is one of ours.
    let of_ours = |feature: usize| rows.iter().position(|row| shown.rows[*row].feature == Some(feature));
    let focus = model.slots[side].against.hovered.or(model.slots[side].against.selected);
    let highlighted = focus.and_then(|row| rows.iter().position(|r| *r == row));
    let elsewhere = model.hovered.or(model.selected).filter(|_| side == Side::A);
    let highlighted = highlighted.or_else(|| elsewhere.and_then(of_ours));
    draw_compared(output, &marks, highlighted);
    if on_top
        && output.response.clicked()
        && output.response.interact_pointer_pos().is_none_or(|pos| clip.contains(pos))
    {
        select(model, side, shown, pointed.map(|mark| rows[mark]));
    }
    if let Some(mark) = pointed.filter(|_| !output.response.dragged()) {
        tip_ui(ui, shown, &shown.rows[rows[mark]]);
    }
}

/// Selects a row, and our feature in it if it is one of A's.
pub(super) fn select(model: &mut Model, side: Side, shown: &Shown, row: Option<usize>) {
    model.slots[side].against.selected = row;
    if side == Side::A {
        model.selected = row.and_then(|row| shown.rows.get(row)?.feature);
    }
}

fn tip_ui(ui: &Ui, shown: &Shown, row: &Row) {
    let slope = row.slope.map_or_else(String::new, |s| format!("  slope ({:+.2}, {:+.2}) px/frame", s.u, s.v));
    let note = if row.note.is_empty() { String::new() } else { format!("\n{}", row.note) };
    let text = format!("{}  σ {:.2} px{slope}{note}", shown.label(row.kind), row.sigma);
    let (id, anchor) = (egui::Id::unique("compared tip"), egui::PopupAnchor::Pointer);
    egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), id, anchor).gap(14.0).show(|ui| {
        ui.set_max_width(420.0);
        ui.label(text)
    });
}

/// Draws the legend in the lower left corner of the picture.
pub fn legend_ui(ui: &mut Ui, model: &Model, side: Side, shown: &Shown, output: &CanvasOutput) {
    let rect = output.response.rect;
    let fill = if ui.visuals().dark_mode {
        egui::Color32::from_black_alpha(190)
    } else {
        egui::Color32::from_white_alpha(225)
    };
    let kinds: Vec<Kind> =
        Kind::of(shown.with).iter().copied().filter(|kind| model.slots[side].against.shows(*kind)).collect();
    let height = 16.0 + 18.0 * kinds.len() as f32;
    let corner = rect.left_bottom() + vec2(10.0, -10.0);
    let room = egui::Rect::from_min_max(corner - vec2(0.0, height), corner + vec2(210.0, 0.0));
    ui.scope_builder(UiBuilder::new().max_rect(room), |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        Frame::new().fill(fill).corner_radius(5).inner_margin(Margin::symmetric(8, 6)).show(ui, |ui| {
            for kind in kinds {
                ui.horizontal(|ui| {
                    key_ui(ui, shown, kind);
                    ui.label(RichText::new(format!("{} {}", shown.label(kind), shown.count(kind))).small());
                });
            }
        });
    });
}

/// Draws a small circle in the style of the picture's.
pub(super) fn key_ui(ui: &mut Ui, shown: &Shown, kind: Kind) {
    let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
    // Dark as the pictures, so that the colours can be told apart in the light theme too.
    ui.painter().rect_filled(rect, 3.0, egui::Color32::from_gray(40));
    let stroke = egui::Stroke::new(1.6, colour(shown.with, kind));
    if kind == Kind::Theirs {
        let points: Vec<egui::Pos2> = (0..=24)
            .map(|k| rect.center() + 4.5 * egui::Vec2::angled(std::f32::consts::TAU * k as f32 / 24.0))
            .collect();
        ui.painter().extend(egui::Shape::dashed_line(&points, stroke, 3.0, 2.0));
    } else {
        ui.painter().circle_stroke(rect.center(), 4.5, stroke);
    }
}
