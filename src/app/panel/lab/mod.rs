//! The Lab's panels: which charts and methods, the curves that grow while charts are finished, and the chart behind a
//! point of a curve.

pub mod chart;
pub mod curves;
mod kept;
pub mod settings;

use egui::{Color32, Ui};

/// A colour of the figures, `#rrggbb`, as it is drawn here: lighter on a dark ground.
fn curve_colour(ui: &Ui, colour: &str) -> Color32 {
    let colour = Color32::from_hex(colour).unwrap_or(crate::app::style::ACCENT);
    if ui.visuals().dark_mode { colour.lerp_to_gamma(Color32::WHITE, 0.3) } else { colour }
}
