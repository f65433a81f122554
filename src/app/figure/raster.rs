//! Draws a figure as pixels, without a graphics card: egui makes triangles of lines and letters, and this module fills
//! them.

use crate::app::canvas::overlay::add_fan;
use crate::export::{DASH, Drawing, FigureRect, FigureShape, FigureStroke, FigureUnit};
use crate::plane::memory;
use egui::epaint::{ClippedPrimitive, ImageData, Mesh, Primitive};
use egui::{Color32, ColorImage, FontId, Painter, Pos2, Rect, Shape, Stroke, TextureId, pos2, vec2};
use image::imageops::{FilterType, resize};
use image::{ImageBuffer, Rgba, RgbaImage};
use std::borrow::Cow;
use std::collections::HashMap;

const MAX_SIDE_PX: f32 = 20_000.0;

/// Pixels in an inch of a figure whose unit is the point: what printers ask of pictures.
const PIXELS_PER_INCH: f32 = 300.0;

/// Draws one pixel for each figure pixel, or 300 an inch on paper. Fails when the figure is too large.
pub fn rasterise(drawing: &Drawing) -> Result<RgbaImage, String> {
    let pixels_per_unit = if drawing.unit == FigureUnit::Point { PIXELS_PER_INCH / 72.0 } else { 1.0 };
    let [width, height] = drawing.size.map(|side| (side * pixels_per_unit - 1e-3).ceil());
    if width > MAX_SIDE_PX || height > MAX_SIDE_PX {
        return Err(format!(
            "the figure would have {width:.0} × {height:.0} pixels, and at most {MAX_SIDE_PX:.0} a side are drawn; choose a smaller scale"
        ));
    }
    let mut pixels = memory::zeroed(width as usize * height as usize * 4);
    pixels.fill(255);
    let mut image = RgbaImage::from_raw(width as u32, height as u32, pixels).ok_or("the figure has no size")?;
    // Shapes of whole pixels lie at the bottom of every figure.
    for shape in &drawing.shapes {
        fill(&mut image, shape, pixels_per_unit);
    }
    let context = egui::Context::default();
    context.set_pixels_per_point(pixels_per_unit);
    let sheet = Rect::from_min_size(Pos2::ZERO, vec2(width, height) / pixels_per_unit);
    let input = egui::RawInput { screen_rect: Some(sheet), ..Default::default() };
    let mut output = context.run_ui(input, |ui| {
        let painter = ui.painter_at(sheet);
        let is_filled = |shape: &&FigureShape| matches!(shape, FigureShape::Fill { .. });
        drawing.shapes.iter().filter(|shape| !is_filled(shape)).for_each(|shape| draw(&painter, shape));
    });
    let mut textures: HashMap<TextureId, ColorImage> = HashMap::new();
    for (id, deltas) in output.textures_delta.set.drain() {
        for delta in deltas {
            let ImageData::Color(part) = &delta.image;
            match (delta.pos, textures.get_mut(&id)) {
                (Some([x, y]), Some(whole)) => {
                    for (row, pixels) in part.pixels.chunks(part.size[0].max(1)).enumerate() {
                        let start = (y + row) * whole.size[0] + x;
                        whole.pixels[start..start + pixels.len()].copy_from_slice(pixels);
                    }
                }
                _ => {
                    textures.insert(id, ColorImage::clone(part));
                }
            }
        }
    }
    output.textures_delta.free.clear();
    for ClippedPrimitive { clip_rect, primitive } in context.tessellate(output.shapes, pixels_per_unit) {
        if let Primitive::Mesh(mut mesh) = primitive
            && let Some(texture) = textures.get(&mesh.texture_id)
        {
            mesh.vertices.iter_mut().for_each(|vertex| vertex.pos = (vertex.pos.to_vec2() * pixels_per_unit).to_pos2());
            fill_mesh(&mut image, clip_rect * pixels_per_unit, &mesh, texture);
        }
    }
    Ok(image)
}

fn fill(image: &mut RgbaImage, shape: &FigureShape, pixels_per_unit: f32) {
    let scaled = |rect: &FigureRect| FigureRect {
        min: rect.min.map(|at| at * pixels_per_unit),
        size: rect.size.map(|side| side * pixels_per_unit),
    };
    match shape {
        FigureShape::Fill { rect, color } => {
            let [r, g, b] = *color;
            for_pixels(image, &scaled(rect), |_, _| Rgba([r, g, b, 255]));
        }
        FigureShape::Picture { rect, size, rgba } => {
            let rect = scaled(rect);
            // A picture that is shrunk is averaged, so that no row of it is left out.
            let shrunk = (rect.size[0] < size.0 as f32).then(|| {
                let whole = ImageBuffer::<Rgba<u8>, &[u8]>::from_raw(size.0 as u32, size.1 as u32, rgba)?;
                let [width, height] = rect.size.map(|side| side.round().max(1.0) as u32);
                Some(resize(&whole, width, height, FilterType::Triangle))
            });
            let (size, rgba) = match shrunk.flatten() {
                Some(small) => ((small.width() as usize, small.height() as usize), Cow::Owned(small.into_raw())),
                None => (*size, Cow::Borrowed(&rgba[..])),
            };
            let place = |x: f32, size: usize| ((x * size as f32) as usize).min(size - 1);
            for_pixels(image, &rect, |x, y| {
                let start = 4 * (place(y, size.1) * size.0 + place(x, size.0));
                Rgba([rgba[start], rgba[start + 1], rgba[start + 2], 255])
            });
        }
        _ => {}
    }
}

/// Sets the pixels whose centres lie in `rect`; `at` gets their positions in it, 0 … 1 on each axis.
fn for_pixels(image: &mut RgbaImage, rect: &FigureRect, at: impl Fn(f32, f32) -> Rgba<u8>) {
    let range = |min: f32, size: f32, most: u32| {
        let first = (min - 0.5).ceil().max(0.0) as u32;
        first..((min + size - 0.5).ceil().max(0.0) as u32).min(most)
    };
    let ([x0, y0], [width, height]) = (rect.min, rect.size);
    for y in range(y0, height, image.height()) {
        for x in range(x0, width, image.width()) {
            let pixel = at((x as f32 + 0.5 - x0) / width, (y as f32 + 0.5 - y0) / height);
            image.put_pixel(x, y, pixel);
        }
    }
}

fn draw(painter: &Painter, shape: &FigureShape) {
    let pos = |[x, y]: [f32; 2]| pos2(x, y);
    let line = |stroke: &FigureStroke| {
        let [r, g, b] = stroke.color;
        Stroke::new(stroke.width, Color32::from_rgb(r, g, b).gamma_multiply(stroke.opacity))
    };
    match shape {
        FigureShape::Picture { .. } => {}
        // Those at the bottom of the figure are filled already.
        FigureShape::Fill { rect, color: [r, g, b] } => {
            let rect = Rect::from_min_size(pos(rect.min), vec2(rect.size[0], rect.size[1]));
            painter.rect_filled(rect, 0.0, Color32::from_rgb(*r, *g, *b));
        }
        FigureShape::Circle { centre, radius, stroke, dashed: false } => {
            painter.circle_stroke(pos(*centre), *radius, line(stroke));
        }
        FigureShape::Circle { centre, radius, stroke, dashed: true } => {
            let around: Vec<Pos2> = (0..=96)
                .map(|i| pos(*centre) + *radius * egui::Vec2::angled(i as f32 * std::f32::consts::TAU / 96.0))
                .collect();
            let piece = (std::f32::consts::TAU * radius / 16.0).max(0.5);
            painter.extend(Shape::dashed_line(&around, line(stroke), piece, piece));
        }
        FigureShape::Line { points, stroke, dashed: true, .. } => {
            let points: Vec<Pos2> = points.iter().copied().map(pos).collect();
            let dash = (DASH * stroke.width).max(0.5);
            painter.extend(Shape::dashed_line(&points, line(stroke), dash, dash));
        }
        FigureShape::Line { points, stroke, .. } => {
            painter.add(Shape::line(points.iter().copied().map(pos).collect(), line(stroke)));
        }
        FigureShape::Fan { points, color: [r, g, b], opacity } => {
            let mut mesh = Mesh::default();
            add_fan(&mut mesh, points, Color32::from_rgb(*r, *g, *b).gamma_multiply(*opacity));
            painter.add(Shape::mesh(mesh));
        }
        FigureShape::Text { at, size, text, color } => {
            let [r, g, b] = *color;
            let galley = painter.layout_no_wrap(text.clone(), FontId::proportional(*size), Color32::from_rgb(r, g, b));
            // The text's position is its baseline: the glyphs of the first row stand on it.
            let ascent = galley.rows.first().and_then(|row| row.glyphs.first()).map_or(0.8 * size, |glyph| glyph.pos.y);
            painter.galley(pos2(at[0], at[1] - ascent), galley, Color32::BLACK);
        }
        FigureShape::Clipped { rect, shapes } => {
            let clip = Rect::from_min_size(pos(rect.min), vec2(rect.size[0], rect.size[1]));
            let clipped = painter.with_clip_rect(clip);
            shapes.iter().for_each(|shape| draw(&clipped, shape));
        }
    }
}

/// Fills the triangles of a mesh; a pixel is filled where its centre is covered.
fn fill_mesh(image: &mut RgbaImage, clip: Rect, mesh: &Mesh, texture: &ColorImage) {
    for triangle in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.vertices[triangle[i] as usize]);
        let area = cross(b.pos - a.pos, c.pos - a.pos);
        if area == 0.0 || !area.is_finite() {
            continue;
        }
        let bounds = Rect::from_points(&[a.pos, b.pos, c.pos]).intersect(clip);
        let range = |min: f32, max: f32, most: u32| {
            ((min - 0.5).ceil().max(0.0) as u32)..((max - 0.5).floor() + 1.0).clamp(0.0, most as f32) as u32
        };
        for y in range(bounds.min.y, bounds.max.y, image.height()) {
            for x in range(bounds.min.x, bounds.max.x, image.width()) {
                let p = pos2(x as f32 + 0.5, y as f32 + 0.5);
                let weights = [
                    cross(b.pos - p, c.pos - p) / area,
                    cross(c.pos - p, a.pos - p) / area,
                    cross(a.pos - p, b.pos - p) / area,
                ];
                // A pixel on the edge between two triangles belongs to one of them.
                let inside = weights.iter().all(|w| *w >= 0.0) && !(weights[0] == 0.0 || weights[1] == 0.0);
                if !inside {
                    continue;
                }
                let mix = |of: fn(&egui::epaint::Vertex) -> f32| {
                    weights[0] * of(&a) + weights[1] * of(&b) + weights[2] * of(&c)
                };
                let texel = texel(texture, mix(|v| v.uv.x), mix(|v| v.uv.y));
                let channels: [fn(&egui::epaint::Vertex) -> f32; 4] = [
                    |v| f32::from(v.color.r()),
                    |v| f32::from(v.color.g()),
                    |v| f32::from(v.color.b()),
                    |v| f32::from(v.color.a()),
                ];
                let source: [f32; 4] = std::array::from_fn(|i| mix(channels[i]) * f32::from(texel[i]) / 255.0);
                blend(image.get_pixel_mut(x, y), source);
            }
        }
    }
}

fn cross(a: egui::Vec2, b: egui::Vec2) -> f32 {
    a.x * b.y - a.y * b.x
}

fn texel(texture: &ColorImage, u: f32, v: f32) -> [u8; 4] {
    let place = |x: f32, size: usize| ((x * size as f32).max(0.0) as usize).min(size - 1);
    texture.pixels[place(v, texture.size[1]) * texture.size[0] + place(u, texture.size[0])].to_array()
}

fn blend(pixel: &mut Rgba<u8>, source: [f32; 4]) {
    let rest = 1.0 - source[3] / 255.0;
    for (channel, new) in pixel.0.iter_mut().zip(source).take(3) {
        *channel = (new + rest * f32::from(*channel)).round().clamp(0.0, 255.0) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn drawing(shapes: Vec<FigureShape>) -> Drawing {
        Drawing { size: [60.0, 40.0], unit: FigureUnit::Pixel, shapes, title: String::new() }
    }

    const RED: FigureStroke = FigureStroke { width: 4.0, color: [255, 0, 0], opacity: 1.0 };

    #[test]
    fn pictures_lines_and_circles_are_where_they_belong() {
        let picture = FigureShape::Picture {
            rect: FigureRect { min: [10.0, 10.0], size: [20.0, 10.0] },
            size: (2, 1),
            rgba: Arc::new(vec![0, 0, 0, 255, 0, 0, 255, 255]),
        };
        let line =
            FigureShape::Line { points: vec![[0.0, 30.0], [60.0, 30.0]], stroke: RED, dashed: false, class: "x" };
        let circle = FigureShape::Circle { centre: [45.0, 15.0], radius: 8.0, stroke: RED, dashed: false };
        let image = rasterise(&drawing(vec![picture, line, circle])).expect("small");
        assert_eq!(image.dimensions(), (60, 40));
        let pixel = |x: u32, y: u32| image.get_pixel(x, y).0;
        assert_eq!((pixel(15, 15), pixel(25, 15), pixel(5, 5)), ([0, 0, 0, 255], [0, 0, 255, 255], [255; 4]));
        assert_eq!((pixel(30, 30), pixel(30, 25)), ([255, 0, 0, 255], [255; 4]));
        assert_eq!((pixel(53, 15), pixel(45, 15)), ([255, 0, 0, 255], [255; 4]));
    }

    #[test]
    fn what_is_clipped_ends_at_the_rectangle_and_letters_stand_on_their_line() {
        let line = FigureShape::Line { points: vec![[0.0, 5.0], [60.0, 5.0]], stroke: RED, dashed: false, class: "x" };
        let rect = FigureRect { min: [0.0, 0.0], size: [30.0, 40.0] };
        let text = FigureShape::Text { at: [4.0, 34.0], size: 16.0, text: "HEH".into(), color: [0; 3] };
        let image = rasterise(&drawing(vec![FigureShape::Clipped { rect, shapes: vec![line] }, text])).expect("small");
        assert_eq!((image.get_pixel(20, 5).0, image.get_pixel(45, 5).0), ([255, 0, 0, 255], [255; 4]));
        let dark = |y: u32| (0..60).filter(|x| image.get_pixel(*x, y).0[0] < 120).count();
        assert!(dark(30) > 3, "letters are drawn");
        assert_eq!((dark(36), dark(15)), (0, 0), "and end at the line that they stand on");
    }

    #[test]
    fn a_fan_tints_what_lies_within_it_and_nothing_else() {
        let points = crate::export::fan([10.0, 20.0], [40.0, 20.0], 10.0).expect("large enough");
        let fan = FigureShape::Fan { points, color: [255, 0, 0], opacity: 0.5 };
        let image = rasterise(&drawing(vec![fan])).expect("small");
        let pixel = |x: u32, y: u32| image.get_pixel(x, y).0;
        for (x, y) in [(40, 20), (45, 14), (20, 20)] {
            let [red, green, blue, _] = pixel(x, y);
            assert!(red == 255 && green.abs_diff(127) < 3 && green == blue, "{x} {y}: {:?}", pixel(x, y));
        }
        for (x, y) in [(53, 20), (15, 12), (5, 20)] {
            assert_eq!(pixel(x, y), [255; 4], "{x} {y}");
        }
    }

    #[test]
    fn what_is_too_large_is_said() {
        let large = Drawing { size: [1e6, 10.0], ..drawing(Vec::new()) };
        assert!(rasterise(&large).is_err_and(|why| why.contains("smaller scale")));
    }
}
