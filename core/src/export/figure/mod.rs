//! Figures for papers: pictures as they are shown, with what lies over them, as vectors or as pixels.
//!
//! [`FigurePanel`]s say what is shown: pixels, marks of features, a title, what colours mean. [`lay_out`] puts one or
//! several of them on a sheet of paper, which gives a [`Drawing`]: shapes with places in figure pixels.
//! [`write_drawing_svg`] writes it as vectors; whoever has letters to draw with can make pixels of the same drawing. So
//! both show the same. Matches between panels are [`FigureLink`]s, which [`draw_links`] adds.
//!
//! A feature is a circle (of the radius at which it is drawn in the window); a tick from its centre to the circle in
//! the direction of its orientation; and an arrow along the way that it moves. The image's first pixel has its centre
//! at (0, 0) and covers −0.5 … 0.5.

mod layout;
mod links;
mod svg;

pub use layout::lay_out;
pub use links::{FigureLink, draw_links};
pub use svg::write_drawing_svg;

use std::sync::Arc;

/// Red, green, blue.
pub type Colour = [u8; 3];

/// What a colour of the figure means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LegendEntry {
    /// Red, green, blue.
    pub color: Colour,
    /// What has this colour.
    pub label: String,
}

/// A feature over a picture; places and lengths in image pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigureMark {
    /// Its centre, (u, v).
    pub centre: [f32; 2],
    /// The circle's radius.
    pub radius: f32,
    /// The tick's direction, radians from +u towards +v; `None` draws none.
    pub orientation: Option<f32>,
    /// Where the arrow of its motion begins and ends; `None` draws none.
    pub motion: Option<[[f32; 2]; 2]>,
    /// Its colour.
    pub color: Colour,
    /// 0 … 1.
    pub opacity: f32,
    /// Its strokes' width as a multiple of the figure's.
    pub weight: f32,
    /// Whether the circle is dashed.
    pub dashed: bool,
}

/// The colours of the values, from the smallest to the largest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColourBar {
    /// The colours, from left to right; at least one.
    pub colors: Vec<Colour>,
    /// What stands at the left end.
    pub low: String,
    /// What stands at the right end, with the unit.
    pub high: String,
}

/// One picture with what lies over it.
#[derive(Debug, Clone, PartialEq)]
pub struct FigurePanel {
    /// Columns and rows of the picture.
    pub size: (usize, usize),
    /// Its pixels, row by row: red, green, blue, alpha. Shared, not copied.
    pub rgba: Arc<Vec<u8>>,
    /// The left top corner of the picture's first pixel, (u, v) in image pixels.
    pub origin_image: [f32; 2],
    /// Image pixels from one pixel of the picture to the next.
    pub image_px_per_px: f32,
    /// The features, in the order of drawing.
    pub marks: Vec<FigureMark>,
    /// A line above the picture.
    pub title: Option<String>,
    /// What the colours of the features mean, below the picture.
    pub legend: Vec<LegendEntry>,
    /// What the colours of the picture mean, below the picture.
    pub bar: Option<ColourBar>,
}

/// How a figure is drawn. Lengths are in figure pixels, whatever the scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigureOptions {
    /// Figure pixels for each image pixel, 1/64 … 64. Default 1.
    pub scale: f32,
    /// Width of all strokes. Default 1.5.
    pub stroke_width_px: f32,
    /// Height of letters. Default 14.
    pub font_size_px: f32,
    /// Whether panels are called (a), (b), … Default false.
    pub letters: bool,
    /// Whether each picture has a bar of known length in its corner. Default false.
    pub scale_bar: bool,
}

impl Default for FigureOptions {
    fn default() -> Self {
        Self { scale: 1.0, stroke_width_px: 1.5, font_size_px: 14.0, letters: false, scale_bar: false }
    }
}

/// A rectangle of the figure, in figure pixels from its left top corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigureRect {
    /// Left top corner, (x, y).
    pub min: [f32; 2],
    /// Width and height.
    pub size: [f32; 2],
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigureStroke {
    /// Its width, figure pixels.
    pub width: f32,
    /// Its colour.
    pub color: Colour,
    /// 0 … 1.
    pub opacity: f32,
}

/// One thing that is drawn; all places in figure pixels.
#[derive(Debug, Clone, PartialEq)]
pub enum FigureShape {
    /// Pixels, each a rectangle of one colour.
    Picture {
        /// Where.
        rect: FigureRect,
        /// Columns and rows.
        size: (usize, usize),
        /// Red, green, blue, alpha, row by row.
        rgba: Arc<Vec<u8>>,
    },
    /// A filled rectangle.
    Fill {
        /// Where.
        rect: FigureRect,
        /// Its colour.
        color: Colour,
    },
    /// A circle's line.
    Circle {
        /// Its centre.
        centre: [f32; 2],
        /// Its radius.
        radius: f32,
        /// Its line.
        stroke: FigureStroke,
        /// Whether every other piece is left out.
        dashed: bool,
    },
    /// A line through points.
    Line {
        /// At least two.
        points: Vec<[f32; 2]>,
        /// How it is drawn.
        stroke: FigureStroke,
        /// What it is part of, for those who edit the figure: `orientation`, `motion`, `scale`, `match`.
        class: &'static str,
    },
    /// A line of text.
    Text {
        /// The left end of the line that the letters stand on.
        at: [f32; 2],
        /// Height of the letters.
        size: f32,
        /// The text.
        text: String,
        /// Its colour.
        color: Colour,
    },
    /// Shapes of which only what lies in a rectangle is seen.
    Clipped {
        /// The rectangle.
        rect: FigureRect,
        /// The shapes.
        shapes: Vec<FigureShape>,
    },
}

/// A figure on a white sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Width and height, figure pixels.
    pub size: [f32; 2],
    /// What is drawn, the first at the bottom.
    pub shapes: Vec<FigureShape>,
    /// What the figure is called by programs that read it aloud.
    pub title: String,
}
