//! The menu bar, drawn from the registry.

use super::{ACTIONS, ActionId, Menu, Queue, checked, enabled, keys_text, tooltip};
use crate::app::state::Model;
use crate::engine::BurstSource;

/// Draws the menus. A recent burst that is chosen is put into `open_recent`.
pub fn menu_bar_ui(
    ui: &mut egui::Ui,
    model: &Model,
    recent: &[BurstSource],
    queue: &mut Queue,
    open_recent: &mut Option<BurstSource>,
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
                        recent_ui(ui, recent, open_recent);
                    }
                }
            });
        }
    });
}

/// One item of a menu.
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
    let response = ui.add_enabled(enabled(id, model), button).on_hover_text(tooltip(ui.ctx(), action));
    if response.clicked() {
        queue.push(id);
        ui.close();
    }
}

fn recent_ui(ui: &mut egui::Ui, recent: &[BurstSource], open_recent: &mut Option<BurstSource>) {
    ui.add_enabled_ui(!recent.is_empty(), |ui| {
        ui.menu_button("Open recent", |ui| {
            for source in recent {
                let response = ui.button(source.label());
                let response = match source {
                    BurstSource::Paths(paths) => {
                        let lines: Vec<String> = paths.iter().take(8).map(|p| p.display().to_string()).collect();
                        response.on_hover_text(lines.join("\n"))
                    }
                    BurstSource::Demo | BurstSource::DemoLater => response,
                };
                if response.clicked() {
                    *open_recent = Some(source.clone());
                    ui.close();
                }
            }
        });
    });
}
