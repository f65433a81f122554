//! Below the picture: the table of features, the tally and the noise, as tabs.

use crate::app::actions::Queue;
use crate::app::state::{BottomTab, Model};
use egui::{Align, Layout, Ui};

/// Draws the tabs and the one that is open.
pub fn bottom_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    ui.horizontal(|ui| {
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Table, "Table");
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Tally, "Tally");
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Noise, "Noise");
        ui.separator();
        match model.bottom_tab {
            BottomTab::Table => super::filter_bar::filter_bar_ui(ui, model, queue),
            BottomTab::Tally => {
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| super::tally::summary_ui(ui, model));
            }
            BottomTab::Noise => {
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| super::noise::summary_ui(ui, model));
            }
        }
    });
    ui.separator();
    match model.bottom_tab {
        BottomTab::Table => super::table::table_ui(ui, model),
        BottomTab::Tally => super::tally::tally_ui(ui, model),
        BottomTab::Noise => super::noise::noise_ui(ui, model),
    }
}
