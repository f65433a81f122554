//! Shapes of drawings, with their styles.

use std::sync::Arc;
use vello_cpu::kurbo::{BezPath, Circle, Rect, Shape};

/// Red, green, blue.
pub type Colour = [u8; 3];

/// Lengths of the dashes of a line and of the gaps after them, in turn, up to the first 0.
pub type Dashes = [f32; 4];
/// A line without gaps.
pub const SOLID: Dashes = [0.0; 4];
/// Length of a dash of a line of a figure, and of the gap after it, as multiples of the line's width.
pub const DASH: f32 = 4.0;

/// Part of a figure that is a curve.
pub(super) const CURVE: &str = "curve";

/// Unit of a drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FigureUnit {
    /// Pixels of the figure.
    Pixel,
    /// Points of 1/72 inch.
    Point,
}

/// Rectangle of the figure, from its left top corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigureRect {
    /// Left top corner, (x, y).
    pub min: [f32; 2],
    /// Width and height.
    pub size: [f32; 2],
}

/// Style of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct FigureStroke {
    pub width: f32,
    pub color: Colour,
    /// Opacity, 0 … 1.
    pub opacity: f32,
    pub dashes: Dashes,
}

impl FigureStroke {
    /// A solid, opaque line.
    pub fn new(color: Colour, width: f32) -> Self {
        Self { width, color, opacity: 1.0, dashes: SOLID }
    }

    /// Lengths of dashes and gaps, in turn.
    pub(super) fn gaps(&self) -> impl Iterator<Item = f32> {
        self.dashes.into_iter().take_while(|length| *length > 0.0)
    }

    /// This line with dashes and gaps of these lengths.
    #[must_use]
    pub fn dashed(self, [dash, gap]: [f32; 2]) -> Self {
        Self { dashes: [dash, gap, 0.0, 0.0], ..self }
    }
}

impl From<Colour> for FigureStroke {
    fn from(color: Colour) -> Self {
        Self::new(color, 1.0)
    }
}

/// Style of an area and its outline.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Style {
    /// Colour and opacity (0 … 1) of the area; `None` where it is not filled.
    pub fill: Option<(Colour, f32)>,
    /// The outline, if there is one.
    pub stroke: Option<FigureStroke>,
}

/// An area of this colour without an outline.
impl From<Colour> for Style {
    fn from(color: Colour) -> Self {
        Self { fill: Some((color, 1.0)), stroke: None }
    }
}

/// An outline of an area that is not filled.
impl From<FigureStroke> for Style {
    fn from(stroke: FigureStroke) -> Self {
        Self { fill: None, stroke: Some(stroke) }
    }
}

/// Alignment of a text to its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs)] // where a name says it
pub enum Anchor {
    #[default]
    Start,
    Middle,
    End,
}

/// Letters of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs)] // where a name says it
pub enum Face {
    #[default]
    Plain,
    Bold,
    Mono,
}

/// Shape of a drawing; all lengths in the drawing's unit.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub enum FigureShape {
    /// Pixels, each a rectangle of one colour.
    Picture {
        rect: FigureRect,
        /// Columns and rows.
        size: (usize, usize),
        /// Red, green, blue, alpha, row by row.
        rgba: Arc<Vec<u8>>,
    },
    /// A rectangle.
    Rect { rect: FigureRect, style: Style },
    /// A circle.
    Circle { centre: [f32; 2], radius: f32, style: Style },
    /// A line through points, or an area within them.
    Line {
        /// Points; a `None` is a gap of the line.
        points: Vec<Option<[f32; 2]>>,
        /// A filled area ends where it begins.
        style: Style,
        /// Part of the figure, for editing it: `orientation`, `motion`, `scale`, `match`, `legend`, `fan`,
        /// `curve`; or none, for a straight line.
        class: &'static str,
    },
    /// A line of text.
    Text {
        /// Place on the baseline.
        at: [f32; 2],
        anchor: Anchor,
        size: f32,
        face: Face,
        color: Colour,
        /// Whether it reads upwards.
        upwards: bool,
        text: String,
    },
    /// Shapes, the first at the bottom, outside a rectangle cut off; `round` lines have round ends.
    Clipped { rect: FigureRect, round: bool, shapes: Vec<FigureShape> },
    /// Shapes, the first at the bottom, that are moved.
    Moved {
        /// Shift, (x, y).
        by: [f32; 2],
        shapes: Vec<FigureShape>,
    },
}

impl FigureShape {
    /// The way along which a rectangle, a circle or a line is drawn, within `tolerance`.
    pub(super) fn way(&self, tolerance: f64) -> Option<(BezPath, &Style)> {
        let point = |[x, y]: [f32; 2]| (f64::from(x), f64::from(y));
        match self {
            Self::Rect { rect, style } => Some((rect.rect().to_path(tolerance), style)),
            Self::Circle { centre, radius, style } => {
                Some((Circle::new(point(*centre), f64::from(*radius)).to_path(tolerance), style))
            }
            Self::Line { points, style, .. } => {
                let mut way = BezPath::new();
                let mut goes_on = false;
                for at in points {
                    match at.map(point) {
                        Some(to) if goes_on => way.line_to(to),
                        Some(to) => way.move_to(to),
                        None => {}
                    }
                    goes_on = at.is_some();
                }
                Some((way, style))
            }
            _ => None,
        }
    }
}

impl FigureRect {
    pub(super) fn rect(&self) -> Rect {
        let [x, y, width, height] = [self.min[0], self.min[1], self.size[0], self.size[1]].map(f64::from);
        Rect::new(x, y, x + width, y + height)
    }
}

/// A figure on a white sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Width and height.
    pub size: [f32; 2],
    /// Unit of all lengths.
    pub unit: FigureUnit,
    /// Shapes, the first at the bottom.
    pub shapes: Vec<FigureShape>,
    /// Title for screen readers.
    pub title: String,
}
