//! Menu bar, drawn from the registry.

use super::{ACTIONS, ActionId, Menu, Queue, checked, enabled, keys_text, tooltip};
use crate::app::project::Model;
use crate::app::settings::{Recent, Settings};
use crate::app::words::explained;
use crate::dataset::DatasetSource;
use crate::requests::BurstSource;
use std::path::PathBuf;

/// Draws the menus. A chosen entry of the recently opened ones is put into `open_recent`.
pub fn menu_bar_ui(
    ui: &mut egui::Ui,
    model: &Model,
    remembered: &Settings,
    queue: &mut Queue,
    open_recent: &mut Option<Recent>,
) {
    egui::MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL {
            ui.menu_button(menu.label(), |ui| {
                ui.set_min_width(230.0);
                let mut last_group = None;
                for action in ACTIONS.iter().filter(|a| a.menu == menu) {
                    if last_group.is_some_and(|g| g != action.group) {
                        ui.separator();
                    }
                    last_group = Some(action.group);
                    item_ui(ui, model, queue, action.id);
                    if action.id == ActionId::OpenDemo {
                        recent_ui(ui, remembered, open_recent);
                    }
                }
            });
        }
    });
}

/// Draws one item of a menu.
pub fn item_ui(ui: &mut egui::Ui, model: &Model, queue: &mut Queue, id: ActionId) {
    let action = id.action();
    let mark = match checked(id, model) {
        Some(true) => "✔ ",
        Some(false) | None => "",
    };
    let mut button = egui::Button::new(format!("{mark}{}", action.label));
    if let Some(shortcut) = &action.shortcut {
        button = button.shortcut_text(keys_text(ui.ctx(), shortcut));
    }
    let response = explained(ui.add_enabled(enabled(id, model), button), tooltip(ui.ctx(), action), id.word());
    if response.clicked() {
        queue.push(id);
        ui.close();
    }
}

fn recent_ui(ui: &mut egui::Ui, remembered: &Settings, open_recent: &mut Option<Recent>) {
    let Settings { recent, datasets, .. } = remembered;
    ui.add_enabled_ui(!(recent.is_empty() && datasets.is_empty()), |ui| {
        ui.menu_button("Open recent", |ui| {
            let mut item = |ui: &mut egui::Ui, label: String, paths: &[PathBuf], what: Recent| {
                let lines: Vec<String> = paths.iter().take(8).map(|p| p.display().to_string()).collect();
                if ui.button(label).on_hover_text(lines.join("\n")).clicked() {
                    *open_recent = Some(what);
                    ui.close();
                }
            };
            for source in recent {
                let paths = if let BurstSource::Paths(paths) = source { &paths[..] } else { &[] };
                item(ui, source.label(), paths, Recent::Burst(source.clone()));
            }
            if !(recent.is_empty() || datasets.is_empty()) {
                ui.separator();
            }
            for source in datasets {
                item(ui, dataset_label(source), &source.paths, Recent::Dataset(source.clone()));
            }
        });
    });
}

/// Label of a dataset in a list of bursts and datasets.
pub fn dataset_label(source: &DatasetSource) -> String {
    match source.burst_length {
        Some(length) => format!("{}, in bursts of {length}", source.label()),
        None => format!("{}, a dataset", source.label()),
    }
}
