//! The sheet on which a figure is drawn: lines, text, pictures, and axes with round ticks.

use super::png::Bitmap;
use super::svg::{Attribute, Number, PathData, SvgWriter, rectangle};
use crate::plane::Plane;
use crate::plane::display::Display;

/// Colour of letters and axes.
pub const INK: &str = "#24292f";
/// Colour of less important parts.
pub const FAINT: &str = "#8c959f";
/// Colour of lines behind curves.
pub const GRID: &str = "#e4e8ec";
/// Okabe and Ito's blue; [`RED`] and [`GREEN`] are of the same palette, which colour-blind readers can tell apart.
pub const BLUE: &str = "#0072b2";
/// Okabe and Ito's vermilion.
pub const RED: &str = "#d55e00";
/// Okabe and Ito's green, darker.
pub const GREEN: &str = "#007a58";
/// Approximate width of a letter over the size of the font.
const LETTER: f64 = 0.52;

/// A rectangle of the sheet, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Left side.
    pub x: f64,
    /// Upper side.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

impl Area {
    /// Right side.
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    /// Lower side.
    pub fn bottom(&self) -> f64 {
        self.y + self.height
    }

    fn numbers(&self) -> [Number; 4] {
        [self.x, self.y, self.width, self.height].map(Number)
    }
}

/// Alignment of a text to its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// The text's middle is there.
    Middle,
    /// The text ends there.
    End,
}

/// SVG document under construction. Lengths are pixels.
#[derive(Debug)]
pub struct Sheet {
    body: SvgWriter<Vec<u8>>,
    width: f64,
    title: String,
}

const IN_MEMORY: &str = "memory can be written";

impl Sheet {
    /// Creates an empty sheet; screen readers use `title`.
    pub fn new(width: f64, title: &str) -> Self {
        Self { body: SvgWriter::part(Vec::new()), width: width.round(), title: title.to_owned() }
    }

    /// Finishes the document, `height` high.
    pub fn finish(self, height: f64) -> String {
        let body = String::from_utf8(self.body.into_inner()).expect("all that is written is text");
        let font: [Attribute<'_>; 3] =
            [("font-family", &"Helvetica, Arial, 'DejaVu Sans', sans-serif"), ("font-size", &12), ("fill", &INK)];
        // The height is known last, so the document begins after its body is drawn.
        let whole = || {
            let mut svg = SvgWriter::document(Vec::new(), (self.width, height.round(), ""), &self.title, &font)?;
            svg.empty("rect", &[("width", &"100%"), ("height", &"100%"), ("fill", &"#ffffff")], "")?;
            svg.raw(body.trim_end())?;
            svg.finish()
        };
        String::from_utf8(whole().expect(IN_MEMORY)).expect("all that is written is text")
    }

    /// Draws a line of text of `size` pixels.
    pub fn text(&mut self, (x, y): (f64, f64), size: f64, anchor: Anchor, text: &str) {
        self.styled_text((x, y), size, anchor, "", text);
    }

    /// Draws a line of text with more attributes, such as a colour.
    pub fn styled_text(&mut self, (x, y): (f64, f64), size: f64, anchor: Anchor, style: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let place: [Attribute<'_>; 4] =
            [("x", &Number(x)), ("y", &Number(y)), ("font-size", &Number(size)), ("text-anchor", &anchor)];
        self.body.text("text", &place, style, text).expect(IN_MEMORY);
    }

    /// Draws text in lines of at most `width` pixels; returns the position of the next line.
    pub fn paragraph(&mut self, (x, y): (f64, f64), size: f64, width: f64, text: &str) -> f64 {
        // Fonts differ from system to system, so that widths can only be estimated.
        let letters = (width / (LETTER * size)).max(8.0) as usize;
        let (mut line, mut y) = (String::new(), y);
        for word in text.split_whitespace() {
            if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > letters {
                self.text((x, y), size, Anchor::Start, &line);
                line.clear();
                y += 1.35 * size;
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
        self.text((x, y), size, Anchor::Start, &line);
        y + 1.35 * size
    }

    /// Draws a straight line.
    pub fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64), colour: &str, style: &str) {
        let [x1, y1, x2, y2] = [x1, y1, x2, y2].map(Number);
        let ends: [Attribute<'_>; 5] = [("x1", &x1), ("y1", &y1), ("x2", &x2), ("y2", &y2), ("stroke", &colour)];
        self.body.empty("line", &ends, style).expect(IN_MEMORY);
    }

    /// Draws a rectangle, filled and outlined by `style`.
    pub fn rectangle(&mut self, area: Area, style: &str) {
        self.body.empty("rect", &rectangle(&area.numbers()), style).expect(IN_MEMORY);
    }

    /// Draws a circle, filled and outlined by `style`.
    pub fn circle(&mut self, (x, y): (f64, f64), radius: f64, style: &str) {
        let place: [Attribute<'_>; 3] = [("cx", &Number(x)), ("cy", &Number(y)), ("r", &Number(radius))];
        self.body.empty("circle", &place, style).expect(IN_MEMORY);
    }

    /// Draws a line through points, with breaks where a point is `None`.
    pub fn polyline(&mut self, points: impl IntoIterator<Item = Option<(f64, f64)>>, style: &str) {
        let points: Vec<_> = points.into_iter().map(|point| point.map(|(x, y)| [x, y])).collect();
        self.body.empty("path", &[("d", &PathData(&points)), ("fill", &"none")], style).expect(IN_MEMORY);
    }

    /// Draws a plane as a picture that fills `area`; pixels stay sharp.
    pub fn picture(&mut self, area: Area, plane: &Plane, display: &Display) {
        let colours = display.colours();
        let pixels: Vec<u8> = plane.data().iter().flat_map(|&x| colours.colour(x)).collect();
        let picture = Bitmap::rgb(plane.width(), plane.height(), &pixels);
        self.body
            .picture(&rectangle(&area.numbers()), &picture, true)
            .expect("a picture with pixels is encoded in memory");
    }

    /// Draws the shapes of `draw`, clipped to `area`.
    pub fn clipped(&mut self, area: Area, draw: impl FnOnce(&mut Self)) {
        self.body.begin_clipped(&rectangle(&area.numbers()), &[]).expect(IN_MEMORY);
        draw(self);
        self.body.end("g").expect(IN_MEMORY);
    }

    /// Draws ticks and labels under an area, for values from `range.0` at its left to `range.1` at its right.
    pub fn axis_below(&mut self, area: Area, range: (f64, f64), label: &str) {
        for tick in ticks(range) {
            let x = area.x + (tick - range.0) / (range.1 - range.0) * area.width;
            self.line((x, area.bottom()), (x, area.bottom() + 4.0), INK, "");
            self.text((x, area.bottom() + 16.0), 11.0, Anchor::Middle, &short(tick));
        }
        self.text((area.x + 0.5 * area.width, area.bottom() + 32.0), 12.0, Anchor::Middle, label);
    }

    /// Draws ticks and labels left of an area, for values from `range.0` at its bottom to `range.1` at its top.
    pub fn axis_left(&mut self, area: Area, range: (f64, f64), label: &str) {
        for tick in ticks(range) {
            let y = area.bottom() - (tick - range.0) / (range.1 - range.0) * area.height;
            self.line((area.x - 4.0, y), (area.x, y), INK, "");
            self.text((area.x - 7.0, y + 4.0), 11.0, Anchor::End, &short(tick));
        }
        self.label_left(area, label);
    }

    /// Draws the label of a vertical axis.
    pub fn label_left(&mut self, area: Area, label: &str) {
        let (x, y) = (Number(area.x - 44.0), Number(area.y + 0.5 * area.height));
        let turned = format!("translate({x} {y}) rotate(-90)");
        self.body.text("text", &[("transform", &turned), ("text-anchor", &"middle")], "", label).expect(IN_MEMORY);
    }
}

/// Round numbers within a range, about five of them.
pub fn ticks((min, max): (f64, f64)) -> Vec<f64> {
    let rough = (max - min) / 5.0;
    if !(rough > 0.0 && rough.is_finite()) {
        return vec![min];
    }
    let magnitude = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|s| s * magnitude).into_iter().find(|s| *s >= rough).unwrap_or(rough);
    // Multiples of a whole number, not sums: 0.1 added ten times is not 1. At most 12, whatever the rounding.
    let first = (min / step).ceil() as i64;
    (first..).map(|i| i as f64 * step).take_while(|tick| *tick <= max + 1e-9 * step).take(12).collect()
}

/// The number at a tick, as text.
pub fn short(x: f64) -> String {
    let text = if x != 0.0 && x.abs() < 1e-3 { format!("{x:.0e}") } else { format!("{x:.4}") };
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.replace('-', "−") }
}

/// Stacks documents of this module under one another, as one.
pub fn stacked(title: &str, documents: &[String]) -> String {
    let length = |document: &str, name: &str| -> f64 {
        let start = document.find(&format!(" {name}=\"")).map_or(0, |at| at + name.len() + 3);
        document[start..].split('"').next().and_then(|text| text.parse().ok()).unwrap_or(0.0)
    };
    let width = documents.iter().map(|document| length(document, "width")).fold(1.0, f64::max);
    let mut sheet = Sheet::new(width, title);
    let mut y = 0.0;
    for (index, document) in documents.iter().enumerate() {
        // An SVG within an SVG has its own position, but shares the names.
        let inner = document.trim_end().replacen("<svg ", &format!(r#"<svg y="{y:.0}" "#), 1);
        let inner = inner.replace(r#"id="clip"#, &format!(r#"id="part{index}-clip"#));
        let inner = inner.replace("url(#clip", &format!("url(#part{index}-clip"));
        sheet.body.raw(inner).expect(IN_MEMORY);
        y += length(document, "height");
    }
    sheet.finish(y)
}
