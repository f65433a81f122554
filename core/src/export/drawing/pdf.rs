//! Writes a figure as PDF 1.7, as journals ask for it: vectors, letters with their font in the file, greys as grey
//! images. `krilla` writes the file; this module maps the shapes of a drawing to it.

use super::font::{BOLD, font_of, overhang};
use super::shape::{Colour, Drawing, Face, FigureShape, FigureStroke, FigureUnit};
use crate::export::png::Bitmap;
use krilla::geom::{Path as Way, PathBuilder, Point, Size, Transform};
use krilla::image::{BitsPerComponent, CustomImage, Image, ImageColorspace};
use krilla::paint::{Fill, FillRule, LineCap, Stroke, StrokeDash};
use krilla::text::{Font, TextDirection};
use krilla::{color::rgb, metadata::Metadata, num::NormalizedF32, page::PageSettings, surface::Surface};
use std::{io, sync::Arc};
use vello_cpu::kurbo::{BezPath, PathEl, Shape};

/// Points in a pixel of a figure that is measured in pixels: 96 of them make an inch, as in SVG.
const POINTS_PER_PX: f32 = 0.75;
/// Largest error of the curves by which a circle is drawn.
const TOLERANCE: f64 = 0.01;

/// The drawing on a page of its own size.
pub(super) fn pdf(drawing: &Drawing) -> io::Result<Vec<u8>> {
    let points = if drawing.unit == FigureUnit::Point { 1.0 } else { POINTS_PER_PX };
    let [width, height] = drawing.size.map(|side| side * points);
    let page = PageSettings::from_wh(width, height).ok_or_else(|| io::Error::other("the figure has no size"))?;
    let mut document = krilla::Document::new();
    document.set_metadata(Metadata::new().title(drawing.title.clone()).creator("Burstscope".to_owned()));
    let mut page = document.start_page_with(page);
    let mut surface = page.surface();
    surface.push_transform(&Transform::from_scale(points, points));
    let font = |face| {
        let font = Font::new(font_of(face).to_vec().into(), 0);
        font.ok_or_else(|| io::Error::other("the program's font cannot be read"))
    };
    let fonts = [font(Face::Plain)?, font(Face::Mono)?];
    drawing.shapes.iter().for_each(|shape| draw(&mut surface, shape, &fonts));
    surface.pop();
    surface.finish();
    page.finish();
    document.finish().map_err(|error| io::Error::other(format!("{error:?}")))
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

fn draw(surface: &mut Surface<'_>, shape: &FigureShape, fonts: &[Font; 2]) {
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
        FigureShape::Text { at: [x, y], anchor, size, face, color, upwards, text } => {
            let bold = FigureStroke::new(*color, BOLD * size);
            surface.set_stroke((*face == Face::Bold).then(|| stroked(&bold)));
            surface.set_fill(Some(filled(*color, 1.0)));
            let [cos, sin] = if *upwards { [0.0, -1.0] } else { [1.0, 0.0] };
            surface.push_transform(&Transform::from_row(cos, sin, -sin, cos, *x, *y));
            let begin = Point::from_xy(-overhang(*face, *size, *anchor, text), 0.0);
            let font = fonts[usize::from(*face == Face::Mono)].clone();
            surface.draw_text(begin, font, *size, text, false, TextDirection::Auto);
            surface.pop();
        }
        FigureShape::Clipped { rect, shapes, .. } => {
            if let Some(clip) = way_of(&rect.rect().to_path(TOLERANCE)) {
                surface.push_clip_path(&clip, &FillRule::NonZero);
                shapes.iter().for_each(|shape| draw(surface, shape, fonts));
                surface.pop();
            }
        }
        FigureShape::Moved { by: [x, y], shapes } => {
            surface.push_transform(&Transform::from_translate(*x, *y));
            shapes.iter().for_each(|shape| draw(surface, shape, fonts));
            surface.pop();
        }
        _ => {
            let way = shape.way(TOLERANCE).and_then(|(way, style)| Some((way_of(&way)?, style)));
            let Some((way, style)) = way else { return };
            surface.set_fill(style.fill.map(|(color, opacity)| filled(color, opacity)));
            surface.set_stroke(style.stroke.filter(|stroke| stroke.width > 0.0).as_ref().map(stroked));
            surface.draw_path(&way);
        }
    }
}

fn filled(color: Colour, opacity: f32) -> Fill {
    Fill { paint: paint(color).into(), opacity: part(opacity), rule: FillRule::NonZero }
}

fn stroked(stroke: &FigureStroke) -> Stroke {
    let array: Vec<f32> = stroke.gaps().collect();
    Stroke {
        paint: paint(stroke.color).into(),
        width: stroke.width,
        // Round ends would close the gaps between short dashes.
        line_cap: if array.is_empty() { LineCap::Round } else { LineCap::Butt },
        opacity: part(stroke.opacity),
        dash: (!array.is_empty()).then_some(StrokeDash { array, offset: 0.0 }),
        ..Stroke::default()
    }
}

fn paint([r, g, b]: Colour) -> rgb::Color {
    rgb::Color::new(r, g, b)
}

fn part(value: f32) -> NormalizedF32 {
    NormalizedF32::new(value.clamp(0.0, 1.0)).unwrap_or(NormalizedF32::ONE)
}

fn way_of(path: &BezPath) -> Option<Way> {
    let mut way = PathBuilder::new();
    for element in path.elements() {
        let [a, b, c] = match *element {
            PathEl::MoveTo(a) | PathEl::LineTo(a) => [a; 3],
            PathEl::QuadTo(a, b) => [a, b, b],
            PathEl::CurveTo(a, b, c) => [a, b, c],
            PathEl::ClosePath => Default::default(),
        }
        .map(|point| (point.x as f32, point.y as f32));
        match element {
            PathEl::MoveTo(_) => way.move_to(a.0, a.1),
            PathEl::LineTo(_) => way.line_to(a.0, a.1),
            PathEl::QuadTo(..) => way.quad_to(a.0, a.1, b.0, b.1),
            PathEl::CurveTo(..) => way.cubic_to(a.0, a.1, b.0, b.1, c.0, c.1),
            PathEl::ClosePath => way.close(),
        }
    }
    way.finish()
}
