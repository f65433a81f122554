//! Features of A that are no inliers: the stage at which each was lost, and the number lost at each stage.

use crate::app::panel::sorted_table::ROW_HEIGHT;
use crate::app::panel::widgets::{make_room, progress_text, text_width};
use crate::app::project::Model;
use crate::app::project::pair::lost_label;
use crate::inspect::unmatched::Lost;
use egui::{Align, Label, Layout, RichText, Sense, Ui};
use egui_extras::{Column, TableBuilder};

/// Draws the switch between matches and unmatched features, and the summary of the pair.
pub fn switch_ui(ui: &mut Ui, model: &mut Model) {
    ui.horizontal_wrapped(|ui| {
        ui.selectable_value(&mut model.pair.lost.listed, false, "Matches");
        ui.selectable_value(&mut model.pair.lost.listed, true, "Unmatched features of A")
            .on_hover_text("Features of A that are not inliers, and the step at which each was lost");
        ui.separator();
        if let Some(running) = &model.pair.lost.wanted.running() {
            ui.weak(progress_text(running));
            return;
        }
        if model.losses().is_none() {
            return;
        }
        ui.label(RichText::new("Lost to").small().weak());
        for lost in Lost::ALL.into_iter().filter(|lost| *lost != Lost::Not) {
            let text = format!("{} {}", lost_label(lost), model.pair.lost.count(lost));
            let mut on = !model.pair.lost.hidden.contains(&lost);
            let spacing = ui.spacing();
            let mark = spacing.icon_width + spacing.icon_spacing;
            make_room(ui, mark + text_width(ui, &text));
            if ui.checkbox(&mut on, text).on_hover_text(help(lost)).changed() {
                model.pair.lost.hidden.retain(|hidden| *hidden != lost);
                if !on {
                    model.pair.lost.hidden.push(lost);
                }
                model.pair.lost.listed = true;
            }
        }
    });
}

fn help(lost: Lost) -> &'static str {
    match lost {
        Lost::Not => "Inliers",
        Lost::NoKeypoint => "B has no keypoint of its size where the geometry expects it",
        Lost::RatioTest => "The second nearest descriptor is almost as near as the nearest",
        Lost::MutualCheck => "The nearest in B is nearer to another feature of A",
        Lost::Geometry => "Matched, but the match does not fit the geometry",
    }
}

/// Draws the table; a click asks why the feature has no match.
pub fn lost_table_ui(ui: &mut Ui, model: &mut Model) {
    let Some(found) = model.losses().cloned() else {
        ui.weak("There are no matches yet.");
        return;
    };
    let hidden = &model.pair.lost.hidden;
    let listed: Vec<usize> = (0..found.lost.len())
        .filter(|&index| found.lost[index] != Lost::Not && !hidden.contains(&found.lost[index]))
        .collect();
    let asked = model.asked_feature();
    let mut clicked = None;
    TableBuilder::new(ui)
        .striped(true)
        .sense(Sense::click())
        .cell_layout(Layout::left_to_right(Align::Center))
        .min_scrolled_height(0.0)
        .auto_shrink(false)
        .column(Column::exact(50.0))
        .column(Column::exact(120.0))
        .columns(Column::exact(60.0), 2)
        .column(Column::exact(50.0))
        .column(Column::exact(100.0))
        .column(Column::remainder())
        .header(20.0, |mut header| {
            for heading in ["#", "Lost to", "u", "v", "σ", "Slope", "SNR"] {
                header.col(|ui| {
                    ui.label(RichText::new(heading).small());
                });
            }
        })
        .body(|body| {
            body.rows(ROW_HEIGHT, listed.len(), |mut row| {
                let index = listed[row.index()];
                let f = &found.request.request.a.features[index];
                row.set_selected(asked == Some(index));
                let cells = [
                    format!("{}", index + 1),
                    lost_label(found.lost[index]).to_owned(),
                    format!("{:.1}", f.u),
                    format!("{:.1}", f.v),
                    format!("{:.2}", f.sigma),
                    format!("{:+.2}, {:+.2}", f.slope.u, f.slope.v),
                    format!("{:.1}", f.snr),
                ];
                for text in cells {
                    row.col(|ui| {
                        ui.add(Label::new(RichText::new(text).monospace()).selectable(false).extend());
                    });
                }
                let response = row.response();
                let name = format!("Unmatched feature {}", index + 1);
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Row, true, &name));
                if response.clicked() {
                    clicked = Some(index);
                }
            });
        });
    if let Some(index) = clicked {
        model.ask_feature((asked != Some(index)).then_some(index));
    }
}
