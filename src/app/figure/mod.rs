//! Figures of what the panes show: filter, faint features, colours, part of the image and all, as vectors or as pixels.

mod collect;
mod dialog;
mod raster;

pub use collect::{FigureChoice, drawing_of};
pub use dialog::figure_dialog_ui;
pub use raster::rasterise;
