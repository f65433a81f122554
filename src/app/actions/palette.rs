//! Command palette: finds actions by parts of their names.

use super::{ACTIONS, Action, Queue, checked, enabled, keys_text};
use crate::app::project::Model;
use egui::{Key, Modifiers, RichText};

/// Maximum height of the list, in points; longer lists scroll.
const MAX_LIST_HEIGHT: f32 = 340.0;

/// State of the palette.
#[derive(Debug, Default)]
pub struct Palette {
    open: bool,
    text: String,
    chosen: usize,
}

impl Palette {
    /// Opens the palette, with an empty text.
    pub fn open(&mut self) {
        *self = Self { open: true, ..Self::default() };
    }

    /// Whether the palette is open.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Draws the palette if it is open.
    pub fn ui(&mut self, ctx: &egui::Context, model: &Model, queue: &mut Queue) {
        if !self.open {
            return;
        }
        let (up, down, enter) = ctx.input_mut(|i| {
            (
                i.consume_key(Modifiers::NONE, Key::ArrowUp),
                i.consume_key(Modifiers::NONE, Key::ArrowDown),
                i.consume_key(Modifiers::NONE, Key::Enter),
            )
        });
        let mut run = None;
        let area = egui::Modal::default_area(egui::Id::unique("palette"))
            .anchor(egui::Align2::CENTER_TOP, egui::vec2(0.0, 72.0));
        let modal = egui::Modal::new(egui::Id::unique("palette")).area(area).show(ctx, |ui| {
            ui.set_width(440.0);
            let edit = egui::TextEdit::singleline(&mut self.text)
                .hint_text("Type part of an action's name")
                .desired_width(f32::INFINITY);
            let edit = ui.add(edit);
            crate::app::panel::widgets::name_field(&edit, "Find an action", &self.text);
            if edit.changed() {
                self.chosen = 0;
            }
            edit.request_focus();
            // Text typed in this pass counts already.
            let found = matches(&self.text, model);
            let last = found.len().saturating_sub(1);
            let steps = isize::from(down) - isize::from(up);
            self.chosen = self.chosen.min(last).saturating_add_signed(steps).min(last);
            run = enter.then(|| found.get(self.chosen).copied()).flatten();
            ui.add_space(4.0);
            // The height of the present list, not that of the previous one.
            let row = ui.spacing().interact_size.y + ui.spacing().item_spacing.y;
            let height = (row * found.len().max(1) as f32).min(MAX_LIST_HEIGHT);
            let list = egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height);
            list.auto_shrink([false, true]).show(ui, |ui| {
                for (place, action) in found.iter().enumerate() {
                    let response = row_ui(ui, model, action, place == self.chosen);
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
        if let Some(action) = run {
            queue.push(action.id);
            self.open = false;
        } else if modal.should_close() {
            self.open = false;
        }
    }
}

fn row_ui(ui: &mut egui::Ui, model: &Model, action: &Action, chosen: bool) -> egui::Response {
    let on = if checked(action.id, model) == Some(true) { " ✔" } else { "" };
    let weak = ui.visuals().weak_text_color();
    let menu = RichText::new(format!("{} ›", action.menu.label())).color(weak);
    let keys = action.shortcut.as_ref().map_or_else(String::new, |s| keys_text(ui.ctx(), s));
    let button = egui::Button::selectable(chosen, (menu, format!("{}{on}", action.label)))
        .min_size(egui::vec2(ui.available_width(), 0.0))
        .right_text(RichText::new(keys).color(weak));
    ui.add(button).on_hover_text(action.help)
}

/// Enabled actions whose label or help contains the letters of `text` in their order; the best match first.
fn matches(text: &str, model: &Model) -> Vec<&'static Action> {
    let mut possible: Vec<&Action> =
        ACTIONS.iter().filter(|a| enabled(a.id, model) && a.id != super::ActionId::Palette).collect();
    if text.trim().is_empty() {
        // In the order of the menus, after the most frequent action.
        possible.sort_by_key(|a| a.id != super::ActionId::Detect);
        return possible;
    }
    let mut scored: Vec<(i32, &Action)> = possible
        .into_iter()
        .filter_map(|a| score(text, a.label).or_else(|| score(text, a.help).map(|s| s - 1000)).map(|s| (s, a)))
        .collect();
    scored.sort_by_key(|(score, _)| -score);
    scored.into_iter().map(|(_, action)| action).collect()
}

/// Score of the letters of `wanted` found in `label` in their order; `None` if one is missing. Consecutive letters and
/// beginnings of words count more.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::actions::ActionId;

    fn first(text: &str) -> Option<ActionId> {
        matches(text, &Model::default()).first().map(|a| a.id)
    }

    #[test]
    fn parts_of_names_find_their_action() {
        assert_eq!(first("open dem"), Some(ActionId::OpenDemo));
        assert_eq!(first("demo"), Some(ActionId::OpenDemo));
        assert_eq!(first("light"), Some(ActionId::ThemeLight));
        assert_eq!(first("keyb"), Some(ActionId::Shortcuts));
        assert_eq!(first("opth"), Some(ActionId::OpenPath));
        assert_eq!(first("qqqq"), None);
    }

    #[test]
    fn nothing_typed_lists_everything_that_can_be_done() {
        let model = Model::default();
        let expected = ACTIONS.iter().filter(|a| enabled(a.id, &model)).count() - 1;
        assert_eq!(matches("", &model).len(), expected);
        assert_eq!(first(""), Some(ActionId::OpenFolder), "nothing that ends the program");
    }
}
