//! Question whether a file may be replaced. The system's own dialog asks it itself; for a typed path the window asks.

use super::Purpose;
use crate::export::is_ours;
use std::path::PathBuf;

/// Existing file at the path of a new one.
#[derive(Debug, Clone)]
pub struct ReplaceFile {
    /// Purpose of the new file.
    pub purpose: Purpose,
    /// Path of the file.
    pub path: PathBuf,
    about: &'static str,
}

impl ReplaceFile {
    /// Creates the question about the file at `path`.
    pub fn new(purpose: Purpose, path: PathBuf) -> Self {
        let is_link = std::fs::symlink_metadata(&path).is_ok_and(|file| file.is_symlink());
        let about = match (is_link, is_ours(&path)) {
            (true, _) => "It is a link. The link is replaced by the file; its target stays as it is.",
            (false, true) => "Burstscope wrote it. Its content will be lost.",
            (false, false) => "Burstscope did not write it. Its content will be lost.",
        };
        Self { purpose, path, about }
    }

    /// Draws the question. Returns whether the file may be replaced, once that is decided.
    pub fn ui(&self, ctx: &egui::Context) -> Option<bool> {
        let mut answer = None;
        let modal = egui::Modal::new(egui::Id::unique("replace file")).show(ctx, |ui| {
            ui.set_width(420.0);
            ui.heading("Replace this file?");
            ui.add_space(4.0);
            ui.label(self.path.display().to_string());
            ui.add_space(4.0);
            ui.label(self.about);
            ui.add_space(6.0);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.button("Replace").clicked() {
                    answer = Some(true);
                }
                if ui.button("Cancel").clicked() {
                    answer = Some(false);
                }
            });
        });
        answer.or_else(|| modal.should_close().then_some(false))
    }
}
