//! Drawings as SVG 1.1.

use super::{Colour, Drawing, FigureRect, FigureShape, FigureStroke};
use crate::export::atomic::write_whole;
use crate::export::base64::write_base64;
use crate::export::error::ExportError;
use crate::export::mark::SVG_COMMENT;
use crate::export::png::Picture;
use crate::export::sheet::escaped;
use std::io::{self, Write};
use std::path::Path;

/// Writes the drawing.
///
/// # Errors
/// [`ExportError`] when a picture has no pixels or the file cannot be written; an older one is then unchanged.
pub fn write_drawing_svg(path: &Path, drawing: &Drawing) -> Result<(), ExportError> {
    for shape in &drawing.shapes {
        if let FigureShape::Picture { size, rgba, .. } = shape {
            Picture::rgba(size.0, size.1, rgba).check_size(path)?;
        }
    }
    write_whole(path, |out| {
        let [width, height] = drawing.size.map(Number);
        writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
        writeln!(
            out,
            r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" version="1.1" width="{width}" height="{height}" viewBox="0 0 {width} {height}">"#
        )?;
        writeln!(out, "{SVG_COMMENT}")?;
        writeln!(out, "<title>{}</title>", escaped(&drawing.title))?;
        let mut clips = 0;
        for shape in &drawing.shapes {
            write_shape(out, shape, &mut clips)?;
        }
        writeln!(out, "</svg>")
    })
}

fn write_shape(out: &mut impl Write, shape: &FigureShape, clips: &mut usize) -> io::Result<()> {
    match shape {
        FigureShape::Picture { rect, size, rgba } => {
            let mut png = Vec::new();
            Picture::rgba(size.0, size.1, rgba).encode_png(&mut png)?;
            // Pixels stay sharp when magnified. `xlink:href` is understood by all current readers.
            write!(out, "<image {} ", Place(rect))?;
            write!(
                out,
                r#"preserveAspectRatio="none" style="image-rendering:pixelated" xlink:href="data:image/png;base64,"#
            )?;
            write_base64(&png, &mut *out)?;
            writeln!(out, r#""/>"#)
        }
        FigureShape::Fill { rect, color } => writeln!(out, r#"<rect {} fill="{}"/>"#, Place(rect), Hex(*color)),
        FigureShape::Circle { centre, radius, stroke, dashed } => {
            let dash = if *dashed {
                let piece = Number(std::f32::consts::TAU * radius / 16.0);
                format!(r#" stroke-dasharray="{piece} {piece}""#)
            } else {
                String::new()
            };
            let (x, y, r) = (Number(centre[0]), Number(centre[1]), Number(*radius));
            writeln!(out, r#"<circle cx="{x}" cy="{y}" r="{r}" fill="none"{dash}{}/>"#, Stroke(stroke))
        }
        FigureShape::Line { points, stroke, class } => {
            write!(out, r#"<path class="{class}" fill="none" d=""#)?;
            for (i, [x, y]) in points.iter().enumerate() {
                write!(out, "{}{} {}", if i == 0 { 'M' } else { 'L' }, Number(*x), Number(*y))?;
            }
            writeln!(out, r#""{}/>"#, Stroke(stroke))
        }
        FigureShape::Text { at, size, text, color } => writeln!(
            out,
            r#"<text x="{}" y="{}" font-family="sans-serif" font-size="{}" fill="{}">{}</text>"#,
            Number(at[0]),
            Number(at[1]),
            Number(*size),
            Hex(*color),
            escaped(text)
        ),
        FigureShape::Clipped { rect, shapes } => {
            *clips += 1;
            let id = format!("clip{clips}");
            writeln!(out, r#"<clipPath id="{id}"><rect {}/></clipPath>"#, Place(rect))?;
            writeln!(out, r#"<g clip-path="url(#{id})" stroke-linecap="round">"#)?;
            for shape in shapes {
                write_shape(out, shape, clips)?;
            }
            writeln!(out, "</g>")
        }
    }
}

/// A rectangle as SVG attributes.
struct Place<'a>(&'a FigureRect);

impl std::fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y] = self.0.min.map(Number);
        let [width, height] = self.0.size.map(Number);
        write!(f, r#"x="{x}" y="{y}" width="{width}" height="{height}""#)
    }
}

/// A stroke as SVG attributes.
struct Stroke<'a>(&'a FigureStroke);

impl std::fmt::Display for Stroke<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, r#" stroke="{}" stroke-width="{}""#, Hex(self.0.color), Number(self.0.width))?;
        if self.0.opacity < 1.0 { write!(f, r#" stroke-opacity="{}""#, Number(self.0.opacity)) } else { Ok(()) }
    }
}

/// A number in an SVG: a thousandth of a pixel is precise enough, and keeps files small.
struct Number(f32);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = format!("{:.3}", self.0);
        let short = text.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if short == "-0" { "0" } else { short })
    }
}

/// A colour as `#rrggbb`.
struct Hex(Colour);

impl std::fmt::Display for Hex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_colours_are_short() {
        let cases = [(1.0, "1"), (-0.00001, "0"), (2.5, "2.5"), (100.0, "100"), (1.0 / 3.0, "0.333")];
        for (number, text) in cases {
            assert_eq!(Number(number).to_string(), text);
        }
        assert_eq!(Hex([0, 171, 255]).to_string(), "#00abff");
    }
}
