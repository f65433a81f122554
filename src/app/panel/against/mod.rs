//! Comparison of the features with others: over the picture, its legend, and its list.

mod list;
mod marks;

pub use list::against_ui;
pub use marks::{legend_ui, marks_ui};

use crate::app::project::against::{Kind, With};
use egui::Color32;

/// Colour of a comparison's outcome: distinct in hue and in lightness, and visible over a grey picture.
pub fn colour(with: With, kind: Kind) -> Color32 {
    match (with, kind) {
        (_, Kind::Theirs) => Color32::from_rgb(0xff, 0x6b, 0xb5),
        (With::Truth, Kind::Ours) => Color32::from_rgb(0xff, 0x8a, 0x3d),
        (_, Kind::Ours) => Color32::from_rgb(0x5c, 0xe0, 0x7c),
        (_, Kind::Moved) => Color32::from_rgb(0xff, 0xd2, 0x4a),
        (_, Kind::Repeated) => Color32::from_rgb(0xc4, 0xa2, 0xff),
        (With::Truth, Kind::Same) => Color32::from_rgb(0x5c, 0xe0, 0x7c),
        (_, Kind::Same) => Color32::from_rgb(0x86, 0xb7, 0xee),
    }
}
