//! Circles over a picture that are no features, such as candidates.

use super::strokes::Strokes;
use crate::app::canvas::{CanvasOutput, RectTransform};
use egui::{Color32, Pos2, Shape};

/// Circle at a place of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircleMark {
    /// Centre, image pixels.
    pub centre: Pos2,
    /// Radius, image pixels.
    pub radius: f32,
    /// Colour of the circle.
    pub colour: Color32,
    /// Whether the circle stands out.
    pub strong: bool,
}

/// Maximum distance of the pointer from a mark's centre, points; from its line, half as much.
const REACH: f32 = 6.0;
/// Minimum radius of a circle, points.
const MIN_RADIUS: f32 = 2.0;

/// Draws the visible marks.
pub fn draw_marks(output: &CanvasOutput, marks: impl Iterator<Item = CircleMark>) {
    let rect = output.painter.clip_rect();
    let mut strokes = Strokes::new(output.painter.ctx().pixels_per_point());
    for mark in marks {
        let centre = output.ui_from_image.pos(mark.centre);
        let radius = (mark.radius * output.ui_from_image.scale()).max(MIN_RADIUS);
        if rect.expand(radius).contains(centre) {
            if mark.strong {
                strokes.circle(centre, radius + 2.0, 3.5, Color32::from_black_alpha(160), false);
                strokes.circle(centre, radius + 2.0, 2.0, Color32::WHITE, false);
            }
            strokes.circle(centre, radius, 1.3, mark.colour, false);
        }
    }
    output.painter.add(Shape::mesh(strokes.into_mesh()));
}

/// Finds the circle (centre and radius, image pixels) under the pointer: of those within reach, that with the nearest
/// centre.
pub fn circle_at(
    marks: impl Iterator<Item = (Pos2, f32)>,
    ui_from_image: RectTransform,
    pointer_ui: Pos2,
) -> Option<usize> {
    let near = |(index, (centre, radius)): (usize, (Pos2, f32))| {
        let distance = ui_from_image.pos(centre).distance(pointer_ui);
        let radius = (radius * ui_from_image.scale()).max(MIN_RADIUS);
        let is_near = distance < REACH || (distance - radius).abs() < 0.5 * REACH;
        is_near.then_some((index, distance))
    };
    marks.enumerate().filter_map(near).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}
