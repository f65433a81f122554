//! List of the paired cameras, with their errors and points.

use super::plane_view::points_of;
use crate::app::project::trajectories::Trajectories;
use egui::{Align, Label, Layout, RichText, Sense, Ui};
use egui_extras::{Column, TableBuilder};

const ROW_HEIGHT: f32 = 18.0;

/// Headings of the columns, and their meanings.
const HEADINGS: [(&str, &str); 4] = [
    ("image", "The image's name, or the time"),
    ("error", "Distance of the camera's centre from the true one, in the truth's unit"),
    ("angle °", "Angle between the camera's directions and the true ones, degrees"),
    ("3D points", "Points of the sparse model that the image sees"),
];

/// Draws the list.
pub fn camera_list_ui(ui: &mut Ui, trajectories: &mut Trajectories) {
    let Some(report) = trajectories.report().cloned() else {
        ui.centered_and_justified(|ui| ui.weak("Cameras that have a true one are listed here"));
        return;
    };
    let (mut clicked, mut hovered) = (None, None);
    let scroll_id = ui.scope_id().with("scrolled to");
    let scrolled_to: Option<usize> = ui.data(|d| d.get_temp(scroll_id)).flatten();
    let mut table = TableBuilder::new(ui)
        .striped(true)
        .sense(Sense::click())
        .cell_layout(Layout::left_to_right(Align::Center))
        .min_scrolled_height(0.0)
        .auto_shrink(false)
        .column(Column::remainder().at_least(120.0))
        .columns(Column::exact(84.0), HEADINGS.len() - 1);
    if let Some(row) = trajectories.selected.filter(|_| trajectories.selected != scrolled_to) {
        table = table.scroll_to_row(row, None);
    }
    table
        .header(20.0, |mut header| {
            for (column, (heading, help)) in HEADINGS.into_iter().enumerate() {
                let (_, cell) = header.col(|ui| cell_ui(ui, column, RichText::new(heading).small()));
                cell.on_hover_text(help);
            }
        })
        .body(|body| {
            body.rows(ROW_HEIGHT, report.pairs.len(), |mut row| {
                let index = row.index();
                let pair = &report.pairs[index];
                row.set_selected(trajectories.selected == Some(index));
                row.set_hovered(trajectories.hovered == Some(index));
                let points = points_of(trajectories, pair.estimate).map_or("–".to_owned(), |n| n.to_string());
                let texts = [
                    pair.label.clone(),
                    format!("{:.4}", pair.translation_error),
                    format!("{:.3}", pair.rotation_error_deg),
                    points,
                ];
                for (column, text) in texts.into_iter().enumerate() {
                    row.col(|ui| cell_ui(ui, column, RichText::new(text).monospace()));
                }
                let response = row.response();
                let label = format!("Camera {}", pair.label);
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Row, true, &label));
                if response.hovered() {
                    hovered = Some(index);
                }
                if response.clicked() {
                    clicked = Some(index);
                }
                if response.double_clicked() {
                    trajectories.wanted = Some(pair.label.clone());
                }
            });
        });
    if hovered.is_some() {
        trajectories.hovered = hovered;
    }
    if clicked.is_some() {
        trajectories.selected = clicked;
    }
    let shown = trajectories.selected;
    ui.data_mut(|d| d.insert_temp(scroll_id, shown));
}

/// Draws a cell: names at its left end, numbers at its right.
fn cell_ui(ui: &mut Ui, column: usize, text: RichText) {
    let label = Label::new(text).selectable(false).extend();
    if column == 0 {
        ui.add(label);
    } else {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.add(label));
    }
}
