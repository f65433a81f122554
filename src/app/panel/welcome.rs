//! What the window shows before a burst is open, and while files are held over it.

use crate::app::actions::menu::dataset_label;
use crate::app::actions::{ActionId, Queue, keys_text, tooltip};
use crate::app::project::Model;
use crate::app::settings::{Recent, Settings};
use egui::{Align2, Color32, ProgressBar, Rect, RichText, Ui, vec2};

/// Draws the first page: what this is, how to open a burst, what was open before.
pub fn welcome_ui(
    ui: &mut Ui,
    model: &Model,
    remembered: &Settings,
    queue: &mut Queue,
    open_recent: &mut Option<Recent>,
) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.22).max(16.0));
        ui.label(RichText::new("Burstscope").size(28.0).strong());
        ui.weak("See what a burst of dark, noisy frames shows at every slope and scale");
        ui.add_space(20.0);
        if let Some(running) = model.busy.opening {
            let fraction = running.progress.map_or(0.0, |p| p.fraction);
            ui.add(ProgressBar::new(fraction).desired_width(280.0).text("Opening…"));
            if ui.button("Cancel").clicked() {
                queue.push(ActionId::Cancel);
            }
            return;
        }
        for id in
            [ActionId::OpenFolder, ActionId::OpenFiles, ActionId::OpenDataset, ActionId::OpenPath, ActionId::OpenDemo]
        {
            let action = id.action();
            let keys = action.shortcut.as_ref().map_or_else(String::new, |s| keys_text(ui.ctx(), s));
            let button =
                egui::Button::new(action.label).min_size(vec2(280.0, 28.0)).right_text(RichText::new(keys).weak());
            let response = ui.add(button);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, action.label));
            if response.on_hover_text(tooltip(ui.ctx(), action)).clicked() {
                queue.push(id);
            }
        }
        ui.add_space(8.0);
        ui.weak("or drop a folder, a folder of bursts, image files, a multi-page TIFF or a .npy stack here");
        let bursts = remembered.recent.iter().take(6).map(|s| (s.label(), Recent::Burst(s.clone())));
        let datasets = remembered.datasets.iter().take(4).map(|s| (dataset_label(s), Recent::Dataset(s.clone())));
        let mut recent = bursts.chain(datasets).peekable();
        if recent.peek().is_some() {
            ui.add_space(18.0);
            ui.label(RichText::new("Recent").strong());
        }
        for (label, what) in recent {
            if ui.link(label).clicked() {
                *open_recent = Some(what);
            }
        }
    });
}

/// Says that files can be let go while they are held over the window; `panes` are the places where what is dropped
/// opens, with what is said there.
pub fn drop_hint_ui(ctx: &egui::Context, panes: &[(Rect, &str)]) {
    if ctx.input(|i| i.raw.hovered_files.is_empty()) {
        return;
    }
    let painter = ctx.layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop hint")));
    painter.rect_filled(ctx.content_rect(), 0.0, Color32::from_black_alpha(170));
    let font = egui::FontId::proportional(22.0);
    for (rect, text) in panes {
        painter.text(rect.center(), Align2::CENTER_CENTER, *text, font.clone(), Color32::WHITE);
    }
}
