//! List of matched pairs: a click on a heading sorts, a click on a row selects, a second one opens.

use crate::app::project::datasets::Dataset;
use crate::app::project::datasets::pairs::{BurstPair, PairColumn};
use egui::{Align, Label, Layout, RichText, Sense, Ui};
use egui_extras::{Column, TableBuilder};

const ROW_HEIGHT: f32 = 18.0;
const COLUMN_WIDTH: f32 = 50.0;

/// Draws the list. Returns the double-clicked pair.
pub fn pair_list_ui(ui: &mut Ui, dataset: &mut Dataset) -> Option<BurstPair> {
    if dataset.matches.is_empty() {
        ui.centered_and_justified(|ui| ui.weak("Match pairs to see them here"));
        return None;
    }
    let rows = dataset.matches.listed();
    let selected = dataset.selected();
    let (mut order, mut clicked, mut opened) = (dataset.matches.order, None, None);
    let scroll_id = ui.scope_id().with("scrolled to");
    let scrolled_to: Option<BurstPair> = ui.data(|d| d.get_temp(scroll_id)).flatten();
    ui.spacing_mut().item_spacing.x = 2.0;
    let mut table = TableBuilder::new(ui)
        .striped(true)
        .sense(Sense::click())
        .cell_layout(Layout::left_to_right(Align::Center))
        .min_scrolled_height(0.0)
        .auto_shrink(false)
        .column(Column::remainder().at_least(120.0))
        .columns(Column::exact(COLUMN_WIDTH), PairColumn::ALL.len() - 1);
    // Scrolls to the selection once, when it was made elsewhere.
    if let Some(row) = rows.iter().position(|(p, _)| Some(*p) == selected).filter(|_| selected != scrolled_to) {
        table = table.scroll_to_row(row, None);
    }
    table
        .header(20.0, |mut header| {
            for column in PairColumn::ALL {
                let arrow = match (order.column == column, order.descending) {
                    (false, _) => "",
                    (true, true) => " ⏷",
                    (true, false) => " ⏶",
                };
                let text = RichText::new(format!("{}{arrow}", column.heading())).small();
                let (_, cell) = header.col(|ui| cell_ui(ui, column, text));
                let name = format!("Sort by {}", column.heading());
                cell.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
                if cell.on_hover_text(column.help()).clicked() {
                    order = order.clicked(column);
                }
            }
        })
        .body(|body| {
            body.rows(ROW_HEIGHT, rows.len(), |mut row| {
                let (pair, counts) = rows[row.index()];
                row.set_selected(selected == Some(pair));
                let names = format!("{} – {}", dataset.bursts[pair.0].name, dataset.bursts[pair.1].name);
                for column in PairColumn::ALL {
                    let text = if column == PairColumn::Pair { names.clone() } else { column.text(&counts) };
                    row.col(|ui| cell_ui(ui, column, RichText::new(text).monospace()));
                }
                let response = row.response();
                let label = format!("Pair {names}");
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Row, true, &label));
                if response.clicked() {
                    clicked = Some(pair);
                }
                if response.double_clicked() {
                    opened = Some(pair);
                }
            });
        });
    dataset.matches.order = order;
    if let Some(pair) = clicked {
        dataset.select(pair);
    }
    let shown = dataset.selected();
    ui.data_mut(|d| d.insert_temp(scroll_id, shown));
    opened
}

/// Draws a cell: names at its left end, numbers at its right.
fn cell_ui(ui: &mut Ui, column: PairColumn, text: RichText) {
    let label = Label::new(text).selectable(false).extend();
    if column == PairColumn::Pair {
        ui.add(label);
    } else {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.add(label));
    }
}
