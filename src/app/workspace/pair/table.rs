//! The table of matches.

use crate::app::actions::{ActionId, Queue};
use crate::app::clipboard::match_text;
use crate::app::inspector::copy_ui;
use crate::app::panel::sorted_table::{Listed, SortedColumn, sorted_table_ui};
use crate::app::project::Model;
use crate::app::project::pair::{MatchColumn, MatchRow};
use egui::{RichText, Ui};

impl SortedColumn for MatchColumn {
    const COLUMNS: &'static [Self] = &Self::ALL;

    fn heading(self) -> &'static str {
        Self::heading(self)
    }

    fn help(self) -> &'static str {
        Self::help(self)
    }

    fn width(self) -> f32 {
        if self == Self::Number { 36.0 } else { 47.0 }
    }
}

/// What can be done with one match; answers whether it is to be gone to.
pub(crate) fn match_menu_ui(ui: &mut Ui, row: &MatchRow<'_>) -> bool {
    ui.set_min_width(150.0);
    ui.label(RichText::new(format!("Match {}", row.index + 1)).small().weak());
    let go = ui
        .button("Go to match")
        .on_hover_text("Show both features, each in the motion stack at its own slope")
        .clicked();
    copy_ui(ui, "Copy row", || match_text(row));
    go
}

/// Draws the table; answers the match whose row is pointed at.
pub fn table_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) -> Option<usize> {
    let matches = model.pair.matches.clone()?;
    let pair = &mut model.pair;
    let listed = Listed { items: &pair.listed, selected: pair.selected, hovered: pair.hovered };
    let text = |column: MatchColumn, index: usize| matches.row(index).map_or_else(String::new, |row| column.text(&row));
    let mut chosen = None;
    let menu = |ui: &mut Ui, index: usize| {
        let Some(row) = matches.row(index) else { return };
        if match_menu_ui(ui, &row) {
            chosen = Some(index);
        }
    };
    let pointed = sorted_table_ui(ui, pair.order, &listed, text, |index| format!("Match {}", index + 1), menu);
    (pair.order, pair.selected) = (pointed.order, chosen.or(pointed.selected));
    if chosen.is_some() {
        queue.push(ActionId::GoToFeature);
    }
    pointed.hovered
}
