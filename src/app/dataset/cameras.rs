//! Cameras of an estimated and a true trajectory: in a plane, as a strip of their 3D points, and as a list.

use crate::app::canvas::{RectTransform, backdrop, message, navigate};
use crate::app::document::{Action, Pointed, Queue};
use crate::app::panel::table::{Heading, Listed, rows_ui};
use crate::app::panel::widgets::instead_ui;
use crate::app::results::{PlaneScene, Read, Spot};
use crate::app::style;
use crate::evaluate::poses::{PairReport, Trajectory};
use crate::export::round_length;
use egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

/// Maximum distance of the pointer from a camera, in points.
const REACH: f32 = 12.0;

fn colours(ui: &Ui) -> (Color32, Color32) {
    let truth = if ui.visuals().dark_mode { Color32::from_gray(225) } else { Color32::from_gray(40) };
    (truth, estimate_colour(ui))
}

fn point_colour(ui: &Ui) -> Color32 {
    ui.visuals().weak_text_color()
}

pub fn estimate_colour(ui: &Ui) -> Color32 {
    style::warning(ui)
}

/// Draws the plane; the pointer pans, zooms, and hovers over or selects cameras.
pub fn plane_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size().max(vec2(64.0, 64.0)), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Trajectories"));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, backdrop(ui));
    let scene = model.results.poses.scene(model.document.trajectories.projection, model.document.trajectories.points);
    if scene.truth.is_empty() && scene.estimate.is_empty() {
        let text = model.results.poses.problem().unwrap_or("Open an estimated and a true trajectory to compare them");
        message(ui, &painter, rect, text);
        return;
    }
    let pixels_per_point = ui.ctx().pixels_per_point();
    let mut view = model.document.trajectories.view;
    view.settle(rect, scene.size, pixels_per_point);
    let before = view;
    navigate(ui, &response, rect, &mut view, true);
    let ui_from_plane = view.settle(rect, scene.size, pixels_per_point);
    let pointed = response.hover_pos().and_then(|pos| nearest(&scene, &ui_from_plane, pos));
    let pair = pointed.and_then(|(_, spot)| spot.pair);
    if response.hovered() {
        queue.point(&model.results.poses.hovered, pair, Pointed::Camera);
    }
    queue.push_if(response.clicked(), Action::SelectCamera(pair));
    if let Some((of_truth, spot)) = pointed.filter(|_| response.double_clicked()) {
        queue.push(Action::OpenCamera(label_of(model, of_truth, spot).to_owned()));
        // A double click fits the view, except on a camera.
        view = before;
    }
    // Settling alone is no action of the user: only a view that looks different is recorded.
    queue.push_if(!view.is_drawn_as(&model.document.trajectories.view), Action::MoveCameras(view));
    draw(ui, &painter, model, &scene, &ui_from_plane);
    frame_ui(ui, model, &scene, &ui_from_plane, rect);
    if let Some((of_truth, spot)) = pointed.filter(|_| !response.dragged()) {
        let text = spot_text(model, of_truth, spot) + "\nDouble-click to open its burst";
        response.on_hover_text_at_pointer(text);
    }
}

/// The camera nearest to `pos`, and whether it is true; of equally near ones the estimate, which is drawn above.
fn nearest<'a>(scene: &'a PlaneScene, ui_from_plane: &RectTransform, pos: Pos2) -> Option<(bool, &'a Spot)> {
    let spots = scene.estimate.iter().map(|s| (false, s)).chain(scene.truth.iter().map(|s| (true, s)));
    let near = spots.map(|(of_truth, s)| (ui_from_plane.pos(s.pos).distance(pos), of_truth, s));
    let (_, of_truth, spot) = near.filter(|n| n.0 <= REACH).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((of_truth, spot))
}

fn label_of<'t>(model: Read<'t>, of_truth: bool, spot: &Spot) -> &'t str {
    let compared = &model.results.poses.compared;
    let read = if of_truth { &compared.truth } else { &compared.estimate };
    read.as_ref().and_then(|(_, t)| t.poses.get(spot.index)).map_or("", |p| p.label.as_str())
}

fn spot_text(model: Read<'_>, of_truth: bool, spot: &Spot) -> String {
    if let (Some(report), Some(pair)) = (model.results.poses.report(), spot.pair) {
        return pair_text(model, &report.pairs[pair]);
    }
    let label = label_of(model, of_truth, spot);
    let is_missing = of_truth && model.results.poses.report().is_some();
    format!("{label}{}", if is_missing { "\nnot registered: the estimate has no camera here" } else { "" })
}

pub fn pair_text(model: Read<'_>, pair: &PairReport) -> String {
    let mut text = format!("{}\noff by {:.4} and {:.3}°", pair.label, pair.translation_error, pair.rotation_error_deg);
    if let Some(points) = points_of(model, pair.estimate) {
        text += &format!("\n{points} 3D points");
    }
    text
}

/// Number of 3D points that image `index` of the estimate sees; `None` if the estimate is no sparse model.
pub fn points_of(model: Read<'_>, index: usize) -> Option<usize> {
    let (_, estimate): &(_, std::sync::Arc<Trajectory>) = model.results.poses.compared.estimate.as_ref()?;
    Some(estimate.model.as_ref()?.images.get(index)?.points)
}

fn draw(ui: &Ui, painter: &Painter, model: Read<'_>, scene: &PlaneScene, ui_from_plane: &RectTransform) {
    let (true_colour, estimated_colour) = colours(ui);
    let places = |spots: &[Spot]| spots.iter().map(|s| ui_from_plane.pos(s.pos)).collect::<Vec<_>>();
    let (truth, estimate) = (places(&scene.truth), places(&scene.estimate));
    let error_colour = ui.visuals().error_fg_color;
    let mut dots = Mesh::default();
    for point in &scene.points {
        dots.add_colored_rect(Rect::from_center_size(ui_from_plane.pos(*point), vec2(2.0, 2.0)), point_colour(ui));
    }
    painter.add(dots);
    // Differences lie below the trajectories, whose marks stay whole.
    if let Some(report) = model.results.poses.report() {
        for pair in &report.pairs {
            let ends = [truth[pair.truth], estimate[pair.estimate]];
            painter.line_segment(ends, Stroke::new(1.5, error_colour));
        }
    }
    painter.line(truth.clone(), Stroke::new(1.5, true_colour));
    painter.extend(Shape::dashed_line(&estimate, Stroke::new(1.5, estimated_colour), 6.0, 4.0));
    let marked = |spot: &Spot| {
        spot.pair.is_some()
            && (spot.pair == model.results.poses.hovered || spot.pair == model.document.trajectories.selected)
    };
    for (spot, at) in scene.truth.iter().zip(&truth) {
        let missing = model.results.poses.report().is_some() && spot.pair.is_none();
        let colour = if missing { error_colour } else { true_colour };
        painter.circle_stroke(*at, if marked(spot) { 7.0 } else { 4.0 }, Stroke::new(1.5, colour));
    }
    for (spot, at) in scene.estimate.iter().zip(&estimate) {
        painter.circle_filled(*at, if marked(spot) { 5.0 } else { 3.0 }, estimated_colour);
    }
}

fn frame_ui(ui: &Ui, model: Read<'_>, scene: &PlaneScene, ui_from_plane: &RectTransform, rect: Rect) {
    let painter = ui.painter_at(rect);
    let (true_colour, estimated_colour) = colours(ui);
    let (font, weak) = (FontId::proportional(12.0), ui.visuals().weak_text_color());
    let mut y = rect.top() + 16.0;
    // Each entry goes below the one before: an absent part leaves no gap.
    let mut entry = |text: &str, colour: Color32, sign: &dyn Fn([Pos2; 2], Pos2, Stroke)| {
        let ends @ [from, to] = [pos2(rect.left() + 12.0, y), pos2(rect.left() + 36.0, y)];
        sign(ends, from + 0.5 * (to - from), Stroke::new(1.5, colour));
        painter.text(to + vec2(8.0, 0.0), Align2::LEFT_CENTER, text, font.clone(), ui.visuals().text_color());
        y += 18.0;
    };
    if !scene.truth.is_empty() {
        entry("Truth", true_colour, &|ends, middle, stroke| {
            painter.line_segment(ends, stroke);
            painter.circle_stroke(middle, 4.0, stroke);
        });
    }
    if !scene.estimate.is_empty() {
        entry("Estimate, aligned", estimated_colour, &|ends, middle, stroke| {
            painter.extend(Shape::dashed_line(&ends, stroke, 6.0, 4.0));
            painter.circle_filled(middle, 3.0, stroke.color);
        });
    }
    if model.results.poses.report().is_some() && scene.truth.iter().any(|s| s.pair.is_none()) {
        let ring = |_: [Pos2; 2], middle, stroke| _ = painter.circle_stroke(middle, 4.0, stroke);
        entry("Not registered", ui.visuals().error_fg_color, &ring);
    }
    if !scene.points.is_empty() {
        entry(&points_text(model, scene), point_colour(ui), &|_, middle, stroke| {
            painter.rect_filled(Rect::from_center_size(middle, vec2(2.5, 2.5)), 0.0, stroke.color);
        });
    }
    // The scale bar takes up to a quarter of the width.
    let points_per_unit = scene.scale * f64::from(ui_from_plane.scale());
    let longest = 0.25 * f64::from(rect.width()) / points_per_unit;
    let length = if longest.is_normal() { round_length(longest) } else { 1.0 };
    let width = (length * points_per_unit) as f32;
    let from = rect.left_bottom() + vec2(12.0, -14.0);
    painter.line_segment([from, from + vec2(width, 0.0)], Stroke::new(2.0, ui.visuals().text_color()));
    // Without a truth the world of the estimate has an arbitrary unit.
    let whose = if scene.truth.is_empty() { "estimate" } else { "truth" };
    let text = format!("{} (the {whose}'s unit)", crate::app::canvas::number(length as f32, 3));
    painter.text(from + vec2(0.0, -5.0), Align2::LEFT_BOTTOM, text, font.clone(), weak);
    let (_, [right, up], _) = model.document.trajectories.projection.about();
    let text = format!("{right}: to the right,  {up}: up");
    painter.text(rect.right_bottom() + vec2(-10.0, -8.0), Align2::RIGHT_BOTTOM, text, font, weak);
}

/// The number of points, and how many of them are drawn if not all are.
fn points_text(model: Read<'_>, scene: &PlaneScene) -> String {
    let estimate = model.results.poses.compared.estimate.as_ref();
    let all = estimate.and_then(|(_, estimate)| estimate.model.as_ref()).map_or(0, |model| model.points.len());
    match scene.points.len() {
        drawn if drawn < all => format!("3D points, {drawn} of {all} drawn"),
        drawn => format!("{drawn} 3D points"),
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Bar {
    label: String,
    /// Number of 3D points; `None` for an image that was not registered.
    points: Option<usize>,
    pair: Option<usize>,
}

/// A bar for each image: of the truth, in its order, where there is a comparison, otherwise of the estimate.
fn bars(model: Read<'_>) -> Vec<Bar> {
    let compared = &model.results.poses.compared;
    let Some((_, estimate)) = &compared.estimate else { return Vec::new() };
    if estimate.model.is_none() {
        return Vec::new();
    }
    let bar = |label: &str, points, pair| Bar { label: label.to_owned(), points, pair };
    let (Some((_, truth)), Some(report)) = (&compared.truth, model.results.poses.report()) else {
        let poses = estimate.poses.iter().enumerate();
        return poses.map(|(index, pose)| bar(&pose.label, points_of(model, index), None)).collect();
    };
    let mut bars: Vec<Bar> = truth.poses.iter().map(|pose| bar(&pose.label, None, None)).collect();
    for (index, pair) in report.pairs.iter().enumerate() {
        bars[pair.truth] = bar(&pair.label, points_of(model, pair.estimate), Some(index));
    }
    bars
}

pub fn points_strip_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let bars = bars(model);
    let (rect, response) = ui.allocate_exact_size(ui.available_size().max(vec2(40.0, 40.0)), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "3D points of each image"));
    let (painter, visuals) = (ui.painter_at(rect), ui.visuals());
    let font = FontId::proportional(11.0);
    if bars.is_empty() {
        let text = "A sparse model says how many 3D points each image sees; a trajectory file does not";
        painter.text(rect.center(), Align2::CENTER_CENTER, text, font, visuals.weak_text_color());
        return;
    }
    let most = bars.iter().filter_map(|b| b.points).max().unwrap_or(0).max(1);
    let plot = Rect::from_min_max(rect.min + vec2(44.0, 6.0), rect.max - vec2(6.0, 4.0));
    let step = plot.width() / bars.len() as f32;
    // Narrow bars touch: a gap would take most of their width.
    let gap = if step > 6.0 { 1.0 } else { 0.0 };
    let bar_at = |k: usize| {
        let at = |k: usize| plot.left() + k as f32 * step;
        Rect::from_x_y_ranges(at(k) + gap..=at(k + 1) - gap, plot.y_range())
    };
    let ends = [(most, plot.top(), Align2::RIGHT_TOP), (0, plot.bottom(), Align2::RIGHT_BOTTOM)];
    for (number, y, align) in ends {
        let text = number.to_string();
        painter.text(pos2(plot.left() - 6.0, y), align, text, font.clone(), visuals.weak_text_color());
    }
    let pointed = response.hover_pos().filter(|p| plot.contains(*p)).map(|p| ((p.x - plot.left()) / step) as usize);
    let pair = pointed.and_then(|k| bars.get(k)?.pair);
    if response.hovered() {
        queue.point(&model.results.poses.hovered, pair, Pointed::Camera);
    }
    queue.push_if(response.clicked(), Action::SelectCamera(pair));
    for (k, bar) in bars.iter().enumerate() {
        let column = bar_at(k);
        let marked = bar.pair.is_some()
            && (bar.pair == model.results.poses.hovered || bar.pair == model.document.trajectories.selected);
        // The whole column is lit, so that a low bar is found as easily as a high one.
        if marked || pointed == Some(k) {
            painter.rect_filled(column.expand(gap), 0.0, visuals.widgets.hovered.weak_bg_fill);
        }
        match bar.points {
            Some(points) => {
                let top = plot.bottom() - plot.height() * points as f32 / most as f32;
                let colour = if marked { visuals.strong_text_color() } else { estimate_colour(ui) };
                painter.rect_filled(column.with_min_y(top), 0.0, colour);
            }
            None => {
                // A low bar of another colour: an image that was not registered differs from one without points.
                painter.rect_filled(column.with_min_y(plot.bottom() - 3.0), 0.0, visuals.error_fg_color);
            }
        }
    }
    if let Some(bar) = pointed.and_then(|k| bars.get(k)) {
        let text = match (model.results.poses.report(), bar.pair, bar.points) {
            (Some(report), Some(pair), _) => pair_text(model, &report.pairs[pair]),
            (_, _, Some(points)) => format!("{}\n{points} 3D points", bar.label),
            _ => format!("{}\nnot registered", bar.label),
        };
        response.on_hover_text_at_pointer(text);
    }
}

const HEADINGS: [(&str, &str); 4] = [
    ("image", "The image's name, or the time"),
    ("error", "Distance of the camera's centre from the true one, in the truth's unit"),
    ("angle °", "Angle between the camera's directions and the true ones, degrees"),
    ("3D points", "Points of the sparse model that the image sees"),
];

pub fn camera_list_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let Some(report) = model.results.poses.report() else {
        instead_ui(ui, "Cameras that have a true one are listed here");
        return;
    };
    let items: Vec<usize> = (0..report.pairs.len()).collect();
    let listed =
        Listed { items: &items, selected: model.document.trajectories.selected, hovered: model.results.poses.hovered };
    let heading = |(text, help)| {
        let is_left = text == HEADINGS[0].0;
        let width = if is_left { 120.0 } else { 84.0 };
        Heading { text, help, width, is_exact: !is_left, is_left, ..Heading::default() }
    };
    let text = |column: usize, index: usize| {
        let pair = &report.pairs[index];
        match column {
            0 => pair.label.clone(),
            1 => format!("{:.4}", pair.translation_error),
            2 => format!("{:.3}", pair.rotation_error_deg),
            _ => points_of(model, pair.estimate).map_or("–".to_owned(), |n| n.to_string()),
        }
    };
    let name = |index: usize| format!("Camera {}", report.pairs[index].label);
    rows_ui(ui, &HEADINGS.map(heading), None, &listed, text, name, |row, index| {
        if row.hovered() {
            queue.point(&model.results.poses.hovered, Some(index), Pointed::Camera);
        }
        queue.push_if(row.clicked(), Action::SelectCamera(Some(index)));
        if row.double_clicked() {
            queue.push(Action::OpenCamera(report.pairs[index].label.clone()));
        }
    });
}
