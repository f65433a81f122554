//! Our features and those of others over a picture: circles of true scale, coloured by the outcome of the comparison,
//! dashed for features that only the others have, with a line from the compared place.

use super::strokes::Strokes;
use super::{CanvasOutput, MIN_RADIUS_POINTS};
use egui::{Color32, Pos2, Shape};

/// Mark of a compared feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedMark {
    /// Place, image pixels.
    pub pos_image: Pos2,
    /// Scale σ, image pixels.
    pub sigma: f32,
    /// Previous place of a feature that moved, image pixels; a line is drawn from it.
    pub from_image: Option<Pos2>,
    /// Colour of the circle.
    pub colour: Color32,
    /// Whether the feature is not one of ours.
    pub dashed: bool,
}

impl ComparedMark {
    fn radius_image(&self) -> f32 {
        std::f32::consts::SQRT_2 * self.sigma
    }
}

/// Draws `marks` over the canvas of `output`; the `highlighted` one lies above all others.
pub fn draw_compared(output: &CanvasOutput, marks: &[ComparedMark], highlighted: Option<usize>) {
    let mut strokes = Strokes::new(output.painter.pixels_per_point());
    let edge = Color32::from_black_alpha(110);
    let visible = output.visible_image;
    let seen = |mark: &&ComparedMark| visible.expand(mark.radius_image()).contains(mark.pos_image);
    for mark in marks.iter().filter(seen) {
        draw_one(&mut strokes, output, mark, 3.4, edge);
    }
    for mark in marks.iter().filter(seen) {
        draw_one(&mut strokes, output, mark, 1.6, mark.colour);
    }
    if let Some(mark) = highlighted.and_then(|index| marks.get(index)) {
        for (width, colour) in [(7.0, Color32::from_black_alpha(150)), (5.0, Color32::WHITE), (2.6, mark.colour)] {
            draw_one(&mut strokes, output, mark, width, colour);
        }
    }
    let mesh = strokes.into_mesh();
    if !mesh.is_empty() {
        output.painter.add(Shape::mesh(mesh));
    }
}

fn draw_one(strokes: &mut Strokes, output: &CanvasOutput, mark: &ComparedMark, width: f32, colour: Color32) {
    let t = output.ui_from_image;
    let centre = t.pos(mark.pos_image);
    let radius = (mark.radius_image() * t.scale()).max(MIN_RADIUS_POINTS);
    strokes.circle(centre, radius, width, colour, mark.dashed);
    if let Some(from) = mark.from_image.map(|from| t.pos(from)).filter(|from| from.distance(centre) > 3.0) {
        strokes.arrow(from, centre, 0.8 * width, colour);
    }
}

/// Finds the mark under the pointer: that with the nearest circle or centre, within a few points.
pub fn mark_at(output: &CanvasOutput, marks: &[ComparedMark], pointer: Pos2) -> Option<usize> {
    const REACH_POINTS: f32 = 8.0;
    let t = output.ui_from_image;
    let apart = |mark: &ComparedMark| {
        let distance = t.pos(mark.pos_image).distance(pointer);
        distance.min((distance - mark.radius_image() * t.scale()).abs())
    };
    let near = marks.iter().enumerate().map(|(index, mark)| (index, apart(mark))).filter(|(_, d)| *d <= REACH_POINTS);
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}
