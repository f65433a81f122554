//! Tabs below the pictures: the table of features, the tally, the noise, and measurements on the pictures.

use crate::app::actions::ActionId;
use crate::app::document::{Action, Queue, Side};
use crate::app::inspector::PaneWidgets;
use crate::app::measure::{profile_ui, region_ui};
use crate::app::panel::widgets::with_whole_numbers;
use crate::app::panel::{against, methods, noise, slopes, table, tally};
use crate::app::parts::mark;
use crate::app::results::{FoundFeatures, Read};
use crate::teach::{BottomTab, Part};
use egui::{Align, Label, Layout, Ui};

/// Minimum width with widely spaced tabs, in points.
const ROOMY: f32 = 600.0;

const TABS: [(BottomTab, &str, &str); 8] = [
    (BottomTab::Table, "Table", "A row for each feature"),
    (BottomTab::Tally, "Tally", "How many candidates each test rejected"),
    (BottomTab::Noise, "Noise", "The noise that was measured"),
    (BottomTab::Slopes, "Slopes", "Features and evidence at each slope, and advice on range, step and direction"),
    (BottomTab::Profile, "Profile", "Values along a line; draw one with Q"),
    (BottomTab::Region, "Region", "Statistics of a rectangle; draw one with Shift+Q"),
    (BottomTab::Compared, "Compared", "Features against a pinned result, features from a file, or the truth"),
    (BottomTab::Methods, "Methods", "Numbers of the methods that are compared, and which of them are shown"),
];

/// Whether `tab` has something to show, or is the chosen one.
fn has_content(tab: BottomTab, model: Read<'_>) -> bool {
    let compared = &model.results.slots[model.active_side()].comparison;
    let is_filled = match tab {
        BottomTab::Profile => model.document.measure.line.is_some(),
        BottomTab::Region => model.document.measure.region.is_some(),
        BottomTab::Compared => compared.shown.is_some() || compared.problem().is_some(),
        BottomTab::Methods => model.document.compares_methods(),
        _ => true,
    };
    is_filled || model.document.bottom_tab == tab
}

pub fn closed_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let names: Vec<&str> = TABS.iter().filter(|(tab, ..)| has_content(*tab, model)).map(|(_, name, _)| *name).collect();
    let tabs = ui.selectable_label(false, format!("⏶ {}", names.join(" · ")));
    mark(ui, Part::Tabs, tabs.rect);
    queue.push_if(tabs.on_hover_text("Open the panel below").clicked(), ActionId::ToggleBottom);
}

/// Draws a line about what was found, with its tip; `None` where that is not known yet.
fn summary_ui(ui: &mut Ui, model: Read<'_>, summary: fn(Read<'_>, &FoundFeatures) -> Option<[String; 2]>) {
    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
        match model.found_of(Side::A).map(|found| summary(model, found)) {
            Some(Some([text, tip])) => ui.add(Label::new(with_whole_numbers(&text)).truncate()).on_hover_text(tip),
            Some(None) => ui.weak("Not analysed yet"),
            None => ui.weak("No detection yet"),
        }
    });
}

pub fn bottom_ui(ui: &mut Ui, model: Read<'_>, widgets: &PaneWidgets, queue: &mut Queue) {
    // Widgets beside the tabs go below them where there is no space.
    let tabs = ui.horizontal_wrapped(|ui| {
        if ui.available_width() < ROOMY {
            (ui.spacing_mut().button_padding.x, ui.spacing_mut().item_spacing.x) = (4.0, 3.0);
        }
        // The open one closes the panel, any other opens it.
        for (tab, name, help) in TABS.into_iter().filter(|(tab, ..)| has_content(*tab, model)) {
            let is_open = model.shows_bottom() && model.document.bottom_tab == tab;
            let response = ui.selectable_label(is_open, name).on_hover_text(help);
            queue.push_if(response.clicked(), Action::ToggleTab(tab));
        }
        ui.separator();
        match model.document.bottom_tab {
            BottomTab::Table => table::filter_bar_ui(ui, model, queue),
            BottomTab::Tally => summary_ui(ui, model, tally::summary),
            BottomTab::Noise => summary_ui(ui, model, noise::summary),
            BottomTab::Slopes => summary_ui(ui, model, slopes::summary),
            BottomTab::Profile | BottomTab::Region | BottomTab::Compared | BottomTab::Methods => {}
        }
    });
    mark(ui, Part::Tabs, tabs.response.rect);
    ui.separator();
    mark(ui, Part::Below, ui.available_rect_before_wrap());
    // Usually it stands below the parameters.
    if matches!(model.document.bottom_tab, BottomTab::Table | BottomTab::Tally) && !model.shows_left() {
        slopes::verdict_ui(ui, model, queue);
    }
    match model.document.bottom_tab {
        BottomTab::Table => table::table_ui(ui, model, queue),
        BottomTab::Tally => tally::tally_ui(ui, model, queue),
        BottomTab::Noise => noise::noise_ui(ui, model, queue),
        BottomTab::Slopes => slopes::slopes_ui(ui, model, queue),
        BottomTab::Profile => profile_ui(ui, model, widgets, queue),
        BottomTab::Region => region_ui(ui, model, widgets, queue),
        BottomTab::Compared => against::against_ui(ui, model, widgets, queue),
        BottomTab::Methods => methods::table_ui(ui, model, queue),
    }
}
