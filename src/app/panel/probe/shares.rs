//! Share of each frame: the pixels along the motion, and the response of each frame alone, with its noise.

use crate::app::document::{Action, Destination, Queue};
use crate::app::panel::widgets::{WHOLE, draw_plane, named, still_plot};
use crate::app::{results::Read, style::ACCENT};
use crate::detector::coherence::{FrameResponse, Shape};
use crate::inspect::place::Shares;
use crate::inspect::words::{number, sentence, slope_text};
use crate::plane::Plane;
use crate::requests::{Probed, ViewKind};
use egui::{Color32, Label, RichText, Sense, Stroke, Ui, vec2};
use egui_plot::{HLine, Line, PlotPoints, Points};

const IN_ROW: usize = 12;
const PATCH: f32 = 18.0;

pub(super) fn shares_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, queue: &mut Queue) {
    let shares = &answer.probe.shares;
    if shares.frames.is_empty() {
        return;
    }
    let along = format!("Along slope {}, σ {} px", slope_text(shares.slope), number(shares.sigma, 1));
    ui.label(RichText::new(along).small().weak());
    strip_ui(ui, model, answer, queue);
    ui.add_space(4.0);
    plot_ui(ui, shares);
    let colour = match shares.evenness.shape {
        Shape::Level | Shape::Unclear => ui.visuals().text_color(),
        Shape::Uneven | Shape::Bump => crate::app::style::warning(ui),
    };
    ui.add(Label::new(RichText::new(sentence(&shares.meaning)).color(colour)).wrap())
        .on_hover_text("Coherence: 1 if all frames respond alike; if only some respond, about their share");
}

fn strip_ui(ui: &mut Ui, model: Read<'_>, answer: &Probed, queue: &mut Queue) {
    let shares = &answer.probe.shares;
    let fits = ((ui.available_width() / PATCH) as usize).clamp(1, IN_ROW);
    // Views lie as in their grid.
    let grid = model.burst_of(model.document.probe.side).and_then(|burst| burst.burst.positions.rows_and_columns());
    let grid = grid.filter(|(rows, columns)| rows * columns == shares.frames.len());
    let columns = grid.map_or(shares.frames.len().min(fits), |(_, columns)| columns);
    let rows = shares.frames.len().div_ceil(columns);
    let side = (ui.available_width() / columns as f32).min(44.0).floor();
    let (rect, response) = ui.allocate_exact_size(vec2(side * columns as f32, side * rows as f32), Sense::click());
    let display = model.document.ranges_of_side(model.document.probe.side).intensity;
    let values = Some(((&answer.probe).into(), WHOLE, || montage(&shares.patches, columns, rows)));
    draw_plane(ui, ("probe patches", rect), display, values);
    let frame_at = |pos: egui::Pos2| {
        let from = pos - rect.min;
        let index = (from.y / side) as usize * columns + ((from.x / side) as usize).min(columns - 1);
        shares.frames.get(index)
    };
    // Of the circle of the blob, at the feature's place.
    let radius = std::f32::consts::SQRT_2 * shares.sigma / shares.patch_px * side;
    let rim = Stroke::new(1.0, ui.visuals().panel_fill);
    for (index, frame) in shares.frames.iter().enumerate() {
        let corner = rect.min + side * vec2((index % columns) as f32, (index / columns) as f32);
        let cell = egui::Rect::from_min_size(corner, vec2(side, side));
        ui.painter().rect_stroke(cell, 0.0, rim, egui::StrokeKind::Inside);
        let colour = if frame.covers { Color32::from_rgb(255, 214, 90) } else { Color32::from_gray(120) };
        ui.painter().circle_stroke(cell.center(), radius, Stroke::new(1.0, colour));
    }
    named(&response, egui::Role::Image, "Patch of each frame");
    let Some(frame) = response.hover_pos().and_then(frame_at) else { return };
    let text = if frame.covers {
        format!("Frame {}: {:+.2e} ± {:.1e}\nClick to show it", frame.frame, frame.value, frame.sigma_d)
    } else {
        format!("Frame {} does not show the place", frame.frame)
    };
    let (slope, frame) = (Some(shares.slope), Some(frame.frame));
    let to = Destination { slope, frame, kind: Some(ViewKind::Frame), ..Destination::default() };
    let response = response.on_hover_text_at_pointer(text);
    queue.push_if(response.clicked(), Action::GoTo(model.document.probe.side, to));
}

fn montage(patches: &[Plane], columns: usize, rows: usize) -> Plane {
    let side = patches[0].width();
    Plane::from_fn(side * columns, side * rows, |x, y| {
        let index = y / side * columns + x / side;
        patches.get(index).map_or(f32::NAN, |patch| patch.at(x % side, y % side))
    })
}

/// Draws the response of each frame, with one standard deviation of its noise to each side.
fn plot_ui(ui: &mut Ui, shares: &Shares) {
    let covering = || shares.frames.iter().filter(|frame| frame.covers);
    let point = |frame: &FrameResponse| [frame.frame as f64, f64::from(frame.value)];
    let response = still_plot("shares")
        .height(96.0)
        .show_x(false)
        .show_y(false)
        .x_axis_label("frame")
        .y_grid_spacer(crate::app::ticks::of_height)
        .y_axis_formatter(|mark, _| number(mark.value as f32, 3))
        .x_axis_formatter(|mark, _| if mark.value.fract() == 0.0 { mark.value.to_string() } else { String::new() })
        .show(ui, |plot| {
            plot.hline(HLine::new("zero", 0.0).color(Color32::GRAY).width(1.0));
            let mean = HLine::new("mean", f64::from(shares.evenness.mean)).color(ACCENT);
            plot.hline(mean.style(egui_plot::LineStyle::dashed_dense()));
            for frame in covering() {
                let [x, y] = point(frame);
                let noise = f64::from(frame.sigma_d);
                let bar = PlotPoints::from(vec![[x, y - noise], [x, y + noise]]);
                plot.line(Line::new("noise", bar).color(ACCENT).width(1.2));
            }
            let points: PlotPoints<'_> = covering().map(point).collect();
            plot.points(Points::new("response", points).color(ACCENT).radius(3.0));
        })
        .response;
    named(&response, egui::Role::Image, "Response of each frame");
    let tip = "D of each frame alone, fraction of full scale, ± its noise; dashes: their mean, D of the stack";
    response.on_hover_text(tip);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_lie_row_by_row_and_what_is_over_is_empty() {
        let patch = |index: usize| Plane::from_fn(2, 2, |u, v| (10 * index + 2 * v + u) as f32);
        let picture = montage(&[0, 1, 2].map(patch), 2, 2);
        assert_eq!(picture.size(), (4, 4));
        assert_eq!((picture.at(0, 0), picture.at(3, 1), picture.at(1, 2)), (0.0, 13.0, 21.0));
        assert!(picture.at(2, 2).is_nan() && picture.at(3, 3).is_nan());
    }
}
