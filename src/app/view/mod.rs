//! How pictures and features are seen, as plain values: pan and zoom ([`View`]), transforms between coordinate systems,
//! the quantity that colours show, and numbers as people read them. The project keeps these values, the canvas draws by
//! them.

mod colour_by;
mod numbers;
mod pan_zoom;
mod transform;

pub use colour_by::ColourBy;
pub use numbers::{number, signed_number};
pub use pan_zoom::{MAX_POINTS_PER_PIXEL, View, Zoom};
pub use transform::RectTransform;
