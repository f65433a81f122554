//! Table of all methods' numbers, in the columns of the paper.

use crate::app::panel::sorted_table::{ROW_HEIGHT, cell_ui, heading_ui};
use crate::app::project::Model;
use crate::app::project::compare::Contender;
use crate::app::project::pair::Side;
use egui::{Align, Layout, RichText, Ui};
use egui_extras::{Column, TableBuilder};

/// Headings after the method's name, and their meanings.
const COLUMNS: [(&str, &str); 9] = [
    ("Features A", "Features found in A"),
    ("Features B", "Features found in B"),
    ("SNR", "Median of |response| over the noise in D, of A's features"),
    ("Putative", "Matches by descriptors alone"),
    ("Inliers", "Putative matches that agree with the geometry of the two views"),
    ("Match ratio", "Putative matches over keypoints, mean of A and B"),
    ("Match score", "Inliers over keypoints, mean of A and B"),
    ("Precision", "Inliers over putative matches"),
    ("Time", "Wall-clock time of the detection in A"),
];

/// Draws the table.
pub fn table_ui(ui: &mut Ui, model: &mut Model) {
    ui.spacing_mut().item_spacing.x = 4.0;
    let mut switched = None;
    egui::ScrollArea::horizontal().auto_shrink(false).show(ui, |ui| {
        TableBuilder::new(ui)
            .striped(true)
            .cell_layout(Layout::left_to_right(Align::Center))
            .min_scrolled_height(0.0)
            .auto_shrink(false)
            .column(Column::exact(116.0))
            .columns(Column::remainder().at_least(55.0), COLUMNS.len())
            .header(20.0, |mut header| {
                header.col(|ui| {
                    ui.label(RichText::new("Method").small());
                });
                for (name, help) in COLUMNS {
                    let (_, cell) = header.col(|ui| heading_ui(ui, name, None));
                    cell.on_hover_text(help);
                }
            })
            .body(|mut body| {
                for method in Contender::ALL {
                    body.row(ROW_HEIGHT, |mut row| {
                        row.col(|ui| {
                            let usable = model.method_burst(method, Side::A).is_some();
                            let mut on = model.compare.look.shows(method);
                            let tip = if usable { method.help() } else { "Open a sharp image of A's view first" };
                            let boxed = egui::Checkbox::new(&mut on, method.label());
                            let response = ui.add_enabled(usable, boxed);
                            if response.on_hover_text(tip).on_disabled_hover_text(tip).changed() {
                                switched = Some((method, on));
                            }
                        });
                        for text in cells(model, method) {
                            row.col(|ui| cell_ui(ui, RichText::new(text).monospace()));
                        }
                    });
                }
            });
    });
    if let Some((method, on)) = switched {
        model.compare.look.show(method, on);
    }
}

/// Numbers of a method; missing ones are a dash.
fn cells(model: &Model, method: Contender) -> [String; COLUMNS.len()] {
    let found = |side| model.method_found(method, side);
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    let count = |side| found(side).map(|f| f.detection.features.len().to_string());
    let counts = model.method_matches(method).map(|m| m.result.counts);
    let share = |x: f64| format!("{x:.3}");
    let state = if model.compare.running().is_some_and(|(running, _)| running == method) {
        Some("…".to_owned())
    } else {
        model.compare.problem(method).map(|_| "failed".to_owned())
    };
    [
        or_dash(count(Side::A).or(state)),
        or_dash(count(Side::B)),
        or_dash(found(Side::A).and_then(|f| median_snr(&f.detection.features)).map(|snr| format!("{snr:.1}"))),
        or_dash(counts.map(|c| c.putative.to_string())),
        or_dash(counts.and_then(|c| c.inliers).map(|n| n.to_string())),
        or_dash(counts.map(|c| share(c.match_ratio()))),
        or_dash(counts.and_then(|c| c.match_score()).map(share)),
        or_dash(counts.and_then(|c| c.precision()).map(share)),
        or_dash(found(Side::A).map(|f| format!("{:.2} s", f.elapsed.as_secs_f32()))),
    ]
}

fn median_snr(features: &[crate::detector::Feature]) -> Option<f32> {
    let mut snrs: Vec<f32> = features.iter().map(|f| f.snr).collect();
    snrs.sort_by(f32::total_cmp);
    snrs.get(snrs.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn before_anything_is_found_all_cells_are_dashes() {
        assert!(cells(&Model::default(), Contender::Sift).iter().all(|cell| cell == "–"));
        assert_eq!(median_snr(&[]), None);
    }
}
