//! Writes a figure as PDF 1.7, as journals ask for it: vectors, letters with their font in the file, greys as grey
//! images. `krilla` writes the file; this module maps the shapes of a drawing to it.

use crate::error::Error;
use crate::export::{Bitmap, Colour, DASH, Drawing, FigureRect, FigureShape, FigureStroke, FigureUnit, write_marked};
use crate::files::mark::OutputKind;
use egui::{FontDefinitions, FontFamily};
use krilla::color::rgb;
use krilla::geom::{Path as Way, PathBuilder, Point, Rect, Size, Transform};
use krilla::image::{BitsPerComponent, CustomImage, Image, ImageColorspace};
use krilla::metadata::Metadata;
use krilla::num::NormalizedF32;
use krilla::page::PageSettings;
use krilla::paint::{Fill, FillRule, LineCap, Stroke, StrokeDash};
use krilla::surface::Surface;
use krilla::text::{Font, TextDirection};
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

/// Points in a pixel of a figure that is measured in pixels: 96 of them make an inch, as in SVG.
const POINTS_PER_PX: f32 = 0.75;
/// Distance of the control points of a quarter of a circle from its ends, as a part of the radius.
const QUARTER: f32 = 0.552_284_8;

/// Writes the drawing on a page of its own size.
pub fn write_drawing_pdf(path: &Path, drawing: &Drawing) -> Result<(), Error> {
    write_marked(path, OutputKind::Drawing, |out| out.write_all(&encoded(drawing)?))
}

fn encoded(drawing: &Drawing) -> io::Result<Vec<u8>> {
    let points = if drawing.unit == FigureUnit::Point { 1.0 } else { POINTS_PER_PX };
    let [width, height] = drawing.size.map(|side| side * points);
    let page = PageSettings::from_wh(width, height).ok_or_else(|| io::Error::other("the figure has no size"))?;
    let mut document = krilla::Document::new();
    document.set_metadata(Metadata::new().title(drawing.title.clone()).creator("Burstscope".to_owned()));
    let mut page = document.start_page_with(page);
    let mut surface = page.surface();
    surface.push_transform(&Transform::from_scale(points, points));
    let font = font().ok_or_else(|| io::Error::other("the program's font cannot be read"))?;
    drawing.shapes.iter().for_each(|shape| draw(&mut surface, shape, &font));
    surface.pop();
    surface.finish();
    page.finish();
    document.finish().map_err(|error| io::Error::other(format!("{error:?}")))
}

/// The font of the window's texts.
fn font() -> Option<Font> {
    let mut fonts = FontDefinitions::default();
    let name = fonts.families.get(&FontFamily::Proportional)?.first()?.clone();
    let data = Arc::unwrap_or_clone(fonts.font_data.remove(&name)?);
    Font::new(data.font.into(), data.index)
}

/// Pixels of a picture, in grey where all are.
#[derive(Clone, Hash)]
struct Pixels {
    size: (usize, usize),
    space: ImageColorspace,
    values: Arc<Vec<u8>>,
}

impl Pixels {
    fn of(size: (usize, usize), rgba: &[u8]) -> Self {
        let (space, values) = match Bitmap::rgba(size.0, size.1, rgba).greys() {
            Some(greys) => (ImageColorspace::Luma, greys),
            None => (ImageColorspace::Rgb, rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect()),
        };
        Self { size, space, values: Arc::new(values) }
    }
}

impl CustomImage for Pixels {
    fn color_channel(&self) -> &[u8] {
        &self.values
    }

    fn alpha_channel(&self) -> Option<&[u8]> {
        None
    }

    fn bits_per_component(&self) -> BitsPerComponent {
        BitsPerComponent::Eight
    }

    fn size(&self) -> (u32, u32) {
        (self.size.0 as u32, self.size.1 as u32)
    }

    fn icc_profile(&self) -> Option<&[u8]> {
        None
    }

    fn color_space(&self) -> ImageColorspace {
        self.space
    }
}

fn draw(surface: &mut Surface<'_>, shape: &FigureShape, font: &Font) {
    match shape {
        FigureShape::Picture { rect, size, rgba } => {
            // Small pixels are blended by the reader; squares are shown where they can be seen.
            let blended = rect.size[0] < size.0 as f32;
            let place = Size::from_wh(rect.size[0], rect.size[1]);
            if let (Some(place), Ok(image)) = (place, Image::from_custom(Pixels::of(*size, rgba), blended)) {
                surface.push_transform(&Transform::from_translate(rect.min[0], rect.min[1]));
                surface.draw_image(image, place);
                surface.pop();
            }
        }
        FigureShape::Fill { rect, color } => fill(surface, way_of(rect), *color, 1.0),
        FigureShape::Circle { centre, radius, stroke, dashed } => {
            line(surface, circle(*centre, *radius), stroke, dashed.then_some(std::f32::consts::TAU * radius / 16.0));
        }
        FigureShape::Line { points, stroke, dashed, .. } => {
            line(surface, through(points, false), stroke, dashed.then_some(DASH * stroke.width));
        }
        FigureShape::Fan { points, color, opacity } => fill(surface, through(points, true), *color, *opacity),
        FigureShape::Text { at, size, text, color } => {
            surface.set_stroke(None);
            surface.set_fill(Some(filled(*color, 1.0)));
            let at = Point::from_xy(at[0], at[1]);
            surface.draw_text(at, font.clone(), *size, text, false, TextDirection::Auto);
        }
        FigureShape::Clipped { rect, shapes } => {
            if let Some(clip) = way_of(rect) {
                surface.push_clip_path(&clip, &FillRule::NonZero);
                shapes.iter().for_each(|shape| draw(surface, shape, font));
                surface.pop();
            }
        }
    }
}

fn filled(color: Colour, opacity: f32) -> Fill {
    Fill { paint: paint(color).into(), opacity: part(opacity), rule: FillRule::NonZero }
}

fn paint([r, g, b]: Colour) -> rgb::Color {
    rgb::Color::new(r, g, b)
}

fn part(value: f32) -> NormalizedF32 {
    NormalizedF32::new(value.clamp(0.0, 1.0)).unwrap_or(NormalizedF32::ONE)
}

fn fill(surface: &mut Surface<'_>, way: Option<Way>, color: Colour, opacity: f32) {
    let Some(way) = way else { return };
    surface.set_stroke(None);
    surface.set_fill(Some(filled(color, opacity)));
    surface.draw_path(&way);
}

/// Draws a line with dashes and gaps of length `dash`, if there are any.
fn line(surface: &mut Surface<'_>, way: Option<Way>, stroke: &FigureStroke, dash: Option<f32>) {
    let Some(way) = way else { return };
    surface.set_fill(None);
    surface.set_stroke(Some(Stroke {
        paint: paint(stroke.color).into(),
        width: stroke.width,
        // Round ends would close the gaps between short dashes.
        line_cap: if dash.is_some() { LineCap::Butt } else { LineCap::Round },
        opacity: part(stroke.opacity),
        dash: dash.filter(|dash| *dash > 0.0).map(|dash| StrokeDash { array: vec![dash; 2], offset: 0.0 }),
        ..Stroke::default()
    }));
    surface.draw_path(&way);
}

fn way_of(rect: &FigureRect) -> Option<Way> {
    let mut way = PathBuilder::new();
    way.push_rect(Rect::from_xywh(rect.min[0], rect.min[1], rect.size[0], rect.size[1])?);
    way.finish()
}

fn through(points: &[[f32; 2]], closed: bool) -> Option<Way> {
    let (first, rest) = points.split_first()?;
    let mut way = PathBuilder::new();
    way.move_to(first[0], first[1]);
    rest.iter().for_each(|point| way.line_to(point[0], point[1]));
    if closed {
        way.close();
    }
    way.finish()
}

fn circle([x, y]: [f32; 2], radius: f32) -> Option<Way> {
    let mut way = PathBuilder::new();
    way.move_to(x + radius, y);
    // Each quarter from the axis (cos, sin) to the next one.
    for [cos, sin] in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0f32]] {
        let at = |along: f32, across: f32| {
            [x + radius * (along * cos - across * sin), y + radius * (along * sin + across * cos)]
        };
        let ([ax, ay], [bx, by], [cx, cy]) = (at(1.0, QUARTER), at(QUARTER, 1.0), at(0.0, 1.0));
        way.cubic_to(ax, ay, bx, by, cx, cy);
    }
    way.close();
    way.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::mark::has_mark;

    #[test]
    fn a_page_has_the_size_of_the_figure_its_texts_and_a_grey_picture() {
        let home = tempfile::tempdir().expect("a folder");
        let rect = FigureRect { min: [10.0, 10.0], size: [40.0, 30.0] };
        let rgba = Arc::new([[9, 9, 9, 255], [200, 200, 200, 255]].concat());
        let stroke = FigureStroke { width: 0.75, color: [213, 94, 0], opacity: 0.7 };
        let over = vec![
            FigureShape::Circle { centre: [30.0, 20.0], radius: 5.0, stroke, dashed: true },
            FigureShape::Line { points: vec![[0.0, 0.0], [40.0, 30.0]], stroke, dashed: true, class: "match" },
            FigureShape::Fan { points: vec![[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]], color: [1, 2, 3], opacity: 0.2 },
            // Nothing is drawn of what has no size.
            FigureShape::Circle { centre: [30.0, 20.0], radius: 0.0, stroke, dashed: false },
            FigureShape::Line { points: Vec::new(), stroke, dashed: false, class: "match" },
        ];
        let shapes = vec![
            FigureShape::Picture { rect, size: (2, 1), rgba },
            FigureShape::Clipped { rect, shapes: over },
            FigureShape::Text { at: [10.0, 50.0], size: 8.0, text: "σ − × ·".into(), color: [0; 3] },
        ];
        for (unit, media) in [(FigureUnit::Point, "[0 0 88 60]"), (FigureUnit::Pixel, "[0 0 66 45]")] {
            let path = home.path().join(format!("{}.pdf", media.len()));
            let drawing = Drawing { size: [88.0, 60.0], unit, shapes: shapes.clone(), title: "A title".into() };
            write_drawing_pdf(&path, &drawing).expect("written");
            let bytes = std::fs::read(&path).expect("read");
            let says = |text: &str| bytes.windows(text.len()).any(|part| part == text.as_bytes());
            assert!(bytes.starts_with(b"%PDF-1.7") && says("%%EOF") && has_mark(&path, true));
            assert!(says(media) && says("/DeviceGray") && says("Ubuntu") && says("/Font"), "{media}");
        }
    }
}
