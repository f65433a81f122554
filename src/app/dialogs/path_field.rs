//! Field to type a path into, and the question whether a file there may be replaced.

use crate::app::document::Purpose;
use crate::app::panel::widgets::{confirm_ui, modal_ui, name_field};
use crate::export::is_ours;
use std::path::PathBuf;

#[derive(Debug, Clone)]
pub struct PathField {
    pub purpose: Purpose,
    pub text: String,
    pub instead_of_dialog: bool,
    fresh: bool,
}

impl PathField {
    pub fn new(purpose: Purpose, text: String, instead_of_dialog: bool) -> Self {
        Self { purpose, text, instead_of_dialog, fresh: true }
    }

    pub fn ui(&mut self, ctx: &egui::Context) -> (Option<PathBuf>, bool) {
        let mut accepted = None;
        let dismissed = modal_ui(ctx, "path field", 480.0, self.purpose.title(), |ui| {
            if self.instead_of_dialog {
                ui.weak("This system shows no file dialog, so please type the path.");
            }
            ui.add_space(4.0);
            let edit = ui.add(
                egui::TextEdit::singleline(&mut self.text).hint_text(self.purpose.hint()).desired_width(f32::INFINITY),
            );
            name_field(&edit, "Path", &self.text);
            if std::mem::take(&mut self.fresh) {
                edit.request_focus();
                select_stem(ctx, edit.id, &self.text);
            }
            if let Some(folder) = self.purpose.saves().then(|| new_folder(&path_from_text(&self.text))).flatten() {
                ui.weak(format!("The folder {} will be made.", folder.display()));
            }
            if let Some(folder) = std::env::current_dir().ok().filter(|_| path_from_text(&self.text).is_relative()) {
                ui.weak(format!("From {}", folder.display()));
            }
            ui.add_space(6.0);
            let entered = edit.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let verb = if self.purpose.saves() { "Save" } else { "Open" };
                let ready = !self.text.trim().is_empty();
                if (ui.add_enabled(ready, egui::Button::new(verb)).clicked() || entered) && ready {
                    accepted = Some(path_from_text(&self.text));
                }
                if ui.button("Cancel").clicked() {
                    ui.close();
                }
            });
        });
        let stay = accepted.is_none() && !dismissed;
        (accepted, stay)
    }
}

/// Selects the name without its extension, so that typing replaces the name and keeps the extension.
fn select_stem(ctx: &egui::Context, id: egui::Id, text: &str) {
    let letters = |part: &str| part.chars().count();
    let name = text.rfind('/').map_or(0, |slash| slash + 1);
    // A name with two extensions keeps both.
    let end = text[name..].find('.').filter(|dot| *dot > 0).map_or(text.len(), |dot| name + dot);
    let mut state = egui::TextEdit::load_state(ctx, id).unwrap_or_default();
    let at = |place: usize| egui::text::CCursor::new(letters(&text[..place]));
    state.cursor.set_char_range(Some(egui::text::CCursorRange::two(at(name), at(end))));
    egui::TextEdit::store_state(ctx, id, state);
}

/// Folder that has to be created for a file at `path`; `None` when it exists.
fn new_folder(path: &std::path::Path) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty())?;
    (!folder.exists()).then(|| folder.to_path_buf())
}

/// Removes surrounding blanks, quotes and a leading `file://`; replaces a leading `~/` by the home folder.
pub fn path_from_text(text: &str) -> PathBuf {
    let text = text.trim();
    let unquoted = ['"', '\''].iter().find_map(|q| text.strip_prefix(*q)?.strip_suffix(*q)).unwrap_or(text);
    let plain = unquoted.strip_prefix("file://").unwrap_or(unquoted);
    match (plain.strip_prefix("~/"), std::env::home_dir()) {
        (Some(rest), Some(home)) => home.join(rest),
        _ => PathBuf::from(plain),
    }
}

#[derive(Debug, Clone)]
pub struct ReplaceFile {
    pub purpose: Purpose,
    pub path: PathBuf,
    about: &'static str,
}

impl ReplaceFile {
    pub fn new(purpose: Purpose, path: PathBuf) -> Self {
        let is_link = std::fs::symlink_metadata(&path).is_ok_and(|file| file.is_symlink());
        let about = match (is_link, is_ours(&path)) {
            (true, _) => "It is a link. The link is replaced by the file; its target stays as it is.",
            (false, true) => "Burstscope wrote it. Its content will be lost.",
            (false, false) => "Burstscope did not write it. Its content will be lost.",
        };
        Self { purpose, path, about }
    }

    pub fn ui(&self, ctx: &egui::Context) -> Option<bool> {
        confirm_ui(ctx, "replace file", "Replace this file?", "Replace", |ui| {
            ui.label(self.path.display().to_string());
            ui.add_space(4.0);
            ui.label(self.about);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pasted_paths_are_understood() {
        for text in ["  /data/a b ", "'/data/a b'", "\"/data/a b\"", "file:///data/a b"] {
            assert_eq!(path_from_text(text), PathBuf::from("/data/a b"));
        }
        if let Some(home) = std::env::home_dir() {
            assert_eq!(path_from_text("~/bursts"), home.join("bursts"));
        }
    }
}
