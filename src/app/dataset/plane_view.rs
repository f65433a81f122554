//! Both trajectories in a plane: the truth as a line with rings, the estimate as a dashed line with discs, and their
//! differences between them.

use crate::app::canvas::{RectTransform, backdrop, message, navigate};
use crate::app::project::trajectories::{PlaneScene, Spot, Trajectories, round_length};
use crate::app::style;
use crate::evaluate::poses::{PairReport, Trajectory};
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

/// Maximum distance of the pointer from a camera, in points.
const REACH: f32 = 12.0;

/// Colours of truth and estimate on the theme's background.
fn colours(ui: &Ui) -> (Color32, Color32) {
    let truth = if ui.visuals().dark_mode { Color32::from_gray(225) } else { Color32::from_gray(40) };
    (truth, estimate_colour(ui))
}

/// Colour of the estimate on the theme's background.
pub fn estimate_colour(ui: &Ui) -> Color32 {
    style::warning(ui)
}

/// Draws the plane; the pointer pans, zooms, and hovers over or selects cameras.
pub fn plane_ui(ui: &mut Ui, trajectories: &mut Trajectories) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size().max(vec2(64.0, 64.0)), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Trajectories"));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, backdrop(ui));
    let scene = trajectories.scene();
    if scene.truth.is_empty() && scene.estimate.is_empty() {
        let text = trajectories.problem().unwrap_or("Open an estimated and a true trajectory to compare them");
        message(ui, &painter, rect, text);
        return;
    }
    let pixels_per_point = ui.ctx().pixels_per_point();
    trajectories.view.settle(rect, scene.size, pixels_per_point);
    let before = trajectories.view;
    navigate(ui, &response, rect, &mut trajectories.view, true);
    let ui_from_plane = trajectories.view.settle(rect, scene.size, pixels_per_point);
    let pointed = response.hover_pos().and_then(|pos| nearest(&scene, &ui_from_plane, pos));
    if response.hovered() {
        trajectories.hovered = pointed.and_then(|(_, spot)| spot.pair);
    }
    if response.clicked() {
        trajectories.selected = trajectories.hovered;
    }
    if let Some((of_truth, spot)) = pointed.filter(|_| response.double_clicked()) {
        trajectories.wanted = Some(label_of(trajectories, of_truth, spot).to_owned());
        // A double click fits the view, except on a camera.
        trajectories.view = before;
    }
    draw(ui, &painter, trajectories, &scene, &ui_from_plane);
    frame_ui(ui, &painter, trajectories, &scene, &ui_from_plane, rect);
    if let Some((of_truth, spot)) = pointed.filter(|_| !response.dragged()) {
        let text = spot_text(trajectories, of_truth, spot) + "\nDouble-click to open its burst";
        response.on_hover_text_at_pointer(text);
    }
}

/// Finds the camera nearest to `pos`, and whether it is a true one. Of equally near ones an estimated camera is chosen:
/// it lies over the true one.
fn nearest<'a>(scene: &'a PlaneScene, ui_from_plane: &RectTransform, pos: Pos2) -> Option<(bool, &'a Spot)> {
    let spots = scene.estimate.iter().map(|s| (false, s)).chain(scene.truth.iter().map(|s| (true, s)));
    let near = spots.map(|(of_truth, s)| (ui_from_plane.pos(s.pos).distance(pos), of_truth, s));
    let (_, of_truth, spot) = near.filter(|n| n.0 <= REACH).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((of_truth, spot))
}

/// Name of a camera in its own trajectory.
fn label_of<'t>(trajectories: &'t Trajectories, of_truth: bool, spot: &Spot) -> &'t str {
    let compared = &trajectories.compared;
    let read = if of_truth { &compared.truth } else { &compared.estimate };
    read.as_ref().and_then(|(_, t)| t.poses.get(spot.index)).map_or("", |p| p.label.as_str())
}

/// Describes a camera: the image's name, its errors, its points.
fn spot_text(trajectories: &Trajectories, of_truth: bool, spot: &Spot) -> String {
    if let (Some(report), Some(pair)) = (trajectories.report(), spot.pair) {
        return pair_text(trajectories, &report.pairs[pair]);
    }
    let label = label_of(trajectories, of_truth, spot);
    let why = if of_truth && trajectories.report().is_some() {
        "\nnot registered: the estimate has no camera here"
    } else {
        ""
    };
    format!("{label}{why}")
}

/// Describes a pair of cameras.
pub fn pair_text(trajectories: &Trajectories, pair: &PairReport) -> String {
    let mut text = format!("{}\noff by {:.4} and {:.3}°", pair.label, pair.translation_error, pair.rotation_error_deg);
    if let Some(points) = points_of(trajectories, pair.estimate) {
        text += &format!("\n{points} 3D points");
    }
    text
}

/// Number of 3D points that image `index` of the estimate sees; `None` if the estimate is no sparse model.
pub fn points_of(trajectories: &Trajectories, index: usize) -> Option<usize> {
    let (_, estimate): &(_, std::sync::Arc<Trajectory>) = trajectories.compared.estimate.as_ref()?;
    Some(estimate.model.as_ref()?.images.get(index)?.points)
}

fn draw(ui: &Ui, painter: &Painter, trajectories: &Trajectories, scene: &PlaneScene, ui_from_plane: &RectTransform) {
    let (true_colour, estimated_colour) = colours(ui);
    let places = |spots: &[Spot]| spots.iter().map(|s| ui_from_plane.pos(s.pos)).collect::<Vec<_>>();
    let (truth, estimate) = (places(&scene.truth), places(&scene.estimate));
    let error_colour = ui.visuals().error_fg_color;
    if let Some(report) = trajectories.report() {
        for pair in &report.pairs {
            let ends = [truth[pair.truth], estimate[pair.estimate]];
            painter.line_segment(ends, Stroke::new(1.5, error_colour));
        }
    }
    painter.line(truth.clone(), Stroke::new(1.5, true_colour));
    painter.extend(Shape::dashed_line(&estimate, Stroke::new(1.5, estimated_colour), 6.0, 4.0));
    let marked =
        |spot: &Spot| spot.pair.is_some() && (spot.pair == trajectories.hovered || spot.pair == trajectories.selected);
    for (spot, at) in scene.truth.iter().zip(&truth) {
        let missing = trajectories.report().is_some() && spot.pair.is_none();
        let colour = if missing { error_colour } else { true_colour };
        painter.circle_stroke(*at, if marked(spot) { 7.0 } else { 4.0 }, Stroke::new(1.5, colour));
    }
    for (spot, at) in scene.estimate.iter().zip(&estimate) {
        painter.circle_filled(*at, if marked(spot) { 5.0 } else { 3.0 }, estimated_colour);
    }
}

/// Draws the legend, the axes and the scale bar.
fn frame_ui(
    ui: &Ui,
    painter: &Painter,
    trajectories: &Trajectories,
    scene: &PlaneScene,
    ui_from_plane: &RectTransform,
    rect: Rect,
) {
    let (true_colour, estimated_colour) = colours(ui);
    let (font, weak) = (FontId::proportional(12.0), ui.visuals().weak_text_color());
    let mut y = rect.top() + 16.0;
    let mut entry = |text: &str, colour: Color32, kind: Entry| {
        let (from, to) = (pos2(rect.left() + 12.0, y), pos2(rect.left() + 36.0, y));
        let middle = from + 0.5 * (to - from);
        let stroke = Stroke::new(1.5, colour);
        match kind {
            Entry::Truth => {
                painter.line_segment([from, to], stroke);
                painter.circle_stroke(middle, 4.0, stroke);
            }
            Entry::Estimate => {
                painter.extend(Shape::dashed_line(&[from, to], stroke, 6.0, 4.0));
                painter.circle_filled(middle, 3.0, colour);
            }
            Entry::Missing => {
                painter.circle_stroke(middle, 4.0, stroke);
            }
        }
        painter.text(to + vec2(8.0, 0.0), Align2::LEFT_CENTER, text, font.clone(), ui.visuals().text_color());
        y += 18.0;
    };
    if !scene.truth.is_empty() {
        entry("Truth", true_colour, Entry::Truth);
    }
    if !scene.estimate.is_empty() {
        entry("Estimate, aligned", estimated_colour, Entry::Estimate);
    }
    if trajectories.report().is_some() && scene.truth.iter().any(|s| s.pair.is_none()) {
        entry("Not registered", ui.visuals().error_fg_color, Entry::Missing);
    }
    // The scale bar takes up to a quarter of the width.
    let points_per_unit = scene.scale * f64::from(ui_from_plane.scale());
    let length = round_length(0.25 * f64::from(rect.width()) / points_per_unit);
    let width = (length * points_per_unit) as f32;
    let from = rect.left_bottom() + vec2(12.0, -14.0);
    painter.line_segment([from, from + vec2(width, 0.0)], Stroke::new(2.0, ui.visuals().text_color()));
    let whose = if scene.truth.is_empty() { "estimate" } else { "truth" };
    let text = format!("{} (the {whose}'s unit)", crate::app::canvas::number(length as f32, 3));
    painter.text(from + vec2(0.0, -5.0), Align2::LEFT_BOTTOM, text, font.clone(), weak);
    let [right, up] = trajectories.projection.axis_names();
    painter.text(
        rect.right_bottom() + vec2(-10.0, -8.0),
        Align2::RIGHT_BOTTOM,
        format!("{right}: to the right,  {up}: up"),
        font,
        weak,
    );
}

#[derive(Clone, Copy)]
enum Entry {
    Truth,
    Estimate,
    Missing,
}
