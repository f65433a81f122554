//! Panels of figures for papers: pictures as shown in the window, with their overlays.
//!
//! A feature is a circle, as in the window, a tick along its orientation, and an arrow along its motion. The image's
//! first pixel has its centre at (0, 0) and covers −0.5 … 0.5. A figure for print has a width in millimetres, letters
//! and lines in points, and titles broken to fit.

use super::shape::{Colour, FigureUnit};
use crate::burst::{Offset, Positions};
use crate::{detector::Feature, plane::display::Display};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Mark of an entry of a legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // where a name says it
pub enum LegendMark {
    Square,
    Line,
    Dashes,
    /// The colours of all directions, those of the longest motions on the rim. It has no colour of its own.
    Wheel,
}

/// Meaning of a colour of the figure.
#[derive(Debug, Clone, PartialEq, Eq)]
#[allow(missing_docs)] // where a name says it
pub struct LegendEntry {
    pub mark: LegendMark,
    pub color: Colour,
    pub label: String,
}

impl LegendEntry {
    /// An entry with a square.
    pub fn square(color: Colour, label: String) -> Self {
        Self { mark: LegendMark::Square, color, label }
    }

    /// An entry with the wheel of the colours of motions, whose `label` says how long those on the rim are.
    pub fn wheel(label: String) -> Self {
        Self { mark: LegendMark::Wheel, color: [0; 3], label }
    }
}

/// Mark of a feature over a picture; positions and lengths in image pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct FigureMark {
    /// Centre, (u, v).
    pub centre: [f32; 2],
    pub radius: f32,
    /// Direction of the tick, radians from +u towards +v; `None` for no tick.
    pub orientation: Option<f32>,
    /// Start and end of the arrow of its motion; `None` for no arrow.
    pub motion: Option<[[f32; 2]; 2]>,
    /// Standard deviation of the arrow's end, of which the arrow has a [`fan()`](super::fan()); 0 for none.
    pub motion_sigma: f32,
    pub color: Colour,
    /// Opacity, 0 … 1.
    pub opacity: f32,
    /// Width of the strokes as a multiple of the figure's.
    pub weight: f32,
    pub dashed: bool,
}

impl FigureMark {
    /// A plain circle.
    pub fn circle(centre: [f32; 2], radius: f32, color: Colour) -> Self {
        let (orientation, motion, motion_sigma) = (None, None, 0.0);
        Self { centre, radius, orientation, motion, motion_sigma, color, opacity: 1.0, weight: 1.0, dashed: false }
    }

    /// A feature of a burst with frames at `positions` with the arrow of its motion and the fan of its uncertainty;
    /// dashed at the limit of the searched slopes, beyond which its true motion may lie.
    pub fn of(feature: &Feature, positions: &Positions, color: Colour) -> Self {
        let circle = Self::circle([feature.u, feature.v], feature.circle_radius_px(), color);
        let (motion, motion_sigma) = (Some(motion_over(feature, positions)), sigma_over(feature, positions));
        Self { motion, motion_sigma, opacity: 0.95, dashed: feature.at_slope_limit, ..circle }
    }
}

/// Places (u, v) of a feature in the first and the last frame by its [motion](Feature::motion), image pixels.
pub fn motion_over(feature: &Feature, positions: &Positions) -> [[f32; 2]; 2] {
    let (motion, _) = feature.motion();
    ends(positions).map(|offset| {
        let (u, v) = motion.displacement(offset);
        [feature.u + u, feature.v + v]
    })
}

/// Standard deviation of a feature's place in the last frame, from that of its [motion](Feature::motion), image pixels.
pub fn sigma_over(feature: &Feature, positions: &Positions) -> f32 {
    let last = ends(positions)[1];
    last.u.hypot(last.v) * feature.motion().1
}

/// Positions of the first and of the last frame from mid-burst.
fn ends(positions: &Positions) -> [Offset<f32>; 2] {
    let offsets = positions.offsets();
    [offsets.first(), offsets.last()].map(|offset| offset.copied().unwrap_or_default().to_f32())
}

/// Colours of values, from the smallest to the largest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColourBar {
    /// The colours, from left to right; at least one.
    pub colors: Vec<Colour>,
    /// Label of the left end.
    pub low: String,
    /// Label of the right end, with the unit.
    pub high: String,
}

impl ColourBar {
    /// The colours of a picture, with the labels of the ends of its range.
    pub fn of(display: &Display, low: String, high: String) -> Self {
        const STEPS: usize = 64;
        let colours = display.colours();
        let value = |i: usize| display.min + (display.max - display.min) * (i as f32 + 0.5) / STEPS as f32;
        Self { colors: (0..STEPS).map(|i| colours.colour(value(i))).collect(), low, high }
    }
}

/// One picture with its overlays.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct FigurePanel {
    /// Columns and rows of the picture.
    pub size: (usize, usize),
    /// Pixels, row by row: red, green, blue, alpha. Shared, not copied.
    pub rgba: Arc<Vec<u8>>,
    /// Left top corner of the picture's first pixel, (u, v) in image pixels.
    pub origin_image: [f32; 2],
    /// Width of a pixel of the picture, in image pixels.
    pub image_px_per_px: f32,
    /// Marks, the first at the bottom.
    pub marks: Vec<FigureMark>,
    pub title: Option<String>,
    pub legend: Vec<LegendEntry>,
    pub bar: Option<ColourBar>,
}

pub(super) const POINTS_PER_MM: f32 = 72.0 / 25.4;

/// Width of a figure; it decides the unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FigureWidth {
    /// Figure pixels for each image pixel, 1/64 … 64.
    PxPerPx(f32),
    /// Millimetres on paper, 10 … 2000.
    Millimetres(f32),
}

impl FigureWidth {
    /// Unit of a drawing of this width.
    pub fn unit(self) -> FigureUnit {
        match self {
            Self::PxPerPx(_) => FigureUnit::Pixel,
            Self::Millimetres(_) => FigureUnit::Point,
        }
    }
}

/// Options of the drawing of a figure. Lengths are in the unit of its width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigureOptions {
    /// Width of the figure; default a pixel for each image pixel.
    pub width: FigureWidth,
    /// Width of all strokes; default 1.5.
    pub stroke_width: f32,
    /// Height of letters; default 14.
    pub font_size: f32,
    /// Whether panels have letters (a), (b), …; default false.
    pub letters: bool,
    /// Whether the first picture has a bar of known length in its corner; default false.
    pub scale_bar: bool,
}

impl Default for FigureOptions {
    fn default() -> Self {
        let width = FigureWidth::PxPerPx(1.0);
        Self { width, stroke_width: 1.5, font_size: 14.0, letters: false, scale_bar: false }
    }
}
