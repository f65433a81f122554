//! Anti-aliased circles and lines, thousands of them in one mesh.
//!
//! One mesh for all spares egui the sorting and stroking of single shapes, and keeps a full window at display rate.

use egui::{Color32, Mesh, Painter, Pos2, Shape, Vec2};

pub struct Strokes {
    mesh: Mesh,
    /// Width of the soft edge: one pixel of the screen, in points.
    feather: f32,
}

impl Strokes {
    pub fn new(pixels_per_point: f32) -> Self {
        Self { mesh: Mesh::default(), feather: 1.0 / pixels_per_point }
    }

    pub fn with_room_for(pixels_per_point: f32, count: usize) -> Self {
        let mut strokes = Self::new(pixels_per_point);
        strokes.mesh.reserve_vertices(100 * count);
        strokes.mesh.reserve_triangles(130 * count);
        strokes
    }

    pub fn paint(self, painter: &Painter) {
        painter.add(Shape::mesh(self.mesh));
    }

    /// Adds the vertices across a stroke, `at` distances from its middle, and returns their number.
    fn across(&mut self, width: f32, colour: Color32, at: impl Fn(f32) -> Pos2) -> u32 {
        let clear = Color32::TRANSPARENT;
        let (solid, reach) = (0.5 * (width - self.feather), 0.5 * (width + self.feather));
        // So thin a line is nearly all soft edge: three vertices, which cover as much area, in place of four.
        let thin = [(-width, clear), (0.0, colour), (width, clear)];
        let thick = [(-reach, clear), (-solid, colour), (solid, colour), (reach, clear)];
        let vertices = if width < 1.7 * self.feather { &thin[..] } else { &thick };
        vertices.iter().for_each(|(offset, colour)| self.mesh.colored_vertex(at(*offset), *colour));
        vertices.len() as u32
    }

    fn join(&mut self, a: u32, b: u32, count: u32) {
        for band in 0..count - 1 {
            self.mesh.add_triangle(a + band, a + band + 1, b + band);
            self.mesh.add_triangle(a + band + 1, b + band, b + band + 1);
        }
    }

    /// Adds a circle. With `dashed` every other piece is left out.
    pub fn circle(&mut self, centre: Pos2, radius: f32, width: f32, colour: Color32, dashed: bool) {
        let table = unit_circle(radius);
        let first = self.mesh.vertices.len() as u32;
        let mut count = 0;
        for &direction in table {
            count = self.across(width, colour, |offset| centre + (radius + offset).max(0.0) * direction);
        }
        let pieces = table.len() as u32;
        // Dashes of equal length: their number divides the circle.
        let per_dash = (pieces / 16).max(1);
        for i in 0..pieces {
            if !dashed || (i / per_dash).is_multiple_of(2) {
                self.join(first + count * i, first + count * ((i + 1) % pieces), count);
            }
        }
    }

    pub fn line(&mut self, from: Pos2, to: Pos2, width: f32, colour: Color32) {
        let along = to - from;
        if along.length_sq() < 1e-6 {
            return;
        }
        let across = along.normalized().rot90();
        let first = self.mesh.vertices.len() as u32;
        let count = self.across(width, colour, |offset| from + offset * across);
        self.across(width, colour, |offset| to + offset * across);
        self.join(first, first + count, count);
    }

    /// Adds a dashed line; `(dash, gap)` are lengths, in points. It begins and ends with a dash.
    pub fn dashed(&mut self, from: Pos2, to: Pos2, width: f32, colour: Color32, (dash, gap): (f32, f32)) {
        let length = from.distance(to);
        let count = ((length + gap) / (dash + gap)).round().max(1.0);
        // The gaps stretch a little so that the last dash ends at `to`.
        let step = if count > 1.0 { (length - dash) / (count - 1.0) } else { 0.0 };
        let at = |distance: f32| from + (distance / length.max(1e-6)) * (to - from);
        for i in 0..count as usize {
            let start = step * i as f32;
            self.line(at(start), at((start + dash).min(length)), width, colour);
        }
    }

    pub fn arrow(&mut self, from: Pos2, to: Pos2, width: f32, colour: Color32) {
        self.line(from, to, width, colour);
        let along = to - from;
        let head = (0.35 * along.length()).min(5.0);
        let back = -head * along.normalized();
        let turn = egui::emath::Rot2::from_angle(0.5);
        self.line(to, to + turn * back, width, colour);
        self.line(to, to + turn.inverse() * back, width, colour);
    }
}

fn unit_circle(radius: f32) -> &'static [Vec2] {
    use std::sync::LazyLock;
    static TABLES: LazyLock<[Vec<Vec2>; 5]> = LazyLock::new(|| {
        [8, 16, 32, 64, 128]
            .map(|n| (0..n).map(|i| Vec2::angled(i as f32 * std::f32::consts::TAU / n as f32)).collect())
    });
    let index = match radius {
        // The distance between circle and polygon stays below a sixth of a point (half a point for the very large).
        r if r < 2.5 => 0,
        r if r < 9.0 => 1,
        r if r < 36.0 => 2,
        r if r < 150.0 => 3,
        _ => 4,
    };
    &TABLES[index]
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn a_dashed_line_begins_and_ends_with_a_dash_and_has_gaps() {
        let mut strokes = Strokes::new(1.0);
        strokes.dashed(pos2(10.0, 5.0), pos2(110.0, 5.0), 2.0, Color32::RED, (6.0, 4.0));
        let mesh = strokes.mesh;
        let bounds = mesh.calc_bounds();
        assert!((bounds.min.x - 10.0).abs() < 1e-3 && (bounds.max.x - 110.0).abs() < 1e-3, "{bounds:?}");
        let covered: f32 = mesh.vertices.chunks(8).map(|dash| dash[7].pos.x - dash[0].pos.x).sum();
        assert!((0.5..0.7).contains(&(covered / 100.0)), "{covered}");
        let mut point = Strokes::new(1.0);
        point.dashed(pos2(1.0, 1.0), pos2(1.0, 1.0), 2.0, Color32::RED, (6.0, 4.0));
        assert!(point.mesh.vertices.iter().all(|v| v.pos.is_finite()));
    }
}
