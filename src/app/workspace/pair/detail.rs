//! Panel of the selected match: both patches as their descriptors see them, both descriptors, all its numbers.

use crate::app::actions::Queue;
use crate::app::canvas::number;
use crate::app::canvas::overlay::LineKind;
use crate::app::panel::descriptor::descriptor_ui;
use crate::app::panel::patch::{PatchTexture, PatchView};
use crate::app::panel::selection::walk_ui;
use crate::app::panel::widgets::{number_row_ui, section_ui};
use crate::app::project::Model;
use crate::app::project::pair::{MatchRow, Matches, Side};
use crate::detector::Feature;
use crate::matching::TwoViewModel;
use crate::requests::PictureKind;
use egui::{RichText, Sense, Ui, Vec2};

/// Draws the section.
pub fn detail_ui(ui: &mut Ui, model: &Model, textures: &mut [PatchTexture; 2], queue: &mut Queue) {
    section_ui(ui, "Selected match", |ui| {
        walk_ui(ui, model, queue);
        ui.add_space(4.0);
        let Some(matches) = &model.pair.matches else {
            ui.weak("There are no matches yet.");
            return;
        };
        let Some(row) = model.pair.focus().and_then(|index| matches.row(index)) else {
            ui.weak("Point at a line or a row of the table; click to keep it.");
            return;
        };
        verdict_ui(ui, &row, model.pair.selected.is_none());
        if let Some(stale) = model.stale_matches() {
            ui.label(RichText::new(stale).color(crate::app::style::warning(ui)));
        }
        ui.add_space(4.0);
        let width = (0.5 * (ui.available_width() - 8.0)).clamp(60.0, 150.0);
        patches_ui(ui, model, &row, textures, width);
        descriptors_ui(ui, matches, &row, width);
        ui.add_space(4.0);
        numbers_ui(ui, matches, &row);
    });
}

fn verdict_ui(ui: &mut Ui, row: &MatchRow<'_>, only_pointed_at: bool) {
    let word = match LineKind::of(row.inlier) {
        LineKind::Inlier => "inlier",
        LineKind::Outlier => "outlier",
        LineKind::Unverified => "not verified",
    };
    let pointed = if only_pointed_at { "  (click to keep)" } else { "" };
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("Match {}: {word}", row.index + 1)).strong());
        ui.weak(pointed);
    });
}

fn patches_ui(ui: &mut Ui, model: &Model, row: &MatchRow<'_>, textures: &mut [PatchTexture; 2], width: f32) {
    ui.horizontal(|ui| {
        for ((side, feature), texture) in [(Side::A, *row.a), (Side::B, *row.b)].into_iter().zip(textures) {
            let wanted = PictureKind::Stack { slope: feature.slope };
            let picture = model.pair.patches.get(side as usize).filter(|picture| {
                let is_open = model.burst_of(side).is_some_and(|open| open.id == picture.request.burst.id);
                is_open && picture.request.kind == wanted
            });
            ui.vertical(|ui| {
                ui.set_width(width);
                match picture {
                    Some(picture) => {
                        let name = format!("Patch in {}", side.name());
                        let display = model.ranges_of_side(side).intensity;
                        let view = PatchView { name: &name, plane: &picture.plane, feature, turned: true, display };
                        view.ui(ui, texture, width);
                    }
                    None => {
                        ui.allocate_exact_size(Vec2::splat(width), Sense::hover());
                    }
                }
                let slope = format!("{}: slope {:+.2}, {:+.2}", side.name(), feature.slope.u, feature.slope.v);
                ui.label(RichText::new(slope).small().weak())
                    .on_hover_text("From the motion stack at the feature's own slope, in pixels per frame");
            });
        }
    });
}

fn descriptors_ui(ui: &mut Ui, matches: &Matches, row: &MatchRow<'_>, width: f32) {
    let colour = ui.visuals().hyperlink_color;
    ui.horizontal(|ui| {
        for (side, index) in [(Side::A, row.found.a), (Side::B, row.found.b)] {
            if let Some(descriptor) = matches.detection(side).descriptors.get(index) {
                ui.vertical(|ui| {
                    ui.set_width(width);
                    descriptor_ui(ui, &format!("Descriptor in {}", side.name()), descriptor, width, colour);
                });
            }
        }
    });
}

fn numbers_ui(ui: &mut Ui, matches: &Matches, row: &MatchRow<'_>) {
    egui::Grid::new("match numbers").num_columns(2).spacing([12.0, 2.0]).striped(true).min_col_width(96.0).show(
        ui,
        |ui| {
            let mut line = |name: &str, help: &str, value: String| number_row_ui(ui, name, help, &value);
            line("Distance", "Euclidean distance of the two descriptors", format!("{:.1}", row.found.distance));
            line(
                "Ratio",
                "Distance to the nearest descriptor over that to the second nearest; with the mutual check, the larger of both directions",
                format!("{:.3}", row.found.ratio),
            );
            let (name, help) = error_words(matches.model());
            line(name, help, row.error_px.map_or_else(|| "–".to_owned(), |e| format!("{} px", number(e, 3))));
            let rank = |i: usize| format!("{} of {}", i + 1, matches.detection(Side::A).features.len());
            line("Feature in A", "Rank by strength", rank(row.found.a));
            let rank = |i: usize| format!("{} of {}", i + 1, matches.detection(Side::B).features.len());
            line("Feature in B", "Rank by strength", rank(row.found.b));
            let place = |f: &Feature| format!("{:.2}, {:.2} px", f.u, f.v);
            line("Place in A", "(u, v) at mid-burst", place(row.a));
            line("Place in B", "(u, v) at mid-burst", place(row.b));
            let (du, dv) = (row.b.u - row.a.u, row.b.v - row.a.v);
            line("Shift A to B", "Difference of the places", format!("{du:+.2}, {dv:+.2} px"));
            line("Scale A, B", "σ, in pixels", format!("{:.2}, {:.2} px", row.a.sigma, row.b.sigma));
            let slope = |f: &Feature| format!("{:+.3}, {:+.3} px/frame", f.slope.u, f.slope.v);
            line("Slope in A", "Apparent motion", slope(row.a));
            line("Slope in B", "Apparent motion", slope(row.b));
            let turn = (row.b.orientation - row.a.orientation).to_degrees();
            let turn = (turn + 180.0).rem_euclid(360.0) - 180.0;
            line("Rotation A to B", "Difference of the orientations", format!("{turn:+.1}°"));
            line("SNR A, B", "|response| over the noise in D", format!("{:.1}, {:.1}", row.a.snr, row.b.snr));
        },
    );
}

/// Name of a match's error, and its meaning.
fn error_words(model: Option<&TwoViewModel>) -> (&'static str, &'static str) {
    match model {
        Some(TwoViewModel::Homography { .. }) => (
            "Homography error",
            "Root mean square of the distances, in both pictures, between a point and its partner mapped by the homography",
        ),
        Some(_) => {
            ("Epipolar error", "Sampson distance: about how far both points must move to fit the epipolar geometry")
        }
        None => ("Error", "There is no geometry that enough matches agree on"),
    }
}
