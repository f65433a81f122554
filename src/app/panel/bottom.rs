//! Tabs below the pictures: the table of features, the tally, the noise, and measurements on the pictures.

use crate::app::actions::Queue;
use crate::app::inspector::PaneWidgets;
use crate::app::measure::{RegionCache, profile_ui, region_ui};
use crate::app::parts::mark;
use crate::app::project::{BottomTab, Model};
use crate::teach::Part;
use egui::{Align, Layout, Ui};

/// Minimum width with widely spaced tabs, in points.
const ROOMY: f32 = 600.0;

/// Draws the tabs and the content of the open one.
pub fn bottom_ui(ui: &mut Ui, model: &mut Model, widgets: &PaneWidgets, regions: &mut RegionCache, queue: &mut Queue) {
    // Widgets beside the tabs go below them where there is no space.
    let tabs = ui.horizontal_wrapped(|ui| {
        if ui.available_width() < ROOMY {
            (ui.spacing_mut().button_padding.x, ui.spacing_mut().item_spacing.x) = (4.0, 3.0);
        }
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Table, "Table");
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Tally, "Tally");
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Noise, "Noise");
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Slopes, "Slopes")
            .on_hover_text("Features and evidence at each slope, and advice on range, step and direction");
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Profile, "Profile")
            .on_hover_text("Values along a line; draw one with Q");
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Region, "Region")
            .on_hover_text("Statistics of a rectangle; draw one with Shift+Q");
        ui.selectable_value(&mut model.bottom_tab, BottomTab::Compared, "Compared")
            .on_hover_text("Features against a pinned result, features from a file, or the truth");
        ui.separator();
        match model.bottom_tab {
            BottomTab::Table => crate::app::panel::table::filter_bar_ui(ui, model, queue),
            BottomTab::Tally => {
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    crate::app::panel::tally::summary_ui(ui, model);
                });
            }
            BottomTab::Noise => {
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    crate::app::panel::noise::summary_ui(ui, model);
                });
            }
            BottomTab::Slopes => {
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    crate::app::panel::slopes::summary_ui(ui, model);
                });
            }
            BottomTab::Profile | BottomTab::Region | BottomTab::Compared => {}
        }
    });
    mark(ui, Part::Tabs, tabs.response.rect);
    ui.separator();
    mark(ui, Part::Below, ui.available_rect_before_wrap());
    match model.bottom_tab {
        BottomTab::Table => {
            crate::app::panel::status::advice_ui(ui, model, queue);
            crate::app::panel::table::table_ui(ui, model, queue);
        }
        BottomTab::Tally => crate::app::panel::tally::tally_ui(ui, model, queue),
        BottomTab::Noise => crate::app::panel::noise::noise_ui(ui, model),
        BottomTab::Slopes => crate::app::panel::slopes::slopes_ui(ui, model),
        BottomTab::Profile => profile_ui(ui, model, widgets, queue),
        BottomTab::Region => region_ui(ui, model, widgets, regions, queue),
        BottomTab::Compared => crate::app::panel::against::against_ui(ui, model, widgets, queue),
    }
}
