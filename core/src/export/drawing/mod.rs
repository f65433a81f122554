//! Drawings: shapes on a white sheet, what is drawn with them, and their files.
//!
//! A [`Drawing`] is a list of [shapes](FigureShape), which `svg`, `pdf` and `raster` write. It comes from a [`sheet`],
//! on which text, axes and [plots](Plot) are placed; from a [`Table`]; or from [`lay_out`], which arranges pictures
//! with their overlays for papers. A [`Figure`] is a drawing with its numbers, and [`Figure::write`] writes either, as
//! the ending of the file's name says: the one list of endings is [`FigureFormat`].

mod font;
mod layout;
mod links;
mod panel;
mod pdf;
mod plot;
mod raster;
mod shape;
pub mod sheet;
mod svg;
mod table;
mod write;

pub use layout::{FAN_OPACITY, fan, lay_out, round_length};
pub use links::{FigureAmount, FigureLink, FigureMatches, MatchKind};
pub use panel::{
    ColourBar, FigureMark, FigureOptions, FigurePanel, FigureWidth, LegendEntry, LegendMark, motion_over, sigma_over,
};
pub use plot::{Plot, Series, SeriesPoint, range_from_zero};
pub use raster::{rasterise, rasterise_preview};
pub use shape::{
    Anchor, Colour, DASH, Dashes, Drawing, Face, FigureRect, FigureShape, FigureStroke, FigureUnit, SOLID, Style,
};
pub use svg::Escaped;
pub use table::{Cell, Table};
pub use write::{Figure, FigureFormat, write_drawing};
