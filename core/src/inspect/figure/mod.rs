//! Figures of explanations as self-contained SVG, for light and dark pages, readable without colour.

mod probe;
mod spectrum;

pub use probe::probe_svg;
pub use spectrum::spectrum_svg;
