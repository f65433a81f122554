//! Figures of the shown panes, with filter, faint features, colours and visible part of the image, as vectors or as
//! pixels.

mod collect;
mod dialog;
mod links;
mod raster;

pub use collect::drawing_of;
pub use dialog::figure_dialog_ui;
pub use raster::rasterise;
