//! Field to type a path into, and the question whether a file there may be replaced.

use crate::app::document::{Pointed, Purpose, Queue};
use crate::app::panel::widgets::{accept_ui, confirm_ui, modal_ui, name_field, weak_ui};
use egui::{CompletionPopup, Key, Suggestion, TextEdit};
use std::path::PathBuf;

#[derive(Debug, Clone)]
pub struct PathField {
    pub purpose: Purpose,
    pub text: String,
    pub instead_of_dialog: bool,
    fresh: bool,
    /// The text that was suggested, for which nothing is offered.
    begun: String,
    /// Whether one of the names on offer was chosen with an arrow: Enter then takes it, and does not open the path.
    chooses: bool,
}

impl PathField {
    pub fn new(purpose: Purpose, text: String, instead_of_dialog: bool) -> Self {
        Self { purpose, begun: text.clone(), text, instead_of_dialog, fresh: true, chooses: false }
    }

    /// Draws the field, with `recent` paths of its purpose. Returns an accepted path, and whether the field stays open.
    pub fn ui(
        &mut self,
        ctx: &egui::Context,
        (model, recent): (crate::app::results::Read<'_>, &[String]),
        queue: &mut Queue,
    ) -> (Option<PathBuf>, bool) {
        let (mut accepted, mut stays) = (None, true);
        let pressed = |key| ctx.input(|i| i.key_pressed(key));
        self.chooses |= pressed(Key::ArrowDown) || pressed(Key::ArrowUp);
        let asked = crate::requests::FolderRequest(folder_of(&self.text));
        let listed = model.results.folder.made.as_ref().filter(|(of, _)| *of == asked);
        let names = listed.map_or(&[][..], |(_, names)| names);
        let first = [recent.to_vec(), self.purpose.built_in()].concat();
        let id = egui::Id::unique("typed path");
        if pressed(Key::Tab) && !self.chooses {
            let common = common_start(&offered(&self.text, &first, names));
            self.text = common.unwrap_or(std::mem::take(&mut self.text));
            select(ctx, id, &self.text, [self.text.len(); 2]);
        }
        modal_ui(ctx, &mut stays, ("path field", 480.0, self.purpose.title()), |ui| {
            if self.instead_of_dialog {
                ui.weak("This system shows no file dialog, so please type the path.");
            }
            ui.add_space(4.0);
            let edit = TextEdit::singleline(&mut self.text).hint_text(self.purpose.hint()).desired_width(f32::INFINITY);
            let keys = if self.chooses { vec![Key::Enter, Key::Tab] } else { Vec::new() };
            let popup = CompletionPopup::new(id).word_boundary(|_| false).accept_keys(keys);
            let (chooses, begun) = (self.chooses, &self.begun);
            let shown = popup.show(ui, edit.lock_focus(true), |typed| match typed.word {
                word if !chooses && (word.is_empty() || word == begun) => Vec::new(),
                word => offered(word, &first, names).into_iter().take(MOST).map(Suggestion::new).collect(),
            });
            let edit = shown.text_edit.response.response;
            self.chooses &= !(edit.changed() || shown.accepted.is_some());
            name_field(&edit, "Path", &self.text);
            if std::mem::take(&mut self.fresh) {
                edit.request_focus();
                select(ctx, id, &self.text, stem(&self.text));
            }
            weak_ui(ui, "Tab completes the path. The arrows choose a name, or first one of the paths opened last.");
            let path = path_from_text(&self.text);
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty() && self.purpose.saves());
            if let Some(folder) = folder.filter(|folder| !folder.exists()) {
                ui.weak(format!("The folder {} will be made.", folder.display()));
            }
            if let Some(folder) = std::env::current_dir().ok().filter(|_| path.is_relative()) {
                ui.weak(format!("From {}", folder.display()));
            }
            ui.add_space(6.0);
            let entered = edit.lost_focus() && pressed(Key::Enter);
            let verb = if self.purpose.saves() { "Save" } else { "Open" };
            let is_ready = !self.text.trim().is_empty();
            if (accept_ui(ui, verb, is_ready).clicked() || entered) && is_ready {
                accepted = Some(path);
                ui.close();
            }
        });
        let asked = stays.then_some(asked);
        queue.set(&model.results.folder.asked, asked, |asked| Pointed::Folder(asked).into());
        (accepted, stays)
    }
}

const MOST: usize = 200;

fn folder_of(text: &str) -> PathBuf {
    let folder = path_from_text(&text[..name_start(text)]);
    if folder.as_os_str().is_empty() { ".".into() } else { folder }
}

fn name_start(text: &str) -> usize {
    text.rfind('/').map_or(0, |slash| slash + 1)
}

/// Texts that begin with `text`: of the `first`, then paths with one of the `names` in its folder.
fn offered(text: &str, first: &[String], names: &[String]) -> Vec<String> {
    let (folder, begun) = text.split_at(name_start(text));
    let is_shown = |name: &&String| !name.starts_with('.') || begun.starts_with('.');
    let paths = names.iter().filter(is_shown).map(|name| format!("{folder}{name}"));
    let all = first.iter().cloned().chain(paths.filter(|path| !first.contains(path)));
    all.filter(|whole| whole.starts_with(text) && whole != text).collect()
}

fn common_start(texts: &[String]) -> Option<String> {
    let first = texts.first()?;
    let ends = first.char_indices().map(|(place, letter)| place + letter.len_utf8());
    let common = ends.take_while(|end| texts.iter().all(|text| text.starts_with(&first[..*end]))).last()?;
    Some(first[..common].to_owned())
}

/// The name without its extension, so that typing replaces the name and keeps the extension.
fn stem(text: &str) -> [usize; 2] {
    let name = name_start(text);
    // A name with two extensions keeps both.
    [name, text[name..].find('.').filter(|dot| *dot > 0).map_or(text.len(), |dot| name + dot)]
}

fn select(ctx: &egui::Context, id: egui::Id, text: &str, places: [usize; 2]) {
    let mut state = TextEdit::load_state(ctx, id).unwrap_or_default();
    let [from, to] = places.map(|place| egui::text::CCursor::new(text[..place].chars().count()));
    state.cursor.set_char_range(Some(egui::text::CCursorRange::two(from, to)));
    TextEdit::store_state(ctx, id, state);
}

/// Removes surrounding blanks, quotes and a leading `file://`; replaces a leading `~/` by the home folder.
pub fn path_from_text(text: &str) -> PathBuf {
    let text = text.trim();
    let unquoted = ['"', '\''].iter().find_map(|q| text.strip_prefix(*q)?.strip_suffix(*q)).unwrap_or(text);
    let plain = unquoted.strip_prefix("file://").unwrap_or(unquoted);
    let below_home = plain.strip_prefix("~/").zip(std::env::home_dir());
    below_home.map_or_else(|| PathBuf::from(plain), |(rest, home)| home.join(rest))
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
        let about = match (is_link, crate::export::is_ours(&path)) {
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

    #[test]
    fn tab_completes_to_where_names_part_and_hidden_names_are_asked_for() {
        let list = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let (first, names) = (list(&["demo", "demo-later", "/old/b"]), list(&[".git/", "day/", "näht/", "nähte.npy"]));
        assert_eq!(offered("n", &first, &names), ["näht/", "nähte.npy"]);
        assert_eq!(common_start(&offered("n", &first, &names)).as_deref(), Some("näht"));
        assert_eq!(common_start(&offered("x", &first, &names)), None);
        assert_eq!(offered("", &first, &names).len(), 6, "without the hidden one");
        assert_eq!(offered("~/.", &first, &names), ["~/.git/"]);
        assert_eq!(offered("demo", &first, &names), ["demo-later"]);
        assert_eq!((folder_of("a"), folder_of("/a/b")), (PathBuf::from("."), PathBuf::from("/a/")));
    }
}
