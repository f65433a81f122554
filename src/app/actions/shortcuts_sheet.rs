//! Sheet of shortcuts: the actions that have keys, by menu. The command palette has all actions.

use super::{ACTIONS, Action, ActionId, Menu, keys_text};
use egui::RichText;

/// Minimum width of a window with [`COLUMNS`] columns, in points; narrower ones have half as many.
const WIDE: f32 = 900.0;
const COLUMNS: usize = 4;
/// Height of a menu's heading, in rows.
const HEADING_ROWS: usize = 2;

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
        egui::ScrollArea::vertical().max_height(room.y - 130.0).min_scrolled_height(room.y - 130.0).show(ui, |ui| {
            ui.spacing_mut().item_spacing = egui::vec2(24.0, 1.0);
            ui.spacing_mut().interact_size.y = 16.0;
            let groups = in_columns(if room.x > WIDE { COLUMNS } else { COLUMNS / 2 });
            ui.columns(groups.len(), |columns| {
                for (ui, menus) in columns.iter_mut().zip(groups) {
                    menus.iter().for_each(|menu| menu_ui(ui, *menu));
                }
            });
        });
        ui.separator();
        let keys = ActionId::Palette.action().shortcut.map(|keys| keys_text(ui.ctx(), &keys)).unwrap_or_default();
        ui.weak(format!("{keys} finds every action by its name, also those without keys"));
    });
    if modal.should_close() {
        *open = false;
    }
}

/// Actions of a menu that have keys.
fn with_keys(menu: Menu) -> impl Iterator<Item = &'static Action> {
    ACTIONS.iter().filter(move |action| action.menu == menu && action.shortcut.is_some())
}

/// Menus that have keys, in their order, in at most `count` columns, with the longest column as short as possible.
fn in_columns(count: usize) -> Vec<Vec<Menu>> {
    let menus: Vec<Menu> = Menu::ALL.into_iter().filter(|menu| with_keys(*menu).next().is_some()).collect();
    let rows = |menu: Menu| HEADING_ROWS + with_keys(menu).count();
    let within = |limit: usize| {
        let (mut columns, mut height) = (vec![Vec::new()], 0);
        for &menu in &menus {
            if height > 0 && height + rows(menu) > limit {
                columns.push(Vec::new());
                height = 0;
            }
            height += rows(menu);
            columns.last_mut().expect("there is one from the beginning").push(menu);
        }
        columns
    };
    let longest = menus.iter().map(|menu| rows(*menu)).max().unwrap_or(0);
    (longest..).map(within).find(|columns| columns.len() <= count).expect("with room for all rows one is enough")
}

fn menu_ui(ui: &mut egui::Ui, menu: Menu) {
    ui.add_space(2.0);
    ui.label(RichText::new(menu.label()).strong());
    for action in with_keys(menu) {
        ui.horizontal(|ui| {
            ui.label(action.label).on_hover_text(action.help);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if let Some(shortcut) = &action.shortcut {
                    key_ui(ui, &keys_text(ui.ctx(), shortcut));
                }
            });
        });
    }
    ui.add_space(6.0);
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
    fn every_menu_with_keys_is_in_one_column_and_the_columns_are_about_as_long_as_one_another() {
        for count in [1, 2, 4] {
            let columns = in_columns(count);
            assert!(columns.len() <= count);
            let all: Vec<Menu> = columns.concat();
            let expected = Menu::ALL.into_iter().filter(|menu| with_keys(*menu).next().is_some());
            assert!(all.iter().copied().eq(expected), "{all:?}");
            let rows = |menus: &Vec<Menu>| menus.iter().map(|menu| HEADING_ROWS + with_keys(*menu).count()).sum();
            let longest: usize = columns.iter().map(rows).max().unwrap_or(0);
            let longest_menu = all.iter().map(|menu| rows(&vec![*menu])).max().unwrap_or(0);
            let total: usize = rows(&all);
            assert!(longest <= longest_menu.max(total * 4 / (3 * count)), "{count}: {longest} of {total}");
        }
    }
}
