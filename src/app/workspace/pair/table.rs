//! Table of matches.

use crate::app::actions::{ActionId, Queue};
use crate::app::inspector::match_menu_ui;
use crate::app::panel::sorted_table::{Listed, SortedColumn, sorted_table_ui};
use crate::app::project::Model;
use crate::app::project::pair::MatchColumn;
use egui::Ui;

impl SortedColumn for MatchColumn {
    const COLUMNS: &'static [Self] = &Self::ALL;

    fn heading(self) -> &'static str {
        Self::heading(self)
    }

    fn help(self) -> &'static str {
        Self::help(self)
    }

    fn word(self) -> Option<&'static str> {
        match self {
            Self::Number | Self::UA | Self::VA | Self::UB | Self::VB => None,
            Self::SigmaA | Self::SigmaB => Some("scale"),
            Self::SlopeA | Self::SlopeB => Some("slope"),
            Self::Distance => Some("descriptor"),
            Self::Ratio => Some("ratio-test"),
            Self::Error => Some("epipolar-line"),
            Self::Inlier => Some("inlier"),
        }
    }

    fn width(self) -> f32 {
        if self == Self::Number { 36.0 } else { 47.0 }
    }
}

/// Draws the table; returns the match whose row is under the pointer.
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
