//! Cameras of estimated trajectories and the true one: in a plane, as a strip of their 3D points, and as a list.

use crate::app::canvas::{RectTransform, backdrop, message, navigate};
use crate::app::document::{Action, Pointed, Queue};
use crate::app::panel::table::{Heading, Listed, rows_ui, texts};
use crate::app::panel::widgets::{instead_ui, named};
use crate::app::results::studies::ORBIT_BEGINS;
use crate::app::results::{PlaneScene, Read, Spot};
use crate::app::{style, view::nearest};
use crate::evaluate::poses::sparse::SparseImage;
use crate::evaluate::poses::{PairReport, PoseReport, Projection};
use crate::export::round_length;
use crate::requests::Which;
use egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};

/// Maximum distance of the pointer from a camera, in points.
const REACH: f32 = 12.0;

/// Turn of a free view for each point of a drag.
const DEGREES_PER_POINT: f32 = 0.4;

pub fn colour(ui: &Ui, which: Which) -> Color32 {
    match which {
        Which::Estimate => style::warning(ui),
        Which::Second => ui.visuals().hyperlink_color,
        Which::Truth if ui.visuals().dark_mode => Color32::from_gray(225),
        Which::Truth => Color32::from_gray(40),
    }
}

pub fn name(which: Which) -> &'static str {
    match which {
        Which::Estimate => "Estimate",
        Which::Second => "Second estimate",
        Which::Truth => "Truth",
    }
}

fn is_marked(model: Read<'_>, camera: Option<usize>) -> bool {
    camera.is_some() && (camera == model.results.poses.hovered || camera == model.document.trajectories.selected)
}

/// Draws the plane; the pointer pans (a free view it turns), zooms, and hovers over or selects cameras.
pub fn plane_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size().max(vec2(64.0, 64.0)), Sense::click_and_drag());
    named(&response, egui::Role::Canvas, "Trajectories");
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, backdrop(ui));
    let scene = model.results.poses.scene(&model.document.trajectories);
    if scene.cameras.iter().all(Vec::is_empty) {
        let none = "Open an estimated and a true trajectory to compare them";
        let text = model.results.poses.problems().next().map_or(none, |(_, problem)| problem);
        return message(ui, &painter, rect, text);
    }
    let pixels_per_point = ui.ctx().pixels_per_point();
    let mut view = model.document.trajectories.view;
    view.settle(rect, scene.size, pixels_per_point);
    let before = view;
    let is_free = model.document.trajectories.projection == Projection::Free;
    navigate(ui, &response, rect, &mut view, !is_free);
    let ui_from_plane = view.settle(rect, scene.size, pixels_per_point);
    let pointed = response.hover_pos().and_then(|pos| camera_at(&scene, &ui_from_plane, pos));
    let camera = pointed.and_then(|(_, spot)| spot.camera);
    if response.hovered() {
        queue.point(&model.results.poses.hovered, camera, Pointed::Camera);
    }
    // A camera comes before the points around it.
    let point = response.hover_pos().filter(|_| pointed.is_none()).and_then(|pos| {
        nearest(scene.points.iter().map(|(point, at)| (ui_from_plane.pos(*at).distance(pos), *point)), 0.5 * REACH)
    });
    queue.push_if(response.clicked(), point.map_or(Action::SelectCamera(camera), Action::SelectPoint));
    if let Some((which, spot)) = pointed.filter(|_| response.double_clicked()) {
        queue.push(Action::OpenCamera(label_of(model, which, spot.index).to_owned()));
        // A double click fits the view, except on a camera.
        view = before;
    } else if is_free && response.double_clicked() {
        queue.edit(model.document, Action::Orbit([0.0; 2]));
    } else if is_free && response.dragged_by(egui::PointerButton::Primary) {
        let ([around, above], by) = (model.document.trajectories.orbit, DEGREES_PER_POINT * response.drag_delta());
        // Up stays up: the view goes no farther than to straight above or below.
        let above = (above + by.y + ORBIT_BEGINS[1]).clamp(-90.0, 90.0) - ORBIT_BEGINS[1];
        queue.edit(model.document, Action::Orbit([(around - by.x) % 360.0, above]));
    }
    // Settling alone is no action of the user: only a view that looks different is recorded.
    queue.push_if(!view.is_drawn_as(&model.document.trajectories.view), Action::MoveCameras(view));
    draw(ui, &painter, model, &scene, &ui_from_plane);
    frame_ui(ui, model, &scene, &ui_from_plane, rect);
    if let Some((which, spot)) = pointed.filter(|_| !response.dragged()) {
        let label = || label_of(model, which, spot.index).to_owned();
        let text = spot.camera.map_or_else(label, |camera| camera_text(model, camera));
        response.on_hover_text_at_pointer(text + "\nDouble-click to open its burst");
    } else if let Some(point) = point.and_then(|point| model.results.poses.model()?.points.get(point)) {
        response
            .on_hover_text_at_pointer(format!("3D point, seen {} times\nClick for its features", point.track.len()));
    }
}

/// The camera nearest to `pos`, and whose it is; of equally near ones an estimate's, which are drawn above.
fn camera_at<'a>(scene: &'a PlaneScene, ui_from_plane: &RectTransform, pos: Pos2) -> Option<(Which, &'a Spot)> {
    let spots = Which::ALL.into_iter().flat_map(|which| scene.cameras[which as usize].iter().map(move |s| (which, s)));
    nearest(spots.map(|(which, s)| (ui_from_plane.pos(s.pos).distance(pos), (which, s))), REACH)
}

fn label_of(model: Read<'_>, which: Which, index: usize) -> &str {
    model.results.poses.read(which).and_then(|read| read.poses.get(index)).map_or("", |pose| &pose.label)
}

pub fn camera_text(model: Read<'_>, camera: usize) -> String {
    let poses = &model.results.poses;
    let mut text = camera_label(model, camera).to_owned();
    for (which, _) in poses.reports() {
        let whose = if poses.reports().count() > 1 { format!("{}: ", name(which)) } else { String::new() };
        text += &match poses.pair(which, camera) {
            Some(PairReport { translation_error, rotation_error_deg, estimate, .. }) => {
                let points = points_of(model, which, *estimate).map(|points| format!("\n{whose}{points} 3D points"));
                let off = format!("\n{whose}off by {translation_error:.4} and {rotation_error_deg:.3}°");
                off + &points.unwrap_or_default()
            }
            None => format!("\n{whose}not registered: the estimate has no camera here"),
        };
    }
    text
}

/// Name of a true camera's image where an estimate has it, which may be a time in the truth.
pub fn camera_label(model: Read<'_>, camera: usize) -> &str {
    let pair = Which::ESTIMATES.into_iter().find_map(|which| model.results.poses.pair(which, camera));
    pair.map_or_else(|| label_of(model, Which::Truth, camera), |pair| &pair.label)
}

/// Number of 3D points that image `index` of an estimate sees; `None` if it is no sparse model.
pub fn points_of(model: Read<'_>, which: Which, index: usize) -> Option<usize> {
    Some(model.results.poses.read(which)?.model.as_ref()?.images.get(index)?.points)
}

fn sign(painter: &Painter, which: Which, at: Pos2, radius: f32, colour: Color32) {
    match which {
        Which::Estimate => painter.circle_filled(at, radius, colour),
        Which::Second => painter.rect_filled(Rect::from_center_size(at, Vec2::splat(1.8 * radius)), 0.0, colour),
        Which::Truth => painter.circle_stroke(at, 1.5 * radius - 0.5, Stroke::new(1.5, colour)),
    };
}

fn line(painter: &Painter, which: Which, along: &[Pos2], colour: Color32) {
    let stroke = Stroke::new(1.5, colour);
    match which {
        Which::Estimate => painter.extend(Shape::dashed_line(along, stroke, 6.0, 4.0)),
        Which::Second => painter.extend(Shape::dashed_line(along, stroke, 2.0, 3.0)),
        Which::Truth => _ = painter.line(along.to_vec(), stroke),
    }
}

fn draw(ui: &Ui, painter: &Painter, model: Read<'_>, scene: &PlaneScene, ui_from_plane: &RectTransform) {
    let place = |spot: &Spot| ui_from_plane.pos(spot.pos);
    let places = scene.cameras.each_ref().map(|spots| spots.iter().map(place).collect::<Vec<_>>());
    let error_colour = ui.visuals().error_fg_color;
    let is_free = model.document.trajectories.projection == Projection::Free;
    let mut dots = Mesh::default();
    let selected = model.document.trajectories.point;
    for (point, at) in &scene.points {
        let at = ui_from_plane.pos(*at);
        if let Some((sparse, _)) = model.results.poses.model().zip(selected.filter(|selected| selected == point)) {
            for (image, _) in sparse.points.get(*point).into_iter().flat_map(|point| sparse.seen_by(point)) {
                painter.line_segment([at, places[0][image]], Stroke::new(1.0, ui.visuals().strong_text_color()));
            }
            painter.circle_filled(at, 4.0, ui.visuals().strong_text_color());
        }
        dots.add_colored_rect(Rect::from_center_size(at, vec2(2.0, 2.0)), ui.visuals().weak_text_color());
    }
    painter.add(dots);
    // Differences lie below the trajectories, whose marks stay whole.
    for (which, report) in model.results.poses.reports() {
        for pair in &report.pairs {
            let ends = [places[Which::Truth as usize][pair.truth], places[which as usize][pair.estimate]];
            painter.line_segment(ends, Stroke::new(1.5, error_colour));
        }
    }
    for which in [Which::Truth, Which::Second, Which::Estimate] {
        line(painter, which, &places[which as usize], colour(ui, which));
        for (spot, at) in scene.cameras[which as usize].iter().zip(&places[which as usize]) {
            let is_missing = which == Which::Truth && is_missing(model, spot.index);
            let colour = if is_missing { error_colour } else { colour(ui, which) };
            for k in (0..4).filter(|_| is_free) {
                let corner = |k: usize| ui_from_plane.pos(spot.frustum[k % 4]);
                painter.line(vec![*at, corner(k), corner(k + 1)], Stroke::new(1.0, colour));
            }
            sign(painter, which, *at, if is_marked(model, spot.camera) { 5.0 } else { 3.0 }, colour);
        }
    }
}

/// Whether no estimate that is compared has the true camera.
pub fn is_missing(model: Read<'_>, camera: usize) -> bool {
    model.results.poses.compared.pairs.get(camera).is_some_and(|pairs| pairs.iter().all(Option::is_none))
}

fn frame_ui(ui: &Ui, model: Read<'_>, scene: &PlaneScene, ui_from_plane: &RectTransform, rect: Rect) {
    let painter = ui.painter_at(rect);
    let (font, weak) = (FontId::proportional(12.0), ui.visuals().weak_text_color());
    let mut y = rect.top() + 16.0;
    // Each entry goes below the one before: an absent part leaves no gap.
    let mut entry = |text: &str, of: Option<Which>, draw: &dyn Fn(Pos2)| {
        let ends @ [from, to] = [pos2(rect.left() + 12.0, y), pos2(rect.left() + 36.0, y)];
        of.into_iter().for_each(|which| line(&painter, which, &ends, colour(ui, which)));
        draw(from + 0.5 * (to - from));
        painter.text(to + vec2(8.0, 0.0), Align2::LEFT_CENTER, text, font.clone(), ui.visuals().text_color());
        y += 18.0;
    };
    for which in [Which::Truth, Which::Estimate, Which::Second] {
        if !scene.cameras[which as usize].is_empty() {
            let errors = model.results.poses.report(which).map(|report| format!(", aligned: {}", errors_text(report)));
            let text = name(which).to_owned() + &errors.unwrap_or_default();
            entry(&text, Some(which), &|middle| sign(&painter, which, middle, 3.0, colour(ui, which)));
        }
    }
    if (0..scene.cameras[Which::Truth as usize].len()).any(|camera| is_missing(model, camera)) {
        let ring = |middle| sign(&painter, Which::Truth, middle, 3.0, ui.visuals().error_fg_color);
        entry("Not registered", None, &ring);
    }
    if !scene.points.is_empty() {
        let all = model.results.poses.model().map_or(0, |model| model.points.len());
        let text = match scene.points.len() {
            drawn if drawn < all => format!("3D points, {drawn} of {all} drawn"),
            drawn => format!("{drawn} 3D points"),
        };
        let point = |middle| Rect::from_center_size(middle, vec2(2.5, 2.5));
        entry(&text, None, &|middle| _ = painter.rect_filled(point(middle), 0.0, weak));
    }
    // The scale bar takes up to a quarter of the width.
    let points_per_unit = scene.scale * f64::from(ui_from_plane.scale());
    let longest = 0.25 * f64::from(rect.width()) / points_per_unit;
    let length = if longest.is_normal() { round_length(longest) } else { 1.0 };
    let width = (length * points_per_unit) as f32;
    let from = rect.left_bottom() + vec2(12.0, -14.0);
    painter.line_segment([from, from + vec2(width, 0.0)], Stroke::new(2.0, ui.visuals().text_color()));
    // Without a truth the world of the estimate has an arbitrary unit.
    let whose = if model.results.poses.read(Which::Truth).is_none() { "estimate" } else { "truth" };
    let text = format!("{} (the {whose}'s unit)", crate::app::canvas::number(length as f32, 3));
    painter.text(from + vec2(0.0, -5.0), Align2::LEFT_BOTTOM, text, font.clone(), weak);
    let text = match model.document.trajectories.projection.about().1 {
        ["", _] => "A drag turns the view, a double click begins again".to_owned(),
        [right, up] => format!("{right}: to the right,  {up}: up"),
    };
    painter.text(rect.right_bottom() + vec2(-10.0, -8.0), Align2::RIGHT_BOTTOM, text, font, weak);
}

pub fn errors_text(PoseReport { right, images, absolute, .. }: &PoseReport) -> String {
    let [ate, angle] = [absolute.translation.rmse, absolute.rotation_deg.rmse];
    format!("{right} of {images} right, ATE {ate:.4}, {angle:.3}°")
}

#[derive(Debug, Clone, PartialEq)]
struct Bar {
    label: String,
    /// Number of 3D points in each sparse model; `None` for an image that was not registered.
    points: Vec<(Which, Option<usize>)>,
    camera: Option<usize>,
}

/// A bar for each image: of the truth, in its order, where there is a comparison, otherwise of the estimate.
fn bars(model: Read<'_>) -> Vec<Bar> {
    let poses = &model.results.poses;
    if poses.compared.pairs.is_empty() {
        let images = poses.model().into_iter().flat_map(|sparse| &sparse.images);
        let points = |image: &SparseImage| vec![(Which::Estimate, Some(image.points))];
        return images.map(|i| Bar { label: i.name.clone(), points: points(i), camera: None }).collect();
    }
    let models = poses.reports().filter(|(_, report)| report.model.is_some());
    let models: Vec<Which> = models.map(|(which, _)| which).collect();
    let bar = |camera: usize| {
        let points = |which| points_of(model, which, poses.pair(which, camera)?.estimate);
        let points = models.iter().map(|&which| (which, points(which))).collect();
        Bar { label: camera_label(model, camera).to_owned(), points, camera: Some(camera) }
    };
    (0..poses.compared.pairs.len()).filter(|_| !models.is_empty()).map(bar).collect()
}

pub fn points_strip_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let bars = bars(model);
    let (rect, response) = ui.allocate_exact_size(ui.available_size().max(vec2(40.0, 40.0)), Sense::click());
    named(&response, egui::Role::Image, "3D points of each image");
    let (painter, visuals) = (ui.painter_at(rect), ui.visuals());
    let font = FontId::proportional(11.0);
    if bars.is_empty() {
        let text = "A sparse model says how many 3D points each image sees; a trajectory file does not";
        painter.text(rect.center(), Align2::CENTER_CENTER, text, font, visuals.weak_text_color());
        return;
    }
    let most = bars.iter().flat_map(|bar| bar.points.iter().filter_map(|(_, points)| *points)).max();
    let most = most.unwrap_or(0).max(1);
    let plot = Rect::from_min_max(rect.min + vec2(44.0, 6.0), rect.max - vec2(6.0, 4.0));
    let step = plot.width() / bars.len() as f32;
    // Narrow bars touch: a gap would take most of their width.
    let gap = if step > 6.0 { 1.0 } else { 0.0 };
    for (number, y, align) in [(most, plot.top(), Align2::RIGHT_TOP), (0, plot.bottom(), Align2::RIGHT_BOTTOM)] {
        let text = number.to_string();
        painter.text(pos2(plot.left() - 6.0, y), align, text, font.clone(), visuals.weak_text_color());
    }
    let pointed = response.hover_pos().filter(|p| plot.contains(*p)).map(|p| ((p.x - plot.left()) / step) as usize);
    let camera = pointed.and_then(|k| bars.get(k)?.camera);
    if response.hovered() {
        queue.point(&model.results.poses.hovered, camera, Pointed::Camera);
    }
    queue.push_if(response.clicked(), Action::SelectCamera(camera));
    for (k, bar) in bars.iter().enumerate() {
        let at = |k: f32| plot.left() + k * step;
        let column = Rect::from_x_y_ranges(at(k as f32) + gap..=at(k as f32 + 1.0) - gap, plot.y_range());
        let marked = is_marked(model, bar.camera);
        // The whole column is lit, so that a low bar is found as easily as a high one.
        if marked || pointed == Some(k) {
            painter.rect_filled(column.expand(gap), 0.0, visuals.widgets.hovered.weak_bg_fill);
        }
        let width = column.width() / bar.points.len() as f32;
        for (place, (which, points)) in bar.points.iter().enumerate() {
            let left = column.left() + place as f32 * width;
            let column = Rect::from_x_y_ranges(left..=left + width, plot.y_range());
            // A low bar of another colour: an image that was not registered differs from one without points.
            let height = points.map_or(3.0, |points| plot.height() * points as f32 / most as f32);
            let colour = match points {
                Some(_) if marked => visuals.strong_text_color(),
                Some(_) => colour(ui, *which),
                None => visuals.error_fg_color,
            };
            painter.rect_filled(column.with_min_y(plot.bottom() - height), 0.0, colour);
        }
    }
    if let Some(bar) = pointed.and_then(|k| bars.get(k)) {
        let text = match (bar.camera, &bar.points[..]) {
            (None, [(_, Some(points)), ..]) => format!("{}\n{points} 3D points", bar.label),
            (Some(camera), _) => camera_text(model, camera),
            _ => bar.label.clone(),
        };
        response.on_hover_text_at_pointer(text);
    }
}

/// The image, and three columns for each estimate.
const HEADINGS: [(&str, &str); 7] = [
    ("image", "The image's name, or the time"),
    ("error", "Distance of the camera's centre from the true one, in the truth's unit"),
    ("angle °", "Angle between the camera's directions and the true ones, degrees"),
    ("3D points", "Points of the sparse model that the image sees"),
    ("error 2", "Distance of the second estimate's centre from the true one, in the truth's unit"),
    ("angle ° 2", "Angle between the second estimate's directions and the true ones, degrees"),
    ("3D points 2", "Points of the second sparse model that the image sees"),
];

pub fn camera_list_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let poses = &model.results.poses;
    let of_estimate = |(which, _)| (1..4).map(move |column| 3 * which as usize + column);
    let columns: Vec<usize> = [0].into_iter().chain(poses.reports().flat_map(of_estimate)).collect();
    if columns.len() == 1 {
        return instead_ui(ui, "Cameras of a truth are listed here, once an estimate is compared with it");
    }
    let items: Vec<usize> = (0..poses.compared.pairs.len()).collect();
    let listed = Listed { items: &items, selected: model.document.trajectories.selected, hovered: poses.hovered };
    let heading = |column: &usize| {
        let ((text, help), is_left) = (HEADINGS[*column], *column == 0);
        let width = if is_left { 120.0 } else { 84.0 };
        Heading { text, help, width, is_exact: !is_left, is_left, ..Heading::default() }
    };
    let headings: Vec<Heading> = columns.iter().map(heading).collect();
    let text = |column: usize, camera: usize| {
        let Some(column) = columns[column].checked_sub(1) else { return camera_label(model, camera).to_owned() };
        let which = Which::ESTIMATES[column / 3];
        let value = poses.pair(which, camera).and_then(|pair| match column % 3 {
            0 => Some(format!("{:.4}", pair.translation_error)),
            1 => Some(format!("{:.3}", pair.rotation_error_deg)),
            _ => points_of(model, which, pair.estimate).map(|points| points.to_string()),
        });
        value.unwrap_or_else(|| "–".to_owned())
    };
    let name = |camera: usize| format!("Camera {}", camera_label(model, camera));
    rows_ui(ui, &headings, None, &listed, texts(&headings, text), name, |row, camera| {
        if row.hovered() {
            queue.point(&poses.hovered, Some(camera), Pointed::Camera);
        }
        queue.push_if(row.clicked(), Action::SelectCamera(Some(camera)));
        queue.push_if(row.double_clicked(), Action::OpenCamera(camera_label(model, camera).to_owned()));
    });
}
