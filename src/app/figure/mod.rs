//! Figures of what the panes show: filter, faint features, colours, part of the image and all, as vectors or as pixels.

mod collect;
mod dialog;
mod links;
mod raster;

pub use collect::drawing_of;
pub use dialog::figure_dialog_ui;
pub use raster::rasterise;
