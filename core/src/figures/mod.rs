//! Every figure and table of the paper, remade from our own material: `burstscope figures --out DIR`.
//!
//! A [`PaperFigure`] is one of the paper's; `PaperFigure::NAME.svg` shows it and `NAME.csv` holds its numbers. What
//! makes it is a plain value with all of its parameters (charts, trajectories, methods), and a function from that value
//! to both files. [`FiguresJob`] runs them one after the other into a folder, keeps what is finished (a record names
//! what it was made from), and writes a page, `index.html`, that shows all.
//!
//! Nothing here computes anything of its own: charts and curves are those of [`crate::evaluate`], bursts those of
//! [`crate::synth`], pictures of single steps those of [`crate::detector::view`].

mod apparent_motion;
mod architecture;
mod charts;
mod drawing;
mod error;
mod failures;
mod job;
mod light;
mod matching;
mod page;
mod reconstruction;
mod record;
mod table;
mod target;
mod which;

pub use error::FiguresError;
pub use job::{FigureReport, FiguresEvent, FiguresJob, FiguresReport, find_colmap};
pub use which::{FigureSize, PaperFigure};

use crate::monitor::Monitor;
use record::Pieces;

/// A figure's files, in memory.
#[derive(Debug, Clone, PartialEq)]
struct Made {
    /// The picture, readable alone.
    svg: String,
    /// Its numbers.
    csv: String,
    /// What a reader must know, such as what is missing; sentences.
    notes: Vec<String>,
}

/// All parameters of a figure, and what makes it of them. Its `Debug` text names all that the figure depends on.
trait MakeFigure: std::fmt::Debug {
    /// Makes the figure. `pieces` keeps parts that take long, for the next figure and the next run.
    fn make(&self, pieces: &Pieces, monitor: &Monitor) -> Result<Made, FiguresError>;
}
