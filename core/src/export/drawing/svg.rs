//! Drawings as SVG 1.1: elements, one a line, escaped text, short numbers, pictures inside.

use super::shape::{Anchor, CURVE, Colour, Drawing, Face, FigureRect, FigureShape, FigureUnit, SOLID, Style};
use super::sheet::INK;
use crate::export::png::Bitmap;
use base64::display::Base64Display;
use base64::engine::general_purpose::STANDARD;
use std::fmt::{self, Display, Write as _};
use std::io::{self, Write};

impl Drawing {
    /// The drawing as a self-contained SVG document.
    ///
    /// # Panics
    /// A picture has no pixels.
    pub fn svg(&self) -> String {
        let mut svg = Vec::new();
        write_svg(&mut svg, self).expect("pictures with pixels are encoded in memory");
        String::from_utf8(svg).expect("all that is written is text")
    }
}

/// Writes the document; fails where PNG cannot hold one of its pictures, and where `out` does.
pub(super) fn write_svg(mut out: impl Write, drawing: &Drawing) -> io::Result<()> {
    let unit = if drawing.unit == FigureUnit::Point { "pt" } else { "" };
    let [width, height] = drawing.size.map(number);
    write!(out, r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" version="1.1""#)?;
    write!(out, r#" width="{width}{unit}" height="{height}{unit}" viewBox="0 0 {width} {height}""#)?;
    let fonts = "Helvetica, Arial, 'DejaVu Sans', sans-serif";
    writeln!(out, r#" font-family="{fonts}" font-size="12" fill="{}">"#, hex(INK))?;
    // Screen readers read it.
    writeln!(out, "<title>{}</title>", Escaped(&drawing.title))?;
    write_shapes(&mut out, &mut 0, &drawing.shapes)?;
    writeln!(out, "</svg>")
}

/// `clips` counts the rectangles to which shapes are clipped.
fn write_shapes(out: &mut impl Write, clips: &mut usize, shapes: &[FigureShape]) -> io::Result<()> {
    shapes.iter().try_for_each(|shape| match shape {
        FigureShape::Picture { rect, size, rgba } => {
            // Small pixels are blended by the reader; squares are shown where they can be seen.
            let rendering = if rect.size[0] >= size.0 as f32 { "pixelated" } else { "auto" };
            let mut png = Vec::new();
            Bitmap::rgba(size.0, size.1, rgba).encode_png(&mut png)?;
            write!(out, r#"<image {rect} preserveAspectRatio="none" style="image-rendering:{rendering}""#)?;
            // `xlink:href` is understood by all current readers.
            writeln!(out, r#" xlink:href="data:image/png;base64,{}"/>"#, Base64Display::new(&png, &STANDARD))
        }
        FigureShape::Rect { rect, style } => writeln!(out, "<rect {rect} {style}/>"),
        FigureShape::Circle { centre: [x, y], radius, style } => {
            writeln!(out, r#"<circle cx="{}" cy="{}" r="{}" {style}/>"#, number(*x), number(*y), number(*radius))
        }
        FigureShape::Line { points, style, class: CURVE } => {
            writeln!(out, r#"<path d="{}" {style} stroke-linejoin="round"/>"#, path_data(points))
        }
        FigureShape::Line { points, style, class } => match points[..] {
            [Some([x1, y1]), Some([x2, y2])] if class.is_empty() => {
                let [x1, y1, x2, y2] = [x1, y1, x2, y2].map(number);
                let style = style.to_string();
                let style = style.trim_start_matches(r#"fill="none" "#);
                writeln!(out, r#"<line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}" {style}/>"#)
            }
            _ => writeln!(out, r#"<path class="{class}" d="{}" {style}/>"#, path_data(points)),
        },
        FigureShape::Text { at: [x, y], anchor, size, face, color, upwards, text } => {
            let (x, y, size) = (number(*x), number(*y), number(*size));
            match upwards {
                true => write!(out, r#"<text transform="translate({x} {y}) rotate(-90)""#)?,
                false => write!(out, r#"<text x="{x}" y="{y}""#)?,
            }
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let face = match face {
                Face::Plain => "",
                Face::Bold => r#" font-weight="bold""#,
                Face::Mono => r#" font-family="monospace""#,
            };
            // The whole document has the colour of ink.
            let colour = if *color == INK { String::new() } else { format!(r#" fill="{}""#, hex(*color)) };
            writeln!(out, r#" font-size="{size}" text-anchor="{anchor}"{face}{colour}>{}</text>"#, Escaped(text))
        }
        FigureShape::Clipped { rect, round, shapes } => {
            *clips += 1;
            writeln!(out, "<clipPath id=\"clip{clips}\">\n<rect {rect}/>\n</clipPath>")?;
            let ends = if *round { r#" stroke-linecap="round""# } else { "" };
            writeln!(out, r#"<g clip-path="url(#clip{clips})"{ends}>"#)?;
            write_shapes(out, clips, shapes)?;
            writeln!(out, "</g>")
        }
        FigureShape::Moved { by: [x, y], shapes } => {
            writeln!(out, r#"<g transform="translate({} {})">"#, number(*x), number(*y))?;
            write_shapes(out, clips, shapes)?;
            writeln!(out, "</g>")
        }
    })
}

impl Display for FigureRect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([x, y], [width, height]) = (self.min.map(number), self.size.map(number));
        write!(f, r#"x="{x}" y="{y}" width="{width}" height="{height}""#)
    }
}

impl Display for Style {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.fill {
            None => write!(f, r#"fill="none""#)?,
            Some((color, opacity)) if opacity < 1.0 => {
                write!(f, r#"fill="{}" fill-opacity="{}""#, hex(color), number(opacity))?;
            }
            Some((color, _)) => write!(f, r#"fill="{}""#, hex(color))?,
        }
        let Some(stroke) = self.stroke else { return Ok(()) };
        write!(f, r#" stroke="{}""#, hex(stroke.color))?;
        if stroke.width != 1.0 {
            write!(f, r#" stroke-width="{}""#, number(stroke.width))?;
        }
        if stroke.dashes != SOLID {
            let lengths: Vec<String> = stroke.gaps().map(number).collect();
            write!(f, r#" stroke-dasharray="{}""#, lengths.join(" "))?;
        }
        if stroke.opacity < 1.0 { write!(f, r#" stroke-opacity="{}""#, number(stroke.opacity)) } else { Ok(()) }
    }
}

fn hex([r, g, b]: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Number in an SVG: a thousandth of a pixel is precise enough, and keeps files small.
fn number(number: f32) -> String {
    let text = format!("{:.3}", f64::from(number));
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0" } else { short }.to_owned()
}

/// Points joined by lines, as the data of a path; a `None` is a break.
fn path_data(points: &[Option<[f32; 2]>]) -> String {
    let (mut data, mut command) = (String::new(), 'M');
    for point in points {
        command = match point {
            Some([x, y]) => {
                data += &format!("{command}{} {}", number(*x), number(*y));
                'L'
            }
            None => 'M',
        };
    }
    data
}

/// Text escaped for XML and HTML. Characters that XML 1.0 does not allow are replaced by U+FFFD.
pub struct Escaped<T>(pub T);

impl<T: Display> Display for Escaped<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.to_string().chars().try_for_each(|c| match c {
            '&' => f.write_str("&amp;"),
            '<' => f.write_str("&lt;"),
            '>' => f.write_str("&gt;"),
            '"' => f.write_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => f.write_char('\u{fffd}'),
            c if c.is_control() && !matches!(c, '\t' | '\n' | '\r') => f.write_char('\u{fffd}'),
            c => f.write_char(c),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_text_is_escaped() {
        let cases = [(1.0, "1"), (-0.00001, "0"), (2.5, "2.5"), (100.0, "100"), (1.0 / 3.0, "0.333")];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
        let points = [Some([0.0, 1.0]), None, Some([2.0, 3.0]), Some([4.0, 5.25])];
        assert_eq!(path_data(&points), "M0 1M2 3L4 5.25");
        assert_eq!(Escaped("a<b & \"c\"\u{1}").to_string(), "a&lt;b &amp; &quot;c&quot;\u{fffd}");
    }
}
