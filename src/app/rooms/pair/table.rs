//! The table of matches.

use crate::app::panels::sorted_table::{Listed, SortedColumn, sorted_table_ui};
use crate::app::state::Model;
use crate::app::state::pair::MatchColumn;
use egui::Ui;

impl SortedColumn for MatchColumn {
    const COLUMNS: &'static [Self] = &Self::ALL;

    fn heading(self) -> &'static str {
        Self::heading(self)
    }

    fn help(self) -> &'static str {
        Self::help(self)
    }
}

/// Draws the table; answers the match whose row is pointed at.
pub fn table_ui(ui: &mut Ui, model: &mut Model) -> Option<usize> {
    let matches = model.pair.matches.clone()?;
    let pair = &mut model.pair;
    let listed = Listed { items: &pair.listed, selected: pair.selected, hovered: pair.hovered };
    let text = |column: MatchColumn, index: usize| matches.row(index).map_or_else(String::new, |row| column.text(&row));
    let pointed = sorted_table_ui(ui, pair.order, &listed, text, |index| format!("Match {}", index + 1));
    (pair.order, pair.selected) = (pointed.order, pointed.selected);
    pointed.hovered
}
