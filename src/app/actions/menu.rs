//! Menu bar, command palette and sheet of the shortcuts, drawn from the registry.

use super::{ACTIONS, ActionId, ActionRow, Menu, Queue, checked, enabled, keys_text, tooltip};
use crate::app::document::Action;
use crate::app::project::Model;
use crate::app::project::side::Side;
use crate::app::settings::Settings;
use crate::app::words::explained;
use crate::dataset::DatasetSource;
use crate::requests::BurstSource;
use egui::{Key, Modifiers, RichText};
use std::path::PathBuf;

pub fn menu_bar_ui(ui: &mut egui::Ui, model: &Model, remembered: &Settings, queue: &mut Queue) {
    let mut item = |ui: &mut egui::Ui, action: &ActionRow| {
        item_ui(ui, model, queue, action.id);
        if action.id == ActionId::OpenDemo {
            recent_ui(ui, remembered, queue);
        }
    };
    egui::MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL.into_iter().filter(|menu| menu.has_content(model)) {
            let actions: Vec<&ActionRow> = ACTIONS.iter().filter(|action| action.menu == menu).collect();
            ui.menu_button(menu.label(), |ui| {
                within_window(ui, |ui| {
                    let mut last = None;
                    for group in actions.chunk_by(|a, b| a.group == b.group) {
                        let submenu = menu.submenu(group[0].group);
                        if last.is_some_and(|last| last != submenu.is_some() || submenu.is_none()) {
                            ui.separator();
                        }
                        last = Some(submenu.is_some());
                        match submenu {
                            Some(name) => {
                                let all = |ui: &mut egui::Ui| group.iter().for_each(|action| item(ui, action));
                                ui.menu_button(name, |ui| within_window(ui, all));
                            }
                            None => group.iter().for_each(|action| item(ui, action)),
                        }
                    }
                });
            });
        }
    });
}

/// Space that a menu leaves at the lower edge of the window, points.
const MENU_MARGIN: f32 = 24.0;

/// Entries of a menu, which scroll where the window is lower.
fn within_window(ui: &mut egui::Ui, entries: impl FnOnce(&mut egui::Ui)) {
    ui.set_min_width(230.0);
    let room = (ui.ctx().content_rect().bottom() - ui.next_widget_position().y - MENU_MARGIN).max(120.0);
    egui::ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, entries);
}

pub fn item_ui(ui: &mut egui::Ui, model: &Model, queue: &mut Queue, id: ActionId) {
    let action = id.action();
    let mark = if checked(id, model) == Some(true) { "✔ " } else { "" };
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

fn recent_ui(ui: &mut egui::Ui, remembered: &Settings, queue: &mut Queue) {
    let Settings { recent, datasets, .. } = remembered;
    ui.add_enabled_ui(!(recent.is_empty() && datasets.is_empty()), |ui| {
        ui.menu_button("Open recent", |ui| {
            let mut item = |ui: &mut egui::Ui, label: String, paths: &[PathBuf], open: Action| {
                let lines: Vec<String> = paths.iter().take(8).map(|p| p.display().to_string()).collect();
                if ui.button(label).on_hover_text(lines.join("\n")).clicked() {
                    queue.push(open);
                    ui.close();
                }
            };
            for source in recent {
                let paths = if let BurstSource::Paths(paths) = source { &paths[..] } else { &[] };
                item(ui, source.label(), paths, Action::Open(Side::A, source.clone()));
            }
            if !(recent.is_empty() || datasets.is_empty()) {
                ui.separator();
            }
            for source in datasets {
                item(ui, dataset_label(source), &source.paths, Action::OpenDataset(source.clone()));
            }
        });
    });
}

pub fn dataset_label(source: &DatasetSource) -> String {
    match source.burst_length {
        Some(length) => format!("{}, in bursts of {length}", source.label()),
        None => format!("{}, a dataset", source.label()),
    }
}

/// Maximum height of the list, in points; longer lists scroll.
const PALETTE_HEIGHT: f32 = 340.0;

#[derive(Debug, Default)]
pub struct Palette {
    open: bool,
    text: String,
    chosen: usize,
}

impl Palette {
    pub fn open(&mut self) {
        *self = Self { open: true, ..Self::default() };
    }

    pub fn is_open(&self) -> bool {
        self.open
    }

    pub fn ui(&mut self, ctx: &egui::Context, model: &Model, queue: &mut Queue) {
        if !self.open {
            return;
        }
        let keys = [Key::ArrowUp, Key::ArrowDown, Key::Enter];
        let [up, down, enter] = ctx.input_mut(|i| keys.map(|key| i.consume_key(Modifiers::NONE, key)));
        let mut run = None;
        let area = egui::Modal::default_area(egui::Id::unique("palette"))
            .anchor(egui::Align2::CENTER_TOP, egui::vec2(0.0, 72.0));
        let modal = egui::Modal::new(egui::Id::unique("palette")).area(area).show(ctx, |ui| {
            ui.set_width(440.0);
            let edit = egui::TextEdit::singleline(&mut self.text).hint_text("Type part of an action's name");
            let edit = ui.add(edit.desired_width(f32::INFINITY));
            crate::app::panel::widgets::name_field(&edit, "Find an action", &self.text);
            if edit.changed() {
                self.chosen = 0;
            }
            edit.request_focus();
            // Text typed in this pass counts already.
            let found = found_by(&self.text, model);
            let last = found.len().saturating_sub(1);
            let steps = isize::from(down) - isize::from(up);
            self.chosen = self.chosen.min(last).saturating_add_signed(steps).min(last);
            run = enter.then(|| found.get(self.chosen).copied()).flatten();
            ui.add_space(4.0);
            // The height of the present list, not that of the previous one.
            let row = ui.spacing().interact_size.y + ui.spacing().item_spacing.y;
            let height = (row * found.len().max(1) as f32).min(PALETTE_HEIGHT);
            let list = egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height);
            list.auto_shrink([false, true]).show(ui, |ui| {
                for (place, action) in found.iter().enumerate() {
                    let response = palette_row_ui(ui, model, action, place == self.chosen);
                    if place == self.chosen && (up || down) {
                        response.scroll_to_me(None);
                    }
                    if response.clicked() {
                        run = Some(action);
                    }
                }
                if found.is_empty() {
                    ui.weak("No action matches.");
                }
            });
        });
        run.into_iter().for_each(|action| queue.push(action.id));
        self.open = run.is_none() && !modal.should_close();
    }
}

fn palette_row_ui(ui: &mut egui::Ui, model: &Model, action: &ActionRow, chosen: bool) -> egui::Response {
    let on = if checked(action.id, model) == Some(true) { " ✔" } else { "" };
    let weak = ui.visuals().weak_text_color();
    let menu = RichText::new(format!("{} ›", action.menu.label())).color(weak);
    let keys = action.shortcut.as_ref().map_or_else(String::new, |s| keys_text(ui.ctx(), s));
    let button = egui::Button::selectable(chosen, (menu, format!("{}{on}", action.label)))
        .min_size(egui::vec2(ui.available_width(), 0.0))
        .right_text(RichText::new(keys).color(weak));
    ui.add(button).on_hover_text(action.help)
}

/// Enabled actions whose label and help have the words of `text`, or if none has, whose label has its letters in their
/// order; the best match first.
fn found_by(text: &str, model: &Model) -> Vec<&'static ActionRow> {
    let mut possible: Vec<&ActionRow> =
        ACTIONS.iter().filter(|a| enabled(a.id, model) && a.id != ActionId::Palette).collect();
    if text.trim().is_empty() {
        // In the order of the menus, after the most frequent action.
        possible.sort_by_key(|a| a.id != ActionId::Detect);
        return possible;
    }
    let has_words = |text_of: &str| {
        let text_of = text_of.to_lowercase();
        text.split_whitespace().all(|word| text_of.contains(&word.to_lowercase()))
    };
    let by_words = |action: &&ActionRow| match score(text, action.label) {
        Some(score) if has_words(action.label) => Some(score),
        _ => has_words(&format!("{} {}", action.label, action.help)).then_some(-1000),
    };
    let mut scored: Vec<(i32, &ActionRow)> =
        possible.iter().filter_map(|action| Some((by_words(action)?, *action))).collect();
    if scored.is_empty() {
        scored = possible.iter().filter_map(|action| Some((score(text, action.label)?, *action))).collect();
    }
    scored.sort_by_key(|(score, _)| -score);
    scored.into_iter().map(|(_, action)| action).collect()
}

/// Score of the letters of `wanted` in `label`, in their order; those in a row and at beginnings count more.
fn score(wanted: &str, label: &str) -> Option<i32> {
    let label: Vec<char> = label.to_lowercase().chars().collect();
    let (mut at, mut total, mut last) = (0, 0, None);
    for letter in wanted.to_lowercase().chars().filter(|c| !c.is_whitespace()) {
        let found = (at..label.len()).find(|&i| label[i] == letter)?;
        let begins_word = found == 0 || !label[found - 1].is_alphanumeric();
        let in_a_row = last.is_some_and(|l: usize| l + 1 == found);
        total += 1 + 4 * i32::from(begins_word) + 6 * i32::from(in_a_row) - (found - at).min(8) as i32 / 2;
        (last, at) = (Some(found), found + 1);
    }
    Some(total * 4 - label.len() as i32 / 4)
}

/// Minimum width of a window with [`SHEET_COLUMNS`] columns, in points; narrower ones have half as many.
const SHEET_WIDE: f32 = 900.0;
const SHEET_COLUMNS: usize = 4;
const SHEET_HEADING_ROWS: usize = 2;

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
            let groups = in_columns(if room.x > SHEET_WIDE { SHEET_COLUMNS } else { SHEET_COLUMNS / 2 });
            ui.columns(groups.len(), |columns| {
                for (ui, menus) in columns.iter_mut().zip(groups) {
                    menus.iter().for_each(|menu| sheet_menu_ui(ui, *menu));
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

fn with_keys(menu: Menu) -> impl Iterator<Item = &'static ActionRow> {
    ACTIONS.iter().filter(move |action| action.menu == menu && action.shortcut.is_some())
}

/// Menus that have keys, in their order, in at most `count` columns, with the longest column as short as possible.
fn in_columns(count: usize) -> Vec<Vec<Menu>> {
    let menus: Vec<Menu> = Menu::ALL.into_iter().filter(|menu| with_keys(*menu).next().is_some()).collect();
    let rows = |menu: Menu| SHEET_HEADING_ROWS + with_keys(menu).count();
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

fn sheet_menu_ui(ui: &mut egui::Ui, menu: Menu) {
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
    fn parts_of_names_find_their_action() {
        let texts = ["open dem", "light", "keyb", "opth", "qqqq"];
        let found = texts.map(|text| found_by(text, &Model::default()).first().map(|action| action.id));
        use ActionId as A;
        assert_eq!(found, [Some(A::OpenDemo), Some(A::ThemeLight), Some(A::Shortcuts), Some(A::OpenPath), None]);
    }
}
