//! Drawings as SVG 1.1.

use super::{Colour, DASH, Drawing, FigureRect, FigureShape, FigureStroke, FigureUnit};
use crate::error::Result;
use crate::export::atomic::write_marked;
use crate::export::png::Bitmap;
use crate::export::svg::{Attribute, Number, PathData, SvgWriter, rectangle};
use crate::files::mark::OutputKind;
use std::io::{self, Write};
use std::path::Path;

/// Writes the drawing with its pictures inside; fails where PNG cannot hold one, or the file cannot be written.
pub fn write_drawing_svg(path: &Path, drawing: &Drawing) -> Result<()> {
    // Checked first: while the file is written, a failure is reported as one of writing.
    for shape in &drawing.shapes {
        if let FigureShape::Picture { size, rgba, .. } = shape {
            Bitmap::rgba(size.0, size.1, rgba).check_size(path)?;
        }
    }
    write_marked(path, OutputKind::Drawing, |out| {
        writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
        let unit = if drawing.unit == FigureUnit::Point { "pt" } else { "" };
        let size = (f64::from(drawing.size[0]), f64::from(drawing.size[1]), unit);
        let mut svg = SvgWriter::document(out, size, &drawing.title, &[])?;
        drawing.shapes.iter().try_for_each(|shape| write_shape(&mut svg, shape))?;
        svg.finish().map(drop)
    })
}

fn write_shape(svg: &mut SvgWriter<impl Write>, shape: &FigureShape) -> io::Result<()> {
    match shape {
        FigureShape::Picture { rect, size, rgba } => {
            // Small pixels are blended by the reader; squares are shown where they can be seen.
            let sharp = rect.size[0] >= size.0 as f32;
            svg.picture(&rectangle(&place(rect)), &Bitmap::rgba(size.0, size.1, rgba), sharp)
        }
        FigureShape::Fill { rect, color } => {
            let fill: [Attribute<'_>; 1] = [("fill", &Hex(*color))];
            svg.empty("rect", &[&rectangle(&place(rect))[..], &fill].concat(), "")
        }
        FigureShape::Circle { centre, radius, stroke, dashed } => {
            let [x, y, r] = [centre[0], centre[1], *radius].map(number);
            // Eight dashes and eight gaps fit around, so that no seam is seen.
            let dashes = dashes(*dashed, std::f32::consts::TAU * radius / 16.0);
            let style = format!(r#"fill="none" {dashes}{}"#, Stroke(stroke));
            svg.empty("circle", &[("cx", &x), ("cy", &y), ("r", &r)], &style)
        }
        FigureShape::Line { points, stroke, dashed, class } => {
            let points: Vec<_> = points.iter().map(|point| Some(point.map(f64::from))).collect();
            let style = format!(r#"fill="none" {}{}"#, dashes(*dashed, DASH * stroke.width), Stroke(stroke));
            svg.empty("path", &[("class", class), ("d", &PathData(&points))], &style)
        }
        FigureShape::Fan { points, color, opacity } => {
            let points: Vec<_> = points.iter().map(|point| Some(point.map(f64::from))).collect();
            let style = format!(r#"fill="{}" fill-opacity="{}""#, Hex(*color), number(*opacity));
            svg.empty("path", &[("class", &"fan"), ("d", &PathData(&points))], &style)
        }
        FigureShape::Text { at, size, text, color } => {
            let [x, y, size] = [at[0], at[1], *size].map(number);
            let font: [Attribute<'_>; 5] =
                [("x", &x), ("y", &y), ("font-family", &"sans-serif"), ("font-size", &size), ("fill", &Hex(*color))];
            svg.text("text", &font, "", text)
        }
        FigureShape::Clipped { rect, shapes } => {
            svg.begin_clipped(&rectangle(&place(rect)), &[("stroke-linecap", &"round")])?;
            shapes.iter().try_for_each(|shape| write_shape(svg, shape))?;
            svg.end("g")
        }
    }
}

fn dashes(dashed: bool, length: f32) -> String {
    let length = number(length);
    if dashed { format!(r#"stroke-dasharray="{length} {length}" "#) } else { String::new() }
}

fn number(value: f32) -> Number {
    Number(f64::from(value))
}

fn place(rect: &FigureRect) -> [Number; 4] {
    [rect.min[0], rect.min[1], rect.size[0], rect.size[1]].map(number)
}

struct Stroke<'a>(&'a FigureStroke);

impl std::fmt::Display for Stroke<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, r#"stroke="{}" stroke-width="{}""#, Hex(self.0.color), number(self.0.width))?;
        if self.0.opacity < 1.0 { write!(f, r#" stroke-opacity="{}""#, number(self.0.opacity)) } else { Ok(()) }
    }
}

struct Hex(Colour);

impl std::fmt::Display for Hex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}
