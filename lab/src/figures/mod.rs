//! Every figure and table of the paper, reproduced from our own material: `burstscope figures --out DIR`.
//!
//! A [`PaperFigure`] is one of the paper's: `NAME.svg` shows it, `NAME.csv` holds its numbers. Its maker is a plain
//! value with all parameters, and a function from that value to both files. [`FiguresJob`] runs one maker after the
//! other, keeps finished figures (a record names the parameters they were made from), and writes the page `index.html`.
//!
//! Nothing computes here: see [`crate::evaluate`], [`crate::synth`] and [`burstscope_core::detector::view`].

mod apparent_motion;
mod architecture;
mod charts;
mod job;
mod matching;
mod pictures;
mod reconstruction;
mod record;
mod which;

pub use job::{FigureReport, FiguresEvent, FiguresJob, FiguresReport, find_colmap};
pub use which::{FigureSize, PaperFigure};

use burstscope_core::export::sheet::{Area, Colour, Sheet};
use burstscope_core::plane::{Plane, display::Display};
use burstscope_core::{detector::Feature, error::Result, export::FigureStroke, monitor::Monitor};
use record::Pieces;

/// Files of a figure, in memory.
#[derive(Debug, Clone, PartialEq)]
struct Made {
    /// The picture, a self-contained SVG.
    svg: String,
    csv: String,
    /// Notes for the reader, such as missing columns; sentences.
    notes: Vec<String>,
}

/// All parameters of a figure, and the function that makes it. `Debug` names all that the figure depends on.
trait MakeFigure: std::fmt::Debug {
    /// Makes the figure. `pieces` stores parts that take long, for the next figure and the next run.
    fn make(&self, pieces: &Pieces, monitor: &Monitor) -> Result<Made>;
}

const RIGHT: Colour = [0x4f, 0xa3, 0xff];
const WRONG: Colour = [0xff, 0x8c, 0x1a];

/// A picture on a sheet, on which marks are drawn at its pixels.
#[derive(Debug, Clone, Copy)]
struct Panel {
    pub area: Area,
    /// Sheet pixels for each image pixel.
    pub scale: f64,
}

impl Panel {
    /// Draws `plane` with its left top at `at`, `width` wide, under a line of text.
    pub fn draw(sheet: &mut Sheet, at: (f64, f64), width: f64, plane: &Plane, display: &Display, title: &str) -> Self {
        let scale = width / plane.width() as f64;
        let area = Area { x: at.0, y: at.1, width, height: scale * plane.height() as f64 };
        sheet.heading((at.0, at.1 - 6.0), 12.0, title);
        sheet.picture(area, plane, display);
        Self { area, scale }
    }

    /// The position on the sheet of the image pixel (u, v), of its middle.
    pub fn at(&self, [u, v]: [f64; 2]) -> (f64, f64) {
        (self.area.x + (u + 0.5) * self.scale, self.area.y + (v + 0.5) * self.scale)
    }

    pub fn shows(&self, pos_image: [f64; 2]) -> bool {
        let (x, y) = self.at(pos_image);
        x >= self.area.x && x <= self.area.right() && y >= self.area.y && y <= self.area.bottom()
    }

    pub fn circle(&self, sheet: &mut Sheet, pos_image: [f64; 2], radius_px: f64, stroke: FigureStroke) {
        if self.shows(pos_image) {
            sheet.circle(self.at(pos_image), radius_px * self.scale, stroke);
        }
    }

    /// Draws a feature: the rim of the disc with the strongest response at its scale.
    pub fn feature(&self, sheet: &mut Sheet, feature: &Feature, colour: Colour) {
        let pos_image = [f64::from(feature.u), f64::from(feature.v)];
        self.circle(sheet, pos_image, 1.5 * f64::from(feature.sigma), FigureStroke::new(colour, 1.6));
    }
}
