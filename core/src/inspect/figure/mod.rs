//! Figures of explanations as SVG: readable alone, on light and dark pages, and without colour.

mod probe;
mod spectrum;

pub use probe::probe_svg;
pub use spectrum::spectrum_svg;
