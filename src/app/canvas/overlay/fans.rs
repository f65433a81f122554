//! Uncertainty of motions: fans of one standard deviation around the arrows of features, and ellipses over the field.

use super::CanvasOutput;
use crate::detector::{Feature, Motion, MotionField};
use crate::export::motion_over;
use egui::{Color32, Mesh, Pos2, Shape, Stroke, Vec2, pos2, vec2};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Smallest standard deviation at the tip of an arrow that has a fan, points.
const MIN_FAN_POINTS: f32 = 3.0;
const FAN_OPACITY: f32 = 0.16;
const PIECES: usize = 16;
/// Smallest cells of the field over which ellipses are drawn, and the smallest distance between two, points.
const MIN_CELL_POINTS: f32 = 24.0;
const MIN_APART_POINTS: f32 = 48.0;

/// Fills the fans of `features`, each with its colour: from the middle of the arrow around the circle of one standard
/// deviation at its tip.
pub(super) fn draw_fans<'a>(
    output: &CanvasOutput,
    features: impl Iterator<Item = (&'a Feature, Color32)>,
    frames: usize,
) {
    let mut mesh = Mesh::default();
    for (feature, colour) in features {
        let t = output.ui_from_image;
        let (centre, tip) = (t.pos(pos2(feature.u, feature.v)), t.pos(motion_over(feature, frames)[1].into()));
        let radius = feature.motion().1 * 0.5 * frames.saturating_sub(1) as f32 * t.scale();
        if radius.is_finite() && radius > MIN_FAN_POINTS {
            add_fan(&mut mesh, centre, tip, radius, colour.gamma_multiply(FAN_OPACITY));
        }
    }
    if !mesh.is_empty() {
        output.painter.add(Shape::mesh(mesh));
    }
}

fn add_fan(mesh: &mut Mesh, centre: Pos2, tip: Pos2, radius: f32, colour: Color32) {
    let along = tip - centre;
    // Within the circle there is nothing to point from.
    let (from, half) = if along.length() > radius {
        // Up to the tangents from the middle.
        (centre, FRAC_PI_2 + (radius / along.length()).asin())
    } else {
        (tip, PI)
    };
    let first = mesh.vertices.len() as u32;
    mesh.colored_vertex(from, colour);
    for piece in 0..=PIECES as u32 {
        let angle = along.angle() + half * (2.0 * piece as f32 / PIECES as f32 - 1.0);
        mesh.colored_vertex(tip + radius * Vec2::angled(angle), colour);
        if piece > 0 {
            mesh.add_triangle(first, first + piece, first + piece + 1);
        }
    }
}

/// Draws the motions of the field's cells as lines from their middles, each with the ellipse of one standard deviation
/// at its end, as soon as the cells are large on screen. A motion of `max_px_per_frame` is as long as half the distance
/// between two lines.
pub fn draw_field(output: &CanvasOutput, field: &MotionField, max_px_per_frame: f32) {
    let cell_points = field.cell_px as f32 * output.ui_from_image.scale();
    if cell_points < MIN_CELL_POINTS {
        return;
    }
    let every = (MIN_APART_POINTS / cell_points).ceil() as usize;
    let points = 0.5 * every as f32 * cell_points / max_px_per_frame;
    let middle = |cell: usize| (cell as f32 + 0.5) * field.cell_px as f32 - 0.5;
    let seen = output.visible_image;
    for (u, v) in (0..field.size.1).step_by(every).flat_map(|j| {
        let columns = (0..field.size.0).step_by(every);
        columns.map(move |i| (middle(i), middle(j)))
    }) {
        let Some(motion) = field.known_at(u, v).filter(|_| seen.contains(pos2(u, v))) else { continue };
        let from = output.ui_from_image.pos(pos2(u, v));
        let line = [from, from + points * vec2(motion.slope.u, motion.slope.v)];
        let rim: Vec<Pos2> = rim(&motion).map(|aside| line[1] + points * aside).collect();
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
    fn a_fan_touches_the_circle_of_its_tip_and_a_large_one_is_that_circle() {
        let (centre, tip) = (pos2(10.0, 20.0), pos2(40.0, 20.0));
        let mut mesh = Mesh::default();
        add_fan(&mut mesh, centre, tip, 10.0, Color32::RED);
        assert!(mesh.is_valid());
        let bounds = mesh.calc_bounds();
        assert!((bounds.min.x - 10.0).abs() < 1e-3 && (bounds.max.x - 50.0).abs() < 1e-3, "{bounds:?}");
        assert!((9.0..=10.001).contains(&(0.5 * bounds.height())), "{bounds:?}");
        let mut large = Mesh::default();
        add_fan(&mut large, centre, tip, 40.0, Color32::RED);
        let reach = |vertex: &egui::epaint::Vertex| vertex.pos.distance(tip);
        assert!(large.vertices.iter().skip(1).all(|vertex| (reach(vertex) - 40.0).abs() < 1e-3));
    }

    #[test]
    fn the_ellipse_of_an_edge_is_long_along_it() {
        let motion = Motion { slope: Slope::new(1.0, 0.0), covariance: [0.01, 0.0, 0.25] };
        let (x, y) = rim(&motion).fold((0.0f32, 0.0f32), |(x, y), at| (x.max(at.x), y.max(at.y)));
        assert!((x - 0.1).abs() < 1e-3 && (y - 0.5).abs() < 1e-3, "{x} {y}");
    }
}
