//! Uncertainty of motions: fans of one standard deviation around the arrows of features, and ellipses over the field.

use super::CanvasOutput;
use crate::burst::Positions;
use crate::detector::{Feature, Motion, MotionField};
use crate::export::{FAN_OPACITY, fan, motion_over, sigma_over};
use egui::{Color32, Mesh, Pos2, Shape, Stroke, Vec2, pos2, vec2};
use std::f32::consts::{FRAC_PI_2, TAU};

const PIECES: usize = 16;
/// Smallest cells of the field over which ellipses are drawn, and the smallest distance between two, points.
const MIN_CELL_POINTS: f32 = 24.0;
const MIN_APART_POINTS: f32 = 48.0;

pub(super) fn draw_fans<'a>(
    output: &CanvasOutput,
    features: impl Iterator<Item = (&'a Feature, Color32)>,
    positions: &Positions,
) {
    let mut mesh = Mesh::default();
    for (feature, colour) in features {
        let t = output.ui_from_image;
        let (centre, tip) = (t.pos(pos2(feature.u, feature.v)), t.pos(motion_over(feature, positions)[1].into()));
        if let Some(points) = fan(centre.into(), tip.into(), sigma_over(feature, positions) * t.scale()) {
            add_fan(&mut mesh, &points, colour.gamma_multiply(FAN_OPACITY));
        }
    }
    output.painter.add(Shape::mesh(mesh));
}

pub fn add_fan(mesh: &mut Mesh, points: &[[f32; 2]], colour: Color32) {
    let first = mesh.vertices.len() as u32;
    for (index, point) in (first..).zip(points) {
        mesh.colored_vertex((*point).into(), colour);
        if index > first + 1 {
            mesh.add_triangle(first, index - 1, index);
        }
    }
}

/// Draws the motions of the field's cells as lines from their middles, each with the ellipse of one standard deviation
/// at its end, as soon as the cells are large on screen: of those that `known` has at a place (u, v) of the image. A
/// motion of `max_px_per_frame` is as long as half the distance between two lines.
pub fn draw_field(
    output: &CanvasOutput,
    field: &MotionField,
    max_px_per_frame: f32,
    known: impl Fn(f32, f32) -> Option<Motion>,
) {
    let cell_points = field.cell_px as f32 * output.ui_from_image.scale();
    if cell_points < MIN_CELL_POINTS {
        return;
    }
    // Close cells are thinned, so that their lines keep apart on screen.
    let every = (MIN_APART_POINTS / cell_points).ceil() as usize;
    let points = 0.5 * every as f32 * cell_points / max_px_per_frame;
    let middle = |cell: usize| (cell as f32 + 0.5) * field.cell_px as f32 - 0.5;
    let row = |j: usize| (0..field.size.0).step_by(every).map(move |i| (middle(i), middle(j)));
    for (u, v) in (0..field.size.1).step_by(every).flat_map(row) {
        let Some(motion) = known(u, v).filter(|_| output.visible_image.contains(pos2(u, v))) else { continue };
        let from = output.ui_from_image.pos(pos2(u, v));
        let line = [from, from + points * vec2(motion.slope.u, motion.slope.v)];
        let rim: Vec<Pos2> = rim(&motion).map(|aside| line[1] + points * aside).collect();
        // Dark below white shows on any picture.
        for (width, colour) in [(2.6, Color32::from_black_alpha(120)), (1.2, Color32::WHITE)] {
            output.painter.line_segment(line, Stroke::new(width, colour));
            output.painter.add(Shape::closed_line(rim.clone(), Stroke::new(width, colour)));
        }
    }
}

/// Places on the ellipse of one standard deviation, from its middle, pixels per frame.
fn rim(motion: &Motion) -> impl Iterator<Item = Vec2> {
    let ([long, short], angle) = motion.ellipse();
    let (along, across) = (long * Vec2::angled(angle), short * Vec2::angled(angle + FRAC_PI_2));
    (0..PIECES).map(move |piece| {
        let (sin, cos) = (TAU * piece as f32 / PIECES as f32).sin_cos();
        cos * along + sin * across
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::Slope;

    #[test]
    fn the_ellipse_of_an_edge_is_long_along_it() {
        let motion = Motion { slope: Slope::new(1.0, 0.0), covariance: [0.01, 0.0, 0.25] };
        let (x, y) = rim(&motion).fold((0.0f32, 0.0f32), |(x, y), at| (x.max(at.x), y.max(at.y)));
        assert!((x - 0.1).abs() < 1e-3 && (y - 0.5).abs() < 1e-3, "{x} {y}");
    }
}
