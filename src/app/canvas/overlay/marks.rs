//! Circles over a picture that are no features: candidates, for example.

use super::strokes::Strokes;
use crate::app::canvas::{CanvasOutput, RectTransform};
use egui::{Color32, Pos2, Shape};

/// A circle at a place of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircleMark {
    /// Its middle, image pixels.
    pub centre: Pos2,
    /// Its radius, image pixels.
    pub radius: f32,
    /// Its colour.
    pub colour: Color32,
    /// Whether it stands out.
    pub strong: bool,
}

/// A mark is pointed at from within this distance of its circle's middle or line, points.
const REACH: f32 = 6.0;
/// No circle is smaller than this, points.
const MIN_RADIUS: f32 = 2.0;

/// Draws the marks that can be seen.
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

/// Which of the circles (middle and radius, image pixels) is pointed at: the one whose middle is nearest, of those
/// within reach.
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
