//! A line and a rectangle that one draws on a picture: the values along the one, and what is known of those in the
//! other, in all linked panes together.
//!
//! [`Measure`] is a plain value of the project: what was drawn, on which pane, in pixels of the input image. The panels
//! below the pictures draw [`profiles_of`] and [`region_in`]; the export writes the same.

mod draw;
mod line_panel;
mod region_panel;
mod values;

pub use draw::{draw_ui, measure_ui};
pub use line_panel::profile_ui;
pub use region_panel::{RegionCache, region_ui};
pub use values::{PaneProfile, PaneRegion, measured_panes, profiles_of, region_in};

pub use crate::app::project::measure::{Measure, MeasuredLine, MeasuredRegion, Tool};
