//! The table of matches: a click on a heading sorts, a click on a row selects. Only the visible rows are drawn, however many there are.

use crate::app::panels::table::{ROW_HEIGHT, cell_ui, heading_ui};
use crate::app::state::Model;
use crate::app::state::pair::MatchColumn;
use egui::{Align, Layout, RichText, Sense, Ui};
use egui_extras::{Column as TableColumn, TableBuilder};

/// Draws the table; answers the match whose row is pointed at.
pub fn table_ui(ui: &mut Ui, model: &mut Model) -> Option<usize> {
    let matches = model.pair.matches.clone()?;
    let pair = &mut model.pair;
    let selected_row = pair.selected.and_then(|s| pair.listed.iter().position(|&i| i == s));
    let scroll_id = ui.scope_id().with("match scrolled to");
    let scrolled_to: Option<usize> = ui.data(|d| d.get_temp(scroll_id)).flatten();
    let (mut order, mut clicked, mut hovered) = (pair.order, None, None);
    ui.spacing_mut().item_spacing.x = 4.0;
    egui::ScrollArea::horizontal().auto_shrink(false).show(ui, |ui| {
        let mut table = TableBuilder::new(ui)
            .striped(true)
            .sense(Sense::click())
            .cell_layout(Layout::left_to_right(Align::Center))
            .auto_shrink(false)
            .column(TableColumn::exact(36.0))
            .columns(TableColumn::remainder().at_least(47.0), MatchColumn::ALL.len() - 1);
        // Follow the selection when it was made elsewhere, and only then.
        if let Some(row) = selected_row.filter(|_| pair.selected != scrolled_to) {
            table = table.scroll_to_row(row, None);
        }
        table
            .header(20.0, |mut header| {
                for column in MatchColumn::ALL {
                    let sorted = (pair.order.column == column).then_some(pair.order.descending);
                    let (_, cell) = header.col(|ui| heading_ui(ui, column.heading(), sorted));
                    let name = format!("Sort by {}", column.heading());
                    cell.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
                    if cell.on_hover_text(column.help()).clicked() {
                        order = pair.order.clicked(column);
                    }
                }
            })
            .body(|body| {
                body.rows(ROW_HEIGHT, pair.listed.len(), |mut line| {
                    let index = pair.listed[line.index()];
                    let Some(row) = matches.row(index) else { return };
                    line.set_selected(pair.selected == Some(index));
                    line.set_hovered(pair.hovered == Some(index));
                    for column in MatchColumn::ALL {
                        line.col(|ui| cell_ui(ui, RichText::new(column.text(&row)).monospace()));
                    }
                    let response = line.response();
                    let name = format!("Match {}", index + 1);
                    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Row, true, &name));
                    if response.hovered() {
                        hovered = Some(index);
                    }
                    if response.clicked() {
                        clicked = Some(index);
                    }
                });
            });
    });
    ui.data_mut(|d| d.insert_temp(scroll_id, pair.selected));
    pair.order = order;
    if let Some(index) = clicked {
        pair.selected = if pair.selected == Some(index) { None } else { Some(index) };
        ui.data_mut(|d| d.insert_temp(scroll_id, pair.selected));
    }
    hovered
}
