//! Choice of the matches drawn, and of their style, with the key to their colours and strokes.

use crate::app::canvas::overlay::LineKind;
use crate::app::panel::widgets::section_ui;
use crate::app::project::Model;
use egui::{Color32, Sense, Stroke, Ui, vec2};

/// Draws the section.
pub fn switches_ui(ui: &mut Ui, model: &mut Model) {
    section_ui(ui, "Matches", |ui| {
        let verified = model.pair.matches.as_ref().is_none_or(|m| m.result.verification.is_some());
        let counts = model.pair.matches.as_ref().map(|m| m.result.counts);
        let inliers = counts.map(|c| c.inliers.unwrap_or(c.putative));
        let outliers = counts.and_then(|c| c.inliers.map(|inliers| c.putative - inliers));
        let look = &mut model.pair.look;
        let (kind, label) = if verified { (LineKind::Inlier, "Inliers") } else { (LineKind::Unverified, "Putative") };
        kind_ui(
            ui,
            &mut look.inliers,
            kind,
            label,
            inliers,
            "Matches that agree with the geometry of the two views  (I)",
        );
        if verified {
            let tip = "Matches that do not agree with the geometry of the two views  (U)";
            kind_ui(ui, &mut look.outliers, LineKind::Outlier, "Outliers", outliers, tip);
        }
        ui.horizontal(|ui| {
            let label = crate::app::panel::widgets::label_ui(ui, "Opacity", 52.0);
            ui.spacing_mut().slider_width = (ui.available_width() - 16.0).max(40.0);
            let slider = egui::Slider::new(&mut look.opacity, 0.05..=1.0).show_value(false);
            crate::app::panel::widgets::hint(ui.add(slider).labelled_by(label.id), "How strongly the lines are drawn");
        });
        let boxes = [
            (&mut look.alone, "Selected alone", "Draw the selected match alone, without the others  (X)"),
            (&mut look.geometry, "Epipolar lines", "Lines of the other picture on which the partners must lie  (E)"),
            (&mut look.features, "All features", "Draw all features over both pictures  (O)"),
        ];
        for (on, label, tip) in boxes {
            ui.checkbox(on, label).on_hover_text(tip);
        }
    });
}

/// Draws a switch for one kind of match, with a piece of its line and the number of matches.
fn kind_ui(ui: &mut Ui, on: &mut bool, kind: LineKind, label: &str, count: Option<usize>, tip: &str) {
    ui.horizontal(|ui| {
        ui.checkbox(on, label).on_hover_text(tip);
        let (rect, _) = ui.allocate_exact_size(vec2(42.0, 14.0), Sense::hover());
        // Dark as the pictures, so that it looks alike in the light theme.
        ui.painter().rect_filled(rect, 3.0, Color32::from_gray(40));
        let (from, to) = (rect.left_center() + vec2(4.0, 0.0), rect.right_center() - vec2(4.0, 0.0));
        let stroke = Stroke::new(2.0, kind.colour());
        if kind.is_dashed() {
            ui.painter().extend(egui::Shape::dashed_line(&[from, to], stroke, 6.0, 4.5));
        } else {
            ui.painter().line_segment([from, to], stroke);
        }
        if let Some(count) = count {
            ui.weak(count.to_string());
        }
    });
}
