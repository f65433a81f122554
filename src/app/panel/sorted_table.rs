//! Table in which a click on a heading sorts and a click on a row selects. Only the visible rows are drawn, so that it
//! can be long.

use crate::app::project::filter::Order;
use crate::app::words::{explained, word};
use egui::{Align, Label, Layout, RichText, Sense, Ui};
use egui_extras::{Column as TableColumn, TableBuilder};

/// Height of a row, in points.
pub(in crate::app) const ROW_HEIGHT: f32 = 18.0;

/// Columns that a table can have.
pub(in crate::app) trait SortedColumn: Copy + PartialEq + 'static {
    /// All columns, from left to right.
    const COLUMNS: &'static [Self];
    /// Heading.
    fn heading(self) -> &'static str;
    /// Description, with the unit.
    fn help(self) -> &'static str;
    /// Name of the glossary entry for the column.
    fn word(self) -> Option<&'static str>;
    /// Width that the numbers need, points; the remaining space is shared.
    fn width(self) -> f32;
}

/// Items that a table lists, by their indices.
pub(in crate::app) struct Listed<'a> {
    /// Items in the table's order.
    pub items: &'a [usize],
    /// Selected item.
    pub selected: Option<usize>,
    /// Item under the pointer, here or elsewhere.
    pub hovered: Option<usize>,
}

/// Result of drawing the table.
pub(in crate::app) struct Pointed<C> {
    /// Order, changed by a click on a heading.
    pub order: Order<C>,
    /// Selected item after a click, or none.
    pub selected: Option<usize>,
    /// Item under the pointer.
    pub hovered: Option<usize>,
}

/// Draws the table. `text` is the content of an item's cell, `name` the item's name for screen readers, and `menu`
/// draws the menu that the secondary button opens on its row.
pub(in crate::app) fn sorted_table_ui<C: SortedColumn>(
    ui: &mut Ui,
    order: Order<C>,
    listed: &Listed<'_>,
    text: impl Fn(C, usize) -> String,
    name: impl Fn(usize) -> String,
    mut menu: impl FnMut(&mut Ui, usize),
) -> Pointed<C> {
    let &Listed { items, selected, hovered } = listed;
    let selected_row = selected.and_then(|s| items.iter().position(|&i| i == s));
    let scroll_id = ui.scope_id().with("scrolled to");
    let scrolled_to: Option<usize> = ui.data(|d| d.get_temp(scroll_id)).flatten();
    let mut pointed = Pointed { order, selected, hovered: None };
    ui.spacing_mut().item_spacing.x = 4.0;
    egui::ScrollArea::horizontal().auto_shrink(false).show(ui, |ui| {
        let mut table = TableBuilder::new(ui)
            .striped(true)
            .sense(Sense::click())
            .cell_layout(Layout::left_to_right(Align::Center))
            .min_scrolled_height(0.0)
            .auto_shrink(false)
            .column(TableColumn::exact(C::COLUMNS.first().map_or(0.0, |first| first.width())));
        for column in C::COLUMNS.iter().skip(1) {
            table = table.column(TableColumn::remainder().at_least(column.width()));
        }
        // Scrolls to the selection once, when it was made elsewhere.
        if let Some(row) = selected_row.filter(|_| selected != scrolled_to) {
            table = table.scroll_to_row(row, None);
        }
        table
            .header(20.0, |mut header| {
                for &column in C::COLUMNS {
                    let sorted = (order.column == column).then_some(order.descending);
                    let (_, cell) = header.col(|ui| heading_ui(ui, column.heading(), sorted));
                    let label = format!("Sort by {}", column.heading());
                    cell.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &label));
                    if explained(cell, column.help(), column.word().and_then(word)).clicked() {
                        pointed.order = order.clicked(column);
                    }
                }
            })
            .body(|body| {
                body.rows(ROW_HEIGHT, items.len(), |mut row| {
                    let index = items[row.index()];
                    row.set_selected(selected == Some(index));
                    row.set_hovered(hovered == Some(index));
                    for &column in C::COLUMNS {
                        row.col(|ui| cell_ui(ui, RichText::new(text(column, index)).monospace()));
                    }
                    let response = row.response();
                    let label = name(index);
                    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Row, true, &label));
                    response.context_menu(|ui| menu(ui, index));
                    if response.hovered() {
                        pointed.hovered = Some(index);
                    }
                    if response.clicked() {
                        pointed.selected = (selected != Some(index)).then_some(index);
                    }
                });
            });
    });
    ui.data_mut(|d| d.insert_temp(scroll_id, pointed.selected));
    pointed
}

/// Draws a heading; `sorted` is `Some` if the table is sorted by it, and true if the largest come first.
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

/// Draws a text at the right end of its cell. (The whole table cannot be laid out from the right: cells would then take
/// clicks of their neighbours.)
pub(in crate::app) fn cell_ui(ui: &mut Ui, text: RichText) {
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        ui.add(Label::new(text).selectable(false).extend());
    });
}
