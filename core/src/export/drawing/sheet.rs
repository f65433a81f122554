//! The sheet on which a figure is drawn: lines, text, pictures, and axes with round ticks.

use super::shape::{CURVE, Drawing, FigureRect, FigureShape, FigureStroke, FigureUnit};
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use std::sync::Arc;

pub use super::shape::{Anchor, Colour, Dashes, Face, SOLID, Style};

/// Colour of letters and axes.
pub const INK: Colour = [0x24, 0x29, 0x2f];
/// Colour of less important parts.
pub const FAINT: Colour = [0x8c, 0x95, 0x9f];
/// Colour of lines behind curves.
pub const GRID: Colour = [0xe4, 0xe8, 0xec];
/// Okabe and Ito's blue; [`RED`] and [`GREEN`] are of the same palette, which colour-blind readers can tell apart.
pub const BLUE: Colour = [0x00, 0x72, 0xb2];
/// Okabe and Ito's vermilion.
pub const RED: Colour = [0xd5, 0x5e, 0x00];
/// Okabe and Ito's green, darker.
pub const GREEN: Colour = [0x00, 0x7a, 0x58];
/// Colour of the sheet.
pub const WHITE: Colour = [255; 3];
/// Approximate width of a letter over the size of the font.
pub const LETTER: f64 = 0.52;

/// A rectangle of the sheet, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct Area {
    pub x: f64,
    pub y: f64,
    pub width: f64,
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

    fn rect(&self) -> FigureRect {
        FigureRect { min: place((self.x, self.y)), size: place((self.width, self.height)) }
    }
}

fn place((x, y): (f64, f64)) -> [f32; 2] {
    [x as f32, y as f32]
}

/// Drawing under construction. Lengths are pixels.
#[derive(Debug)]
pub struct Sheet {
    shapes: Vec<FigureShape>,
    width: f64,
    title: String,
}

impl Sheet {
    /// Creates an empty sheet; screen readers use `title`.
    pub fn new(width: f64, title: &str) -> Self {
        Self { shapes: Vec::new(), width: width.round(), title: title.to_owned() }
    }

    /// Finishes the drawing, `height` high.
    pub fn finish(self, height: f64) -> Drawing {
        let Self { mut shapes, width, title } = self;
        let size = place((width, height.round()));
        shapes.insert(0, FigureShape::Rect { rect: FigureRect { min: [0.0; 2], size }, style: WHITE.into() });
        Drawing { size, unit: FigureUnit::Pixel, shapes, title }
    }

    /// Draws a line of text of `size` pixels.
    pub fn text(&mut self, at: (f64, f64), size: f64, anchor: Anchor, text: &str) {
        self.styled_text(at, size, anchor, (Face::Plain, INK), text);
    }

    /// Draws a line of bold text of `size` pixels that begins at `at`.
    pub fn heading(&mut self, at: (f64, f64), size: f64, text: &str) {
        self.styled_text(at, size, Anchor::Start, (Face::Bold, INK), text);
    }

    /// Draws a line of text of other letters, or of another colour.
    pub fn styled_text(&mut self, at: (f64, f64), size: f64, anchor: Anchor, style: (Face, Colour), text: &str) {
        let ((face, color), text) = (style, text.to_owned());
        let size = size as f32;
        self.shapes.push(FigureShape::Text { at: place(at), anchor, size, face, color, upwards: false, text });
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
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: impl Into<FigureStroke>) {
        let points = [from, to].map(|end| Some(place(end))).to_vec();
        self.shapes.push(FigureShape::Line { points, style: stroke.into().into(), class: "" });
    }

    /// Draws a rectangle.
    pub fn rectangle(&mut self, area: Area, style: impl Into<Style>) {
        self.shapes.push(FigureShape::Rect { rect: area.rect(), style: style.into() });
    }

    /// Draws a circle.
    pub fn circle(&mut self, at: (f64, f64), radius: f64, style: impl Into<Style>) {
        self.shapes.push(FigureShape::Circle { centre: place(at), radius: radius as f32, style: style.into() });
    }

    /// Draws a line through points, with breaks where a point is `None`.
    pub fn polyline(&mut self, points: impl IntoIterator<Item = Option<(f64, f64)>>, stroke: impl Into<FigureStroke>) {
        let points = points.into_iter().map(|point| point.map(place)).collect();
        self.shapes.push(FigureShape::Line { points, style: stroke.into().into(), class: CURVE });
    }

    /// Draws a plane as a picture that fills `area`; pixels stay sharp.
    pub fn picture(&mut self, area: Area, plane: &Plane, display: &Display) {
        let rgba = Arc::new(to_rgba8(plane, display).into_raw());
        self.shapes.push(FigureShape::Picture { rect: area.rect(), size: plane.size(), rgba });
    }

    /// Draws the shapes of `draw`, clipped to `area`.
    pub fn clipped(&mut self, area: Area, draw: impl FnOnce(&mut Self)) {
        let below = std::mem::take(&mut self.shapes);
        draw(self);
        let shapes = std::mem::replace(&mut self.shapes, below);
        self.shapes.push(FigureShape::Clipped { rect: area.rect(), round: false, shapes });
    }

    /// Draws ticks and labels under an area, for values from `range.0` at its left to `range.1` at its right.
    pub fn axis_below(&mut self, area: Area, range: (f64, f64), label: &str) {
        for tick in ticks(range) {
            let x = area.x + (tick - range.0) / (range.1 - range.0) * area.width;
            self.line((x, area.bottom()), (x, area.bottom() + 4.0), INK);
            self.text((x, area.bottom() + 16.0), 11.0, Anchor::Middle, &short(tick));
        }
        self.text((area.x + 0.5 * area.width, area.bottom() + 32.0), 12.0, Anchor::Middle, label);
    }

    /// Draws ticks and labels left of an area, for values from `range.0` at its bottom to `range.1` at its top.
    pub fn axis_left(&mut self, area: Area, range: (f64, f64), label: &str) {
        for tick in ticks(range) {
            let y = area.bottom() - (tick - range.0) / (range.1 - range.0) * area.height;
            self.line((area.x - 4.0, y), (area.x, y), INK);
            self.text((area.x - 7.0, y + 4.0), 11.0, Anchor::End, &short(tick));
        }
        self.label_left(area, label);
    }

    /// Draws the label of a vertical axis.
    pub fn label_left(&mut self, area: Area, label: &str) {
        let (at, text) = (place((area.x - 44.0, area.y + 0.5 * area.height)), label.to_owned());
        let (anchor, size, face, color) = (Anchor::Middle, 12.0, Face::Plain, INK);
        self.shapes.push(FigureShape::Text { at, anchor, size, face, color, upwards: true, text });
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

/// Stacks drawings under one another, as one.
pub fn stacked(title: &str, drawings: Vec<Drawing>) -> Drawing {
    let width = drawings.iter().map(|drawing| drawing.size[0]).fold(1.0, f32::max);
    let mut sheet = Sheet::new(f64::from(width), title);
    let mut y = 0.0;
    for Drawing { size, shapes, .. } in drawings {
        sheet.shapes.push(FigureShape::Moved { by: [0.0, y], shapes });
        y += size[1];
    }
    sheet.finish(f64::from(y))
}
