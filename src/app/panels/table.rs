//! The table of features: a click on a heading sorts, a click on a row selects. Only the visible rows are drawn, however many there are.

use crate::app::state::Model;
use crate::app::state::filter::Column;
use egui::{Align, Label, Layout, RichText, Sense, Ui};
use egui_extras::{Column as TableColumn, TableBuilder};

/// Height of a row, in points.
pub(in crate::app) const ROW_HEIGHT: f32 = 18.0;

/// Draws the table.
pub fn table_ui(ui: &mut Ui, model: &mut Model) {
    if model.found.is_none() {
        ui.centered_and_justified(|ui| ui.weak("Press Detect to find features"));
        return;
    }
    let selected_row = model.selected.and_then(|s| model.listed.iter().position(|&i| i == s));
    let scroll_id = ui.scope_id().with("scrolled to");
    let scrolled_to: Option<usize> = ui.data(|d| d.get_temp(scroll_id)).flatten();
    let mut order = model.order;
    let mut clicked = None;
    let mut hovered = None;
    ui.spacing_mut().item_spacing.x = 4.0;
    egui::ScrollArea::horizontal().auto_shrink(false).show(ui, |ui| {
        let mut table = TableBuilder::new(ui)
            .striped(true)
            .sense(Sense::click())
            .cell_layout(Layout::left_to_right(Align::Center))
            .auto_shrink(false)
            .column(TableColumn::exact(36.0))
            .columns(TableColumn::remainder().at_least(47.0), Column::ALL.len() - 1);
        // Follow the selection when it was made elsewhere, and only then.
        if let Some(row) = selected_row.filter(|_| model.selected != scrolled_to) {
            table = table.scroll_to_row(row, None);
        }
        table
            .header(20.0, |mut header| {
                for column in Column::ALL {
                    let sorted = (model.order.column == column).then_some(model.order.descending);
                    let (_, cell) = header.col(|ui| heading_ui(ui, column.heading(), sorted));
                    let name = format!("Sort by {}", column.heading());
                    cell.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
                    if cell.on_hover_text(column.help()).clicked() {
                        order = model.order.clicked(column);
                    }
                }
            })
            .body(|body| {
                body.rows(ROW_HEIGHT, model.listed.len(), |mut row| {
                    let index = model.listed[row.index()];
                    let feature = model.features()[index];
                    row.set_selected(model.selected == Some(index));
                    row.set_hovered(model.hovered == Some(index));
                    for column in Column::ALL {
                        row.col(|ui| cell_ui(ui, RichText::new(column.text(index, &feature)).monospace()));
                    }
                    let response = row.response();
                    let name = format!("Feature {}", index + 1);
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
    ui.data_mut(|d| d.insert_temp(scroll_id, model.selected));
    model.order = order;
    if let Some(index) = hovered {
        model.hovered = Some(index);
    }
    if let Some(index) = clicked {
        model.selected = if model.selected == Some(index) { None } else { Some(index) };
        ui.data_mut(|d| d.insert_temp(scroll_id, model.selected));
    }
}

/// A heading; `sorted` says whether the table is sorted by it, and whether the largest come first.
pub(in crate::app) fn heading_ui(ui: &mut Ui, heading: &str, sorted: Option<bool>) {
    let arrow = match sorted {
        Some(true) => " ⏷",
        Some(false) => " ⏶",
        None => "",
    };
    let text = RichText::new(format!("{heading}{arrow}")).small();
    let text = if sorted.is_some() { text.strong() } else { text };
    cell_ui(ui, text);
}

/// A text at the right end of its cell. (The whole table cannot be laid out from the right: cells would then take clicks of their neighbours.)
pub(in crate::app) fn cell_ui(ui: &mut Ui, text: RichText) {
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        ui.add(Label::new(text).selectable(false).extend());
    });
}
