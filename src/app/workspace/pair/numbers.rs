//! Numbers of the paper's table for the shown pair, or what they still need.

use crate::app::panel::widgets::{make_room, text_width};
use crate::app::project::Model;
use crate::app::project::pair::{Matches, Side};
use crate::matching::{Geometry, MatchCounts};
use egui::{Label, RichText, Ui};

/// Distance between a number and its name, points.
const NAME_GAP: f32 = 4.0;

/// Draws the line, or several where there is little space.
pub fn numbers_ui(ui: &mut Ui, model: &Model) {
    ui.horizontal_wrapped(|ui| {
        let Some(matches) = &model.pair.matches else {
            ui.add(Label::new(RichText::new(missing(model)).weak()).truncate());
            return;
        };
        ui.spacing_mut().item_spacing.x = 10.0;
        for (name, help, value) in rows(&matches.result.counts) {
            let text = format!("{name} {value}");
            let (name, value) = (RichText::new(name).small().weak(), RichText::new(value).strong().monospace());
            make_room(ui, text_width(ui, name.clone()) + NAME_GAP + text_width(ui, value.clone()));
            let response = ui
                .horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = NAME_GAP;
                    ui.add(Label::new(name).selectable(false));
                    ui.add(Label::new(value));
                })
                .response;
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &text));
            response.on_hover_text(help);
        }
        if let Some(problem) = model.stale_matches().map(str::to_owned).or_else(|| without_geometry(matches)) {
            ui.add(Label::new(RichText::new(problem).color(crate::app::style::warning(ui))).truncate());
        }
    });
}

/// Name, meaning and value of each number.
fn rows(counts: &MatchCounts) -> Vec<(&'static str, &'static str, String)> {
    let share = |x: f64| format!("{x:.3}");
    let none = || "–".to_owned();
    vec![
        ("Keypoints", "Features of A and of B", format!("{} + {}", counts.keypoints_a, counts.keypoints_b)),
        ("Putative", "Matches by descriptors alone", counts.putative.to_string()),
        (
            "Inliers",
            "Putative matches that agree with the geometry of the two views",
            counts.inliers.map_or_else(none, |n| n.to_string()),
        ),
        ("Match ratio", "Putative matches over keypoints, mean of A and B", share(counts.match_ratio())),
        ("Match score", "Inliers over keypoints, mean of A and B", counts.match_score().map_or_else(none, share)),
        ("Precision", "Inliers over putative matches", counts.precision().map_or_else(none, share)),
    ]
}

/// Note that fewer matches than required agree on a geometry.
fn without_geometry(matches: &Matches) -> Option<String> {
    let params = &matches.request.params;
    (params.geometry != Geometry::None && matches.model().is_none())
        .then(|| format!("No geometry: fewer than {} matches agree on one", params.min_inliers))
}

/// Reason why there are no matches.
fn missing(model: &Model) -> String {
    if model.burst_of(Side::B).is_none() {
        return "Open a second burst to match it with the first".into();
    }
    if let Some(error) = &model.pair.param_error {
        return format!("No matches: {error}");
    }
    if model.pair.matching.is_pending() {
        return "Matching…".into();
    }
    let without: Vec<&str> =
        Side::BOTH.into_iter().filter(|side| model.found_of(*side).is_none()).map(Side::name).collect();
    if without.is_empty() {
        "No matches yet".into()
    } else {
        format!("No features yet in {}: press Detect", without.join(" and "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_said() {
        assert!(missing(&Model::default()).contains("second burst"));
    }

    #[test]
    fn numbers_that_were_not_asked_for_are_dashes() {
        let counts = MatchCounts { keypoints_a: 100, keypoints_b: 50, putative: 20, inliers: None };
        let values: Vec<String> = rows(&counts).into_iter().map(|row| row.2).collect();
        assert_eq!(values, ["100 + 50", "20", "–", "0.300", "–", "–"]);
    }
}
