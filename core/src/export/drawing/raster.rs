//! Draws a figure as pixels, without a graphics card.

use super::font::{BOLD, outline, overhang};
use super::shape::{Colour, Drawing, Face, FigureRect, FigureShape, FigureStroke, FigureUnit, Style};
use crate::plane::memory;
use image::imageops::{FilterType, resize};
use image::{ImageBuffer, Rgba, RgbaImage};
use std::{borrow::Cow, sync::Arc};
use vello_cpu::color::{AlphaColor, PremulRgba8, Srgb};
use vello_cpu::kurbo::{Affine, BezPath, Cap, Shape, Stroke};
use vello_cpu::peniko::{ImageQuality, ImageSampler};
use vello_cpu::{CompositeMode, Image, ImageSource, Pixmap, PixmapMut, RasterizerSettings, RenderContext, Resources};

const MAX_SIDE_PX: f32 = 20_000.0;

/// Pixels in an inch of a figure whose unit is the point: what printers ask of pictures.
const PIXELS_PER_INCH: f32 = 300.0;

/// Draws one pixel for each figure pixel, or 300 an inch on paper. Fails when the figure is too large.
pub fn rasterise(drawing: &Drawing) -> Result<RgbaImage, String> {
    rasterise_at(drawing, pixels_per_unit(drawing))
}

/// Draws a figure as [`rasterise`] does, in larger pixels where it would have more than `most_px` (columns, rows).
/// Fails when the figure is too large for a file of pixels, if it goes to one.
pub fn rasterise_preview(drawing: &Drawing, most_px: [u32; 2], to_pixels: bool) -> Result<RgbaImage, String> {
    let whole = pixels_per_unit(drawing);
    if to_pixels {
        size_px(drawing, whole)?;
    }
    let fitting = most_px.into_iter().zip(drawing.size).map(|(most, side)| most as f32 / side);
    rasterise_at(drawing, fitting.fold(whole, f32::min))
}

fn pixels_per_unit(drawing: &Drawing) -> f32 {
    if drawing.unit == FigureUnit::Point { PIXELS_PER_INCH / 72.0 } else { 1.0 }
}

/// Columns and rows of the pixels. Fails when there are too many.
fn size_px(drawing: &Drawing, pixels_per_unit: f32) -> Result<[u16; 2], String> {
    let [width, height] = drawing.size.map(|side| (side * pixels_per_unit - 1e-3).ceil());
    if width > MAX_SIDE_PX || height > MAX_SIDE_PX {
        return Err(format!(
            "the figure would have {width:.0} × {height:.0} pixels, and at most {MAX_SIDE_PX:.0} a side are drawn; choose a smaller scale, or write PDF or SVG"
        ));
    }
    Ok([width as u16, height as u16])
}

fn rasterise_at(drawing: &Drawing, pixels_per_unit: f32) -> Result<RgbaImage, String> {
    let [width, height] = size_px(drawing, pixels_per_unit)?;
    let mut pixels = memory::zeroed(usize::from(width) * usize::from(height) * 4);
    pixels.fill(255);
    let mut context = RenderContext::new(width, height);
    let scale = f64::from(pixels_per_unit);
    drawing.shapes.iter().for_each(|shape| draw(&mut context, Affine::scale(scale), scale, shape));
    context.flush();
    let settings = RasterizerSettings { composite_mode: CompositeMode::SrcOver, ..RasterizerSettings::default() };
    let target = PixmapMut::new(width, height, &mut pixels).ok_or("the figure has no size")?;
    context.render_with(target, &mut Resources::new(), settings);
    RgbaImage::from_raw(width.into(), height.into(), pixels).ok_or_else(|| "the figure has no size".to_owned())
}

/// Draws a shape, placed by `at`, which makes lengths `scale` times as large.
fn draw(context: &mut RenderContext, at: Affine, scale: f64, shape: &FigureShape) {
    context.set_transform(at);
    match shape {
        FigureShape::Picture { rect, size, rgba } => picture(context, rect, (*size, rgba), scale),
        FigureShape::Text { at: [x, y], anchor, size, face, color, upwards, text } => {
            let turned = Affine::rotate(if *upwards { -std::f64::consts::FRAC_PI_2 } else { 0.0 });
            let begin = Affine::translate((-f64::from(overhang(*face, *size, *anchor, text)), 0.0));
            context.set_transform(at * Affine::translate((f64::from(*x), f64::from(*y))) * turned * begin);
            let bold = (*face == Face::Bold).then(|| FigureStroke::new(*color, BOLD * size));
            let style = Style { fill: Some((*color, 1.0)), stroke: bold };
            draw_way(context, &outline(*face, *size, text), &style);
        }
        FigureShape::Clipped { rect, shapes, .. } => {
            context.push_clip_path(&rect.rect().to_path(0.1));
            shapes.iter().for_each(|shape| draw(context, at, scale, shape));
            context.pop_clip_path();
        }
        FigureShape::Moved { by: [x, y], shapes } => {
            let at = at * Affine::translate((f64::from(*x), f64::from(*y)));
            shapes.iter().for_each(|shape| draw(context, at, scale, shape));
        }
        _ => {
            if let Some((way, style)) = shape.way(0.05 / scale) {
                draw_way(context, &way, style);
            }
        }
    }
}

fn picture(context: &mut RenderContext, rect: &FigureRect, (size, rgba): ((usize, usize), &[u8]), scale: f64) {
    // A picture that is shrunk is averaged, so that no row of it is left out.
    let wanted = rect.size.map(|side| (scale * f64::from(side)).round().clamp(1.0, f64::from(MAX_SIDE_PX)) as u32);
    let shrunk = (f64::from(rect.size[0]) * scale < size.0 as f64).then(|| {
        let whole = ImageBuffer::<Rgba<u8>, &[u8]>::from_raw(size.0 as u32, size.1 as u32, rgba)?;
        Some(resize(&whole, wanted[0], wanted[1], FilterType::Triangle))
    });
    let ((width, height), rgba) = match shrunk.flatten() {
        Some(small) => ((small.width() as usize, small.height() as usize), Cow::Owned(small.into_raw())),
        None => (size, Cow::Borrowed(rgba)),
    };
    let (Ok(columns), Ok(rows)) = (u16::try_from(width), u16::try_from(height)) else { return };
    let pixels = rgba.chunks_exact(4).map(|p| PremulRgba8 { r: p[0], g: p[1], b: p[2], a: 255 }).collect();
    let pixmap = Pixmap::from_parts_with_opacity(pixels, columns, rows, false);
    let sampler = ImageSampler { quality: ImageQuality::Low, ..ImageSampler::default() };
    context.set_paint(Image { image: ImageSource::Pixmap(Arc::new(pixmap)), sampler });
    let [x, y, wide, high] = [rect.min[0], rect.min[1], rect.size[0], rect.size[1]].map(f64::from);
    let pixel = Affine::scale_non_uniform(wide / width as f64, high / height as f64);
    context.set_paint_transform(Affine::translate((x, y)) * pixel);
    context.fill_rect(&rect.rect());
    context.reset_paint_transform();
}

fn draw_way(context: &mut RenderContext, way: &BezPath, style: &Style) {
    let paint =
        |[r, g, b]: Colour, opacity: f32| AlphaColor::<Srgb>::from_rgb8(r, g, b).with_alpha(opacity.clamp(0.0, 1.0));
    if let Some((color, opacity)) = style.fill {
        context.set_paint(paint(color, opacity));
        context.fill_path(way);
    }
    if let Some(stroke) = style.stroke.filter(|stroke| stroke.width > 0.0) {
        let dashes: Vec<f64> = stroke.gaps().map(f64::from).collect();
        // Round ends would close the gaps between short dashes.
        let cap = if dashes.is_empty() { Cap::Round } else { Cap::Butt };
        context.set_stroke(Stroke::new(stroke.width.into()).with_caps(cap).with_dashes(0.0, dashes));
        context.set_paint(paint(stroke.color, stroke.opacity));
        context.stroke_path(way);
    }
}
