//! The `?` sheet: every action with its keys, by menu.

use super::{ACTIONS, Menu, keys_text};
use egui::RichText;

/// Draws the sheet; `open` becomes false when it is closed.
pub fn sheet_ui(ctx: &egui::Context, open: &mut bool) {
    if !*open {
        return;
    }
    let modal = egui::Modal::new(egui::Id::unique("shortcuts sheet")).show(ctx, |ui| {
        let room = ui.ctx().content_rect().size();
        ui.set_width((room.x - 60.0).min(1280.0));
        ui.horizontal(|ui| {
            ui.heading("Keyboard shortcuts");
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.button("Close").clicked() {
                    ui.close();
                }
                ui.weak("In the picture: drag to pan, wheel to zoom, click to select");
            });
        });
        ui.separator();
        egui::ScrollArea::vertical().max_height(room.y - 110.0).min_scrolled_height(room.y - 110.0).show(ui, |ui| {
            ui.spacing_mut().item_spacing = egui::vec2(24.0, 1.0);
            ui.spacing_mut().interact_size.y = 16.0;
            // In a narrow window two columns stand below the two others.
            let beside = if room.x > 1150.0 { COLUMNS.len() } else { COLUMNS.len() / 2 };
            ui.columns(beside, |columns| {
                for (place, menus) in COLUMNS.iter().enumerate() {
                    for menu in *menus {
                        menu_ui(&mut columns[place % beside], *menu);
                    }
                }
            });
        });
    });
    if modal.should_close() {
        *open = false;
    }
}

/// Which menus go into which column: about the same number of rows in each.
const COLUMNS: [&[Menu]; 4] = [
    &[Menu::File, Menu::Cursor],
    &[Menu::View, Menu::Detect],
    &[Menu::Panes, Menu::Pair],
    &[Menu::Edit, Menu::Dataset, Menu::Features, Menu::Help],
];

fn menu_ui(ui: &mut egui::Ui, menu: Menu) {
    ui.add_space(2.0);
    ui.label(RichText::new(menu.label()).strong());
    for action in ACTIONS.iter().filter(|a| a.menu == menu) {
        ui.horizontal(|ui| {
            ui.label(action.label).on_hover_text(action.help);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if let Some(shortcut) = &action.shortcut {
                    key_ui(ui, &keys_text(ui.ctx(), shortcut));
                }
            });
        });
    }
    ui.add_space(4.0);
}

fn key_ui(ui: &mut egui::Ui, keys: &str) {
    let visuals = ui.visuals();
    egui::Frame::new()
        .fill(visuals.faint_bg_color)
        .stroke(visuals.widgets.noninteractive.bg_stroke)
        .corner_radius(3)
        .inner_margin(egui::Margin::symmetric(5, 0))
        .show(ui, |ui| ui.label(RichText::new(keys).monospace().size(11.0)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_menu_is_on_the_sheet() {
        for menu in Menu::ALL {
            assert_eq!(COLUMNS.iter().flat_map(|c| c.iter()).filter(|m| **m == menu).count(), 1, "{menu:?}");
        }
    }
}
