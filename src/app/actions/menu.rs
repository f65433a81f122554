//! Menu bar, command palette and sheet of the shortcuts, drawn from the registry.

use super::{ACTIONS, ActionId, ActionRow, Menu, Queue, checked, enabled, keys_text, tooltip};
use crate::app::document::{Action, Panels, Side};
use crate::app::{results::Read, settings::Settings, words::explained};
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::detector::params::{Param, doc};
use egui::{Key, KeyboardShortcut, Modifiers, RichText};

pub fn menu_bar_ui(ui: &mut egui::Ui, model: Read<'_>, remembered: &Settings, queue: &mut Queue) {
    let mut item = |ui: &mut egui::Ui, action: &ActionRow| {
        item_ui(ui, model, queue, action.id);
        if action.id == ActionId::OpenDemo {
            recent_ui(ui, remembered, queue);
        }
    };
    egui::MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL.into_iter().filter(|menu| menu.parent().is_none() && menu.has_content(model)) {
            ui.menu_button(menu.label(), |ui| within_window(ui, |ui| entries_ui(ui, menu, &mut item)));
        }
    });
}

/// Draws the actions of a menu in their groups, and below them the menus that are in it.
fn entries_ui(ui: &mut egui::Ui, menu: Menu, item: &mut dyn FnMut(&mut egui::Ui, &ActionRow)) {
    let actions: Vec<&ActionRow> = ACTIONS.iter().filter(|action| action.menu == menu).collect();
    let mut last = None;
    for group in actions.chunk_by(|a, b| a.group == b.group) {
        let submenu = menu.submenu(group[0].group);
        if last.is_some_and(|last| last != submenu.is_some() || submenu.is_none()) {
            ui.separator();
        }
        last = Some(submenu.is_some());
        let mut all = |ui: &mut egui::Ui| group.iter().for_each(|action| item(ui, action));
        match submenu {
            Some(name) => _ = ui.menu_button(name, |ui| within_window(ui, all)),
            None => all(ui),
        }
    }
    for below in Menu::ALL.into_iter().filter(|below| below.parent() == Some(menu)) {
        ui.menu_button(below.label(), |ui| within_window(ui, |ui| entries_ui(ui, below, item)));
    }
}

/// Space that a menu leaves at the lower edge of the window, points.
const MENU_MARGIN: f32 = 24.0;

/// Entries of a menu, which scroll where the window is lower.
fn within_window(ui: &mut egui::Ui, entries: impl FnOnce(&mut egui::Ui)) {
    ui.set_min_width(230.0);
    let room = (ui.ctx().content_rect().bottom() - ui.next_widget_position().y - MENU_MARGIN).max(120.0);
    egui::ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, entries);
}

pub fn item_ui(ui: &mut egui::Ui, model: Read<'_>, queue: &mut Queue, id: ActionId) {
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
            let mut item = |ui: &mut egui::Ui, label: String, paths: &[std::path::PathBuf], open: Action| {
                let lines: Vec<String> = paths.iter().take(8).map(|p| p.display().to_string()).collect();
                if ui.button(label).on_hover_text(lines.join("\n")).clicked() {
                    queue.push(open);
                    ui.close();
                }
            };
            for source in recent {
                item(ui, source.label(), source.paths(), Action::Open(Side::A, source.clone()));
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
    pub is_open: bool,
    text: String,
    chosen: usize,
}

impl Palette {
    pub fn open(&mut self) {
        *self = Self { is_open: true, ..Self::default() };
    }

    pub fn ui(&mut self, ctx: &egui::Context, model: Read<'_>, queue: &mut Queue) {
        if !self.is_open {
            return;
        }
        let keys = [Key::ArrowUp, Key::ArrowDown, Key::Enter];
        let [up, down, enter] = ctx.input_mut(|i| keys.map(|key| i.consume_key(Modifiers::NONE, key)));
        let mut run = None;
        let area = egui::Modal::default_area(egui::Id::unique("palette"))
            .anchor(egui::Align2::CENTER_TOP, egui::vec2(0.0, 72.0));
        let modal = egui::Modal::new(egui::Id::unique("palette")).area(area).show(ctx, |ui| {
            ui.set_width(440.0);
            let hint = "Part of the name of an action or parameter, such as first octave -1";
            let edit = egui::TextEdit::singleline(&mut self.text).hint_text(hint);
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
            run = enter.then(|| found.get(self.chosen)).flatten().filter(|found| is_possible(found, model)).cloned();
            ui.add_space(4.0);
            // The height of the present list, not that of the previous one.
            let row = ui.spacing().interact_size.y + ui.spacing().item_spacing.y;
            let height = (row * found.len().max(1) as f32).min(PALETTE_HEIGHT);
            let list = egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height);
            list.auto_shrink([false, true]).show(ui, |ui| {
                for (place, entry) in found.iter().enumerate() {
                    let response = palette_row_ui(ui, model, entry, place == self.chosen);
                    if place == self.chosen && (up || down) {
                        response.scroll_to_me(None);
                    }
                    if response.clicked() {
                        run = Some(entry.clone());
                    }
                }
                if found.is_empty() {
                    ui.weak("No action and no parameter has these words.");
                }
            });
        });
        self.is_open = run.is_none() && !modal.should_close();
        match run {
            Some(Entry::Action(id)) => queue.push(id),
            Some(Entry::Parameter(record, value)) => set_or_show(record, value.as_deref(), model, queue),
            None => {}
        }
    }
}

/// The search with a parameter set, as an option of a command sets it.
fn with_value(record: Param<SearchParams>, value: &str, model: Read<'_>) -> Option<SearchParams> {
    model.document.params.clone().with_texts([(record, value)]).ok()
}

fn is_possible(found: &Entry, model: Read<'_>) -> bool {
    match found {
        Entry::Action(id) => enabled(*id, model),
        Entry::Parameter(record, value) => {
            value.as_ref().is_none_or(|value| with_value(*record, value, model).is_some())
        }
    }
}

fn set_or_show(record: Param<SearchParams>, value: Option<&str>, model: Read<'_>, queue: &mut Queue) {
    match value.and_then(|value| with_value(record, value, model)) {
        Some(search) => model.document.action_to(search).into_iter().for_each(|action| queue.push(action)),
        None => queue.push(Action::SetPanels(Panels { left: true.into(), advanced: true, ..model.document.panels })),
    }
}

fn palette_row_ui(ui: &mut egui::Ui, model: Read<'_>, found: &Entry, chosen: bool) -> egui::Response {
    let weak = ui.visuals().weak_text_color();
    let is_possible = is_possible(found, model);
    let (group, text, right, help) = match found {
        Entry::Action(id) => {
            let action = id.action();
            let on = if checked(*id, model) == Some(true) { " ✔" } else { "" };
            let keys = action.shortcut.as_ref().map_or_else(String::new, |s| keys_text(ui.ctx(), s));
            let right = if is_possible { keys } else { why_not(action, model).to_owned() };
            (action.menu.label(), format!("{}{on}", action.label), right, action.help.to_owned())
        }
        Entry::Parameter(record, value) => {
            let right = match value {
                Some(_) if !is_possible => "not a value of it".to_owned(),
                Some(value) => format!("set to {value}"),
                None => record.text(&model.params_of(Side::A).into()),
            };
            ("Detector", record.label.to_owned(), right, record.help())
        }
    };
    let group = RichText::new(format!("{group} ›")).color(weak);
    let button = egui::Button::selectable(chosen, (group, text))
        .min_size(egui::vec2(ui.available_width(), 0.0))
        .right_text(RichText::new(right).color(weak));
    ui.add_enabled(is_possible, button).on_hover_text(help.clone()).on_disabled_hover_text(help)
}

#[derive(Debug, Clone, PartialEq)]
enum Entry {
    Action(ActionId),
    /// A parameter of the detector, with the value that was typed after it.
    Parameter(Param<SearchParams>, Option<String>),
}

/// Actions and parameters whose names or help have the words of `text`, the best first; what is possible now before
/// what is not. A number at the end is a value.
fn found_by(text: &str, model: Read<'_>) -> Vec<Entry> {
    let text = text.trim().to_lowercase();
    let actions = ACTIONS.iter().filter(|action| action.id != ActionId::Palette);
    if text.is_empty() {
        let mut possible: Vec<&ActionRow> = actions.filter(|action| enabled(action.id, model)).collect();
        // In the order of the menus, after the most frequent action.
        possible.sort_by_key(|action| action.id != ActionId::Detect);
        return possible.into_iter().map(|action| Entry::Action(action.id)).collect();
    }
    let typed = text.rsplit_once(' ').map(|(name, value)| (name, value.replace('−', "-")));
    let (name, value) = match typed {
        Some((name, value)) if value.parse::<f64>().is_ok() => (name, Some(value)),
        _ => (&*text, None),
    };
    let actions = actions.filter_map(|action| {
        let rank = rank(&text, action.label, action.help)?;
        Some((rank + u8::from(!enabled(action.id, model)) * 8, Entry::Action(action.id)))
    });
    let parameters = doc::ALL
        .iter()
        .filter_map(|record| Some((rank(name, record.label, record.name)?, Entry::Parameter(*record, value.clone()))));
    let mut found: Vec<(u8, Entry)> = actions.chain(parameters).collect();
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, found)| found).collect()
}

/// How well the words of `wanted` fit: 0 where `label` begins with them, up to 3 where `help` has some of them; `None`
/// where one is in neither.
fn rank(wanted: &str, label: &str, help: &str) -> Option<u8> {
    let (label, help) = (label.to_lowercase(), help.to_lowercase());
    let has = |text: &str| wanted.split_whitespace().all(|word| text.contains(word));
    let at_word =
        || label.split_whitespace().any(|word| word.starts_with(wanted.split_whitespace().next().unwrap_or("")));
    match () {
        () if label.starts_with(wanted) => Some(0),
        () if has(&label) => Some(2 - u8::from(at_word())),
        () => has(&format!("{label} {help}")).then_some(3),
    }
}

fn why_not(action: &ActionRow, model: Read<'_>) -> &'static str {
    match action.menu {
        Menu::Dataset => "open a dataset first",
        _ if model.results.slots.a.burst.is_none() => "open a burst first",
        Menu::Pair if model.results.slots.b.burst.is_none() => "open a second burst first",
        Menu::Pair => "in Two bursts",
        Menu::Detect if action.group == 4 => "in the Lab, after a study",
        Menu::Panes => "in One burst, or with several panes",
        _ => "nothing there for it now",
    }
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
                crate::app::panel::widgets::close_ui(ui, "Close");
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
    *open &= !modal.should_close();
}

fn with_keys(menu: Menu) -> impl Iterator<Item = (&'static ActionRow, KeyboardShortcut)> {
    ACTIONS.iter().filter(move |action| action.menu == menu).filter_map(|action| Some((action, action.shortcut?)))
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
    for (action, keys) in with_keys(menu) {
        ui.horizontal(|ui| {
            ui.label(action.label).on_hover_text(action.help);
            let right = egui::Layout::right_to_left(egui::Align::Center);
            ui.with_layout(right, |ui| key_ui(ui, &keys_text(ui.ctx(), &keys)));
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
    use crate::app::apply::{bench, opening};

    #[test]
    fn words_find_actions_and_parameters_and_nothing_else() {
        let mut model = crate::app::results::Model::default();
        let read = Read::of(&model);
        let first = |text: &str| found_by(text, read).first().cloned();
        use ActionId as A;
        for (text, id) in [("open dem", A::OpenDemo), ("light", A::ThemeLight), ("keyb", A::Shortcuts)] {
            assert_eq!(first(text), Some(Entry::Action(id)), "{text}");
        }
        assert_eq!((first("opth"), first("qqqq")), (None, None), "letters that are not together");
        assert_eq!(first("first oct"), Some(Entry::Parameter(doc::FIRST_OCTAVE, None)));
        let set = Entry::Parameter(doc::FIRST_OCTAVE, Some("-1".to_owned()));
        assert_eq!(first("first octave -1"), Some(set.clone()));
        assert!(is_possible(&set, read));
        let mut queue = Queue::default();
        set_or_show(doc::FIRST_OCTAVE, Some("-1"), read, &mut queue);
        let Some(Action::Change(changes)) = queue.0.into_iter().next() else { panic!("it is set") };
        assert_eq!(changes, [crate::detector::ParamChange::new(doc::FIRST_OCTAVE, -1)]);
        let wrong = Entry::Parameter(doc::FIRST_OCTAVE, Some("99".to_owned()));
        assert!(found_by("first octave 99", read).contains(&wrong) && !is_possible(&wrong, read));
        // What is not possible now is there, after what is, with the reason.
        let swap = found_by("swap a and b", read);
        assert_eq!(swap, [Entry::Action(A::SwapSides)]);
        assert!(!is_possible(&swap[0], read));
        assert_eq!(why_not(A::SwapSides.action(), read), "open a burst first");
        opening::take_burst(&mut model, bench::open((64, 48), 5));
        assert_eq!(why_not(A::SwapSides.action(), Read::of(&model)), "open a second burst first");
    }
}
