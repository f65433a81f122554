//! Anti-aliased circles and lines, thousands of them in one mesh.
//!
//! One mesh for all spares egui the sorting and stroking of single shapes, and keeps a full window at display rate.

use egui::{Color32, ColorImage, Context, Mesh, Painter, Pos2, Rect, Shape, TextureHandle, TextureOptions, Vec2, vec2};

/// Width of the lines of a crowd, points.
pub const CROWD_WIDTH: f32 = 1.4;

pub struct Strokes {
    mesh: Mesh,
    /// Circles of a crowd, below all lines.
    rings: Option<Rings>,
    /// Width of the soft edge: one pixel of the screen, in points.
    feather: f32,
}

impl Strokes {
    pub fn new(pixels_per_point: f32) -> Self {
        Self { mesh: Mesh::default(), rings: None, feather: 1.0 / pixels_per_point }
    }

    /// Strokes whose circles of [`CROWD_WIDTH`] are two triangles each.
    pub fn of_crowd(painter: &Painter) -> Self {
        Self { rings: Some(Rings::new(painter.ctx())), ..Self::new(painter.pixels_per_point()) }
    }

    pub fn paint(self, painter: &Painter) {
        let meshes = self.rings.into_iter().map(|rings| rings.mesh).chain([self.mesh]);
        painter.extend(meshes.map(Shape::mesh));
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
        let crowd = self.rings.as_mut().filter(|_| width == CROWD_WIDTH && !dashed);
        if crowd.is_some_and(|rings| rings.add(centre, radius / self.feather, self.feather, colour)) {
            return;
        }
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
    // The distance between circle and polygon stays below a sixth of a point (half a point for the very large).
    let index = [2.5, 9.0, 36.0, 150.0].partition_point(|end| radius >= *end);
    &TABLES[index]
}

/// Circles of two triangles each: rings drawn once into a texture, and scaled to the radius asked for, where a polygon
/// has some fifty triangles. Each ring is larger than the one before by so little that nobody sees it.
struct Rings {
    atlas: TextureHandle,
    mesh: Mesh,
}

impl Rings {
    /// Rings until the radius has doubled, from a pixel on, and their number.
    const PER_DOUBLING: f32 = 12.0;
    const COUNT: usize = 56;
    const COLUMNS: usize = 8;
    /// Side of a ring's cell in the texture, pixels.
    const CELL_PX: usize = 64;

    fn new(ctx: &Context) -> Self {
        let width_px = CROWD_WIDTH * ctx.pixels_per_point();
        let id = egui::Id::unique(("rings of a crowd", width_px.to_bits()));
        let known = ctx.data(|data| data.get_temp(id));
        let atlas: TextureHandle = known
            .unwrap_or_else(|| ctx.load_texture("rings of a crowd", Self::atlas(width_px), TextureOptions::LINEAR));
        ctx.data_mut(|data| data.insert_temp(id, atlas.clone()));
        Self { mesh: Mesh::with_texture(atlas.id()), atlas }
    }

    fn radius_px(ring: usize) -> f32 {
        (ring as f32 / Self::PER_DOUBLING).exp2()
    }

    fn atlas(width_px: f32) -> ColorImage {
        let size = [Self::COLUMNS * Self::CELL_PX, Self::COUNT / Self::COLUMNS * Self::CELL_PX];
        let pixel = |at: usize| {
            let (u, v) = (at % size[0], at / size[0]);
            let centred = |x: usize| (x % Self::CELL_PX) as f32 + 0.5 - 0.5 * Self::CELL_PX as f32;
            let ring = v / Self::CELL_PX * Self::COLUMNS + u / Self::CELL_PX;
            let off_line = (centred(u).hypot(centred(v)) - Self::radius_px(ring)).abs();
            let covered = (0.5 * (width_px + 1.0) - off_line).clamp(0.0, width_px.min(1.0));
            Color32::from_white_alpha((255.0 * covered).round() as u8)
        };
        ColorImage::new(size, (0..size[0] * size[1]).map(pixel).collect())
    }

    /// Adds a circle of `radius_px`, unless it is larger than any ring; returns whether it was added.
    fn add(&mut self, centre: Pos2, radius_px: f32, points_per_pixel: f32, colour: Color32) -> bool {
        let ring = (Self::PER_DOUBLING * radius_px.log2()).round().max(0.0) as usize;
        let own_px = Self::radius_px(ring);
        // The part of the cell that holds the ring, and a pixel more.
        let half_px = own_px + 0.5 * CROWD_WIDTH / points_per_pixel + 1.0;
        if ring >= Self::COUNT || half_px > 0.5 * Self::CELL_PX as f32 {
            return false;
        }
        let cell = vec2((ring % Self::COLUMNS) as f32 + 0.5, (ring / Self::COLUMNS) as f32 + 0.5);
        let part = |half: f32| ((cell * Self::CELL_PX as f32 + Vec2::splat(half)) / self.atlas.size_vec2()).to_pos2();
        let side = 2.0 * half_px * points_per_pixel * radius_px / own_px;
        let uv = Rect::from_min_max(part(-half_px), part(half_px));
        self.mesh.add_rect_with_uv(Rect::from_center_size(centre, Vec2::splat(side)), uv, colour);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn each_ring_covers_the_area_of_its_line() {
        for width in [0.7, 1.4, 2.8f32] {
            let image = Rings::atlas(width);
            let mut areas = [0.0f32; Rings::COUNT];
            for (at, pixel) in image.pixels.iter().enumerate() {
                let (u, v) = (at % image.width() / Rings::CELL_PX, at / image.width() / Rings::CELL_PX);
                areas[v * Rings::COLUMNS + u] += f32::from(pixel.a()) / 255.0;
            }
            let radii = (0..).map(Rings::radius_px);
            // The line of a smaller ring covers its own middle.
            for (area, radius) in areas.iter().zip(radii).filter(|(_, radius)| *radius > width + 1.0) {
                let expected = std::f32::consts::TAU * radius * width;
                assert!((area / expected - 1.0).abs() < 0.06, "{radius} px, {width} px: {area} of {expected}");
            }
        }
    }

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
