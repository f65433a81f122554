//! Choice of one burst in a folder of several.

use crate::requests::BurstSource;
use egui::{RichText, ScrollArea, Ui, vec2};

/// Draws the choice among `bursts` if there are any. Returns the chosen one; then, or when the dialog is closed,
/// `bursts` becomes empty.
pub fn chooser_ui(ctx: &egui::Context, bursts: &mut Vec<BurstSource>) -> Option<BurstSource> {
    if bursts.is_empty() {
        return None;
    }
    let mut chosen = None;
    let modal = egui::Modal::new(egui::Id::unique("burst chooser")).show(ctx, |ui| {
        ui.set_width(360.0);
        ui.heading(format!("{} bursts in this folder", bursts.len()));
        ui.weak("Choose the burst to open.");
        ui.add_space(6.0);
        ScrollArea::vertical().max_height(320.0).min_scrolled_height(200.0).show(ui, |ui| {
            for burst in bursts.iter() {
                if row_ui(ui, burst).clicked() {
                    chosen = Some(burst.clone());
                }
            }
        });
        ui.add_space(6.0);
        if ui.button("Cancel").clicked() {
            ui.close();
        }
    });
    if chosen.is_some() || modal.should_close() {
        bursts.clear();
    }
    chosen
}

fn row_ui(ui: &mut Ui, burst: &BurstSource) -> egui::Response {
    // Stacks of one name in several folders are distinguished by their folders.
    let folder = match burst {
        BurstSource::Paths(paths) => paths.first().and_then(|p| p.parent()?.file_name()),
        BurstSource::Demo
        | BurstSource::DemoLater
        | BurstSource::Example(_)
        | BurstSource::Chart(_)
        | BurstSource::DarkCopy { .. } => None,
    };
    let folder = folder.map_or_else(String::new, |f| f.to_string_lossy().into_owned());
    let name = format!("{} in {folder}", burst.label());
    let button = egui::Button::new(burst.label())
        .min_size(vec2(ui.available_width(), 24.0))
        .right_text(RichText::new(format!("in {folder}")).weak());
    let response = ui.add(button);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    response
}
