//! All actions of the user, each registered once.
//!
//! [`registry`] holds one row for each action: its label, menu, shortcut and help. The menu bar, the toolbar's
//! tooltips, the command palette and the sheet of shortcuts are drawn from these rows, so none of them can miss an
//! action or name it differently.

mod change;
pub mod menu;
pub mod registry;
mod state_of;

pub use change::{change, probe_here};
pub use registry::{ACTIONS, Action, ActionId, Menu, shown_by};
pub use state_of::{checked, enabled};

use crate::app::project::Model;
use crate::app::words::explained;
use crate::requests::ViewKind;
use crate::teach::glossary::{Word, glossary};

/// Actions requested in this pass, to be run after it.
pub type Queue = Vec<ActionId>;

/// Text of a shortcut: `Ctrl+O`, `[`, `?`.
pub fn keys_text(ctx: &egui::Context, shortcut: &egui::KeyboardShortcut) -> String {
    let text = ctx.format_shortcut(shortcut);
    let key = shortcut.logical_key;
    // egui writes the names of punctuation signs; the key shows the sign itself.
    match (text.strip_suffix(key.name()), key.symbol_or_name()) {
        (Some(modifiers), sign) if !sign.starts_with('⏴') && !"⏵⏶⏷".contains(sign) => {
            format!("{modifiers}{sign}")
        }
        _ => text,
    }
}

impl ActionId {
    /// Kind of picture that the action shows.
    pub fn shown(self) -> Option<ViewKind> {
        ViewKind::ALL.into_iter().find(|kind| shown_by(*kind) == self)
    }

    /// Glossary entry of the content that the action shows.
    pub fn word(self) -> Option<&'static Word> {
        match self {
            Self::LayoutSlice => glossary().of_picture("slice"),
            _ => glossary().of_picture(self.shown()?.about().key),
        }
    }
}

/// Tooltip of an action: its help and its shortcut.
pub fn tooltip(ctx: &egui::Context, action: &Action) -> String {
    match &action.shortcut {
        Some(shortcut) => format!("{}  ({})", action.help, keys_text(ctx, shortcut)),
        None => action.help.to_owned(),
    }
}

/// Draws a button for an action, with the action's label or the shorter `label`.
pub fn button_ui(
    ui: &mut egui::Ui,
    model: &Model,
    queue: &mut Queue,
    id: ActionId,
    label: Option<&str>,
) -> egui::Response {
    let action = id.action();
    let text = label.unwrap_or(action.label);
    let on = checked(id, model).unwrap_or(false);
    let button = egui::Button::selectable(on, text).frame_when_inactive(true);
    let response = ui.add_enabled(enabled(id, model), button);
    let tip = tooltip(ui.ctx(), action);
    let response = explained(response, &tip, id.word()).on_disabled_hover_text(&tip);
    if response.clicked() {
        queue.push(id);
    }
    response
}

/// Puts the actions whose shortcuts were pressed in this pass into `queue`. Plain keys are left to a text field that is
/// being edited, and to an open menu or drop-down: arrows choose in it, and Escape closes it.
pub fn take_shortcuts(ctx: &egui::Context, model: &Model, queue: &mut Queue) {
    let plain_keys_are_taken = ctx.egui_wants_keyboard_input() || egui::Popup::is_any_open(ctx);
    ctx.input_mut(|input| {
        // Shortcuts with more modifiers first: a plain key would otherwise swallow the same key with Shift.
        let mut with_keys: Vec<_> = ACTIONS.iter().filter_map(|a| a.shortcut.map(|s| (a.id, s))).collect();
        with_keys.sort_by_key(|(_, s)| {
            std::cmp::Reverse(u8::from(s.modifiers.shift) + u8::from(s.modifiers.command) + u8::from(s.modifiers.alt))
        });
        let opens = |id: ActionId| {
            id.action().label.ends_with('…') || matches!(id, ActionId::Shortcuts | ActionId::About | ActionId::Glossary)
        };
        for (id, shortcut) in with_keys {
            let plain = !shortcut.modifiers.command && !shortcut.modifiers.alt;
            if (plain && plain_keys_are_taken) || !enabled(id, model) {
                continue;
            }
            // A key that repeats faster than the window draws is pressed several times in one pass.
            let presses = input.count_and_consume_key(shortcut.modifiers, shortcut.logical_key);
            queue.extend(std::iter::repeat_n(id, presses));
        }
        // Keys pressed after the one that opens a dialog, in the same pass, are meant for the dialog.
        if let Some(opener) = queue.iter().copied().find(|id| opens(*id)) {
            *queue = vec![opener];
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::tests::open;
    use egui::{Event, Id, Key, Modifiers, Popup, RawInput};

    /// Actions of a pass in which `key` is pressed, with or without an open drop-down.
    fn pressed(key: Key, drop_down_is_open: bool) -> Queue {
        let (ctx, mut model, mut queue) = (egui::Context::default(), Model::default(), Queue::new());
        model.take_burst(open((64, 48), 5));
        let event = Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
        let mut output = ctx.run_ui(RawInput { events: vec![event], ..Default::default() }, |ui| {
            if drop_down_is_open {
                Popup::open_id(ui.ctx(), Id::unique("drop-down"));
            }
            take_shortcuts(ui.ctx(), &model, &mut queue);
        });
        output.textures_delta.clear();
        queue
    }

    #[test]
    fn an_open_drop_down_keeps_the_arrows_from_the_cursor() {
        let steps = pressed(Key::ArrowRight, false);
        assert_eq!(steps.len(), 1, "{steps:?}");
        for key in [Key::ArrowRight, Key::ArrowDown, Key::Escape] {
            assert_eq!(pressed(key, true), [], "{key:?}");
        }
    }
}
