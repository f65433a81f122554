//! Panels of the Lab: the choice of charts and methods, the curves, which grow while charts are finished, and the chart
//! behind a point of a curve.

pub mod chart;
pub mod curves;
mod kept;
pub mod settings;

use egui::{Color32, Ui};

/// Colour `#rrggbb` of the figures as drawn here: lighter on a dark background.
fn curve_colour(ui: &Ui, colour: &str) -> Color32 {
    let colour = Color32::from_hex(colour).unwrap_or(crate::app::style::ACCENT);
    if ui.visuals().dark_mode { colour.lerp_to_gamma(Color32::WHITE, 0.3) } else { colour }
}
