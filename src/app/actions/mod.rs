//! All actions of the user, each registered once in a row of [`registry`], from which menus and tooltips are drawn.

pub mod menu;
pub mod registry;
pub mod when;

pub use crate::app::document::Queue;
pub use registry::{ACTIONS, ActionId, ActionRow, Menu, checked, enabled, shown_by, workspaces};

use crate::app::results::Read;
use egui::Response;

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

pub fn tooltip(ctx: &egui::Context, action: &ActionRow) -> String {
    match &action.shortcut {
        Some(shortcut) => format!("{}  ({})", action.help, keys_text(ctx, shortcut)),
        None => action.help.to_owned(),
    }
}

pub fn button_ui(ui: &mut egui::Ui, model: Read<'_>, queue: &mut Queue, id: ActionId, label: Option<&str>) -> Response {
    let (action, on) = (id.action(), checked(id, model).unwrap_or(false));
    let button = egui::Button::selectable(on, label.unwrap_or(action.label)).frame_when_inactive(true);
    let response = ui.add_enabled(enabled(id, model), button);
    let tip = tooltip(ui.ctx(), action);
    let response = crate::app::words::explained(response, &tip, id.word()).on_disabled_hover_text(&tip);
    queue.push_if(response.clicked(), id);
    response
}

/// Plain keys are left to a text field that is edited, and to an open menu: arrows choose in it, Escape closes it.
pub fn take_shortcuts(ctx: &egui::Context, model: Read<'_>, queue: &mut Queue) {
    let plain_keys_are_taken = ctx.egui_wants_keyboard_input() || egui::Popup::is_any_open(ctx);
    ctx.input_mut(|input| {
        // More modifiers first: a plain key would swallow the same key with Shift. Escape clears before it cancels.
        let mut with_keys: Vec<_> = ACTIONS.iter().filter_map(|a| a.shortcut.map(|s| (a.id, s))).collect();
        with_keys.sort_by_key(|(id, shortcut)| {
            let held = [shortcut.modifiers.shift, shortcut.modifiers.command, shortcut.modifiers.alt];
            (std::cmp::Reverse(held.map(u8::from).iter().sum::<u8>()), *id == ActionId::Cancel)
        });
        for (id, shortcut) in with_keys {
            let plain = !shortcut.modifiers.command && !shortcut.modifiers.alt;
            if (plain && plain_keys_are_taken) || !enabled(id, model) {
                continue;
            }
            // A key that repeats faster than the window draws is pressed several times in one pass.
            let presses = input.count_and_consume_key(shortcut.modifiers, shortcut.logical_key);
            std::iter::repeat_n(id, presses).for_each(|id| queue.push(id));
        }
        // Keys pressed after the one that opens a dialog, in the same pass, are meant for the dialog.
        let opener = queue.asked().find(|id| {
            id.action().label.ends_with('…') || matches!(id, ActionId::Shortcuts | ActionId::About | ActionId::Glossary)
        });
        opener.into_iter().for_each(|id| queue.replace(id));
    });
}
