//! Measuring line and rectangle, drawn on a picture: the values along the line and the statistics in the rectangle, for
//! all linked panes together.
//!
//! [`Measure`] is a plain value of the project: the shape, its pane, and its place in pixels of the input image. The
//! panels below the pictures show [`profiles_of`] and [`region_in`]; the export writes the same values.

mod draw;
mod line_panel;
mod region_panel;
mod values;

pub use draw::{draw_ui, measure_ui};
pub use line_panel::profile_ui;
pub use region_panel::{RegionCache, region_ui};
pub use values::{PaneProfile, PaneRegion, measured_panes, profiles_of, region_in};

pub use crate::app::project::measure::{Measure, MeasuredLine, MeasuredRegion, Tool};
