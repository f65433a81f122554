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
mod drawing;
mod job;
mod matching;
mod pictures;
mod reconstruction;
mod record;
mod which;

pub use job::{FigureReport, FiguresEvent, FiguresJob, FiguresReport, find_colmap};
pub use which::{FigureSize, PaperFigure};

use burstscope_core::{error::Result, monitor::Monitor};
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
