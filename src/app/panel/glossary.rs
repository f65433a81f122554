//! Glossary window: every term of the window, with a search field.

use crate::app::panel::widgets::name_field;
use crate::app::words::{asked_for, caption_ui};
use crate::teach::glossary::{Origin, Word, glossary};
use egui::{Context, RichText, ScrollArea, Ui, vec2};

#[derive(Default)]
pub struct GlossaryWindow {
    is_open: bool,
    text: String,
    wanted: Option<String>,
    focus: bool,
}

impl GlossaryWindow {
    pub fn open(&mut self, word: Option<&str>) {
        (self.is_open, self.text, self.focus) = (true, String::new(), word.is_none());
        if let Some(found) = word.and_then(|word| glossary().find(word)) {
            self.wanted = Some(found.name.clone());
        }
    }

    /// Closes the open window if Escape was pressed, also in its search field. The key then does nothing else.
    pub fn take_escape(&mut self, ctx: &Context) {
        let closes = self.is_open && !egui::Popup::is_any_open(ctx);
        if closes && ctx.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Escape)) {
            self.is_open = false;
        }
    }

    /// Draws the window if it is open; it does not block the others.
    pub fn ui(&mut self, ctx: &Context) {
        if let Some(word) = asked_for(ctx) {
            self.open(Some(&word));
        }
        let mut is_open = self.is_open;
        egui::Window::new("Glossary")
            .open(&mut is_open)
            .default_pos(ctx.content_rect().center_top() + vec2(-220.0, 90.0))
            .default_size([440.0, 460.0])
            .min_width(320.0)
            .resizable(true)
            .show(ctx, |ui| self.contents_ui(ui));
        self.is_open = is_open;
    }

    fn contents_ui(&mut self, ui: &mut Ui) {
        let edit = egui::TextEdit::singleline(&mut self.text).hint_text("Search").desired_width(f32::INFINITY);
        let edit = ui.add(edit);
        name_field(&edit, "Search the glossary", &self.text);
        if std::mem::take(&mut self.focus) {
            edit.request_focus();
        }
        self.wanted.take_if(|_| edit.changed());
        ui.add_space(4.0);
        let found = glossary().search(&self.text);
        if found.is_empty() {
            ui.weak("No entry matches.");
        }
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for word in found {
                let is_wanted = self.wanted.as_ref() == Some(&word.name);
                let top = ui.cursor().min;
                word_ui(ui, word, is_wanted);
                if is_wanted {
                    let rect = egui::Rect::from_min_max(top, ui.min_rect().right_bottom());
                    ui.scroll_to_rect(rect, Some(egui::Align::TOP));
                    // Scrolls to the entry only once, so that the user can scroll on.
                    self.wanted.take_if(|_| ui.clip_rect().contains(rect.left_top()));
                }
            }
        });
    }
}

fn word_ui(ui: &mut Ui, word: &Word, is_wanted: bool) {
    ui.horizontal_wrapped(|ui| {
        let title = RichText::new(&word.word).strong();
        ui.label(if is_wanted { title.color(ui.visuals().hyperlink_color) } else { title });
        if let Some(symbol) = &word.symbol {
            ui.label(RichText::new(symbol).monospace().weak()).on_hover_text("Symbol in the paper");
        }
        if let Some([label, help]) = word.origin.map(Origin::words) {
            ui.label(RichText::new(label).small().weak()).on_hover_text(help);
        }
    });
    ui.push_id(&word.name, |ui| caption_ui(ui, &word.text));
    ui.add_space(8.0);
}
