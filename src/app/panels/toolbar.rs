//! The toolbar: open, the kind of picture, detect.

use crate::app::actions::{ActionId, Queue, button_ui, checked, enabled, tooltip};
use crate::app::state::Model;
use crate::app::state::scrub::ViewKind;
use egui::{Align, Button, Color32, Layout, ProgressBar, RichText, Ui};

/// Draws the toolbar.
pub fn toolbar_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    ui.horizontal(|ui| {
        button_ui(ui, model, queue, ActionId::OpenFolder, Some("Open…"));
        ui.separator();
        kind_switch_ui(ui, model, queue);
        ui.separator();
        detect_ui(ui, model, queue);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let palette = ActionId::Palette.action();
            let keys = palette.shortcut.map(|s| ui.ctx().format_shortcut(&s)).unwrap_or_default();
            let find = Button::new(RichText::new("Find action").weak()).shortcut_text(RichText::new(keys).weak());
            if ui.add(find).on_hover_text(tooltip(ui.ctx(), palette)).clicked() {
                queue.push(ActionId::Palette);
            }
            button_ui(ui, model, queue, ActionId::Shortcuts, Some("?"));
            ui.separator();
            for (id, label) in
                [(ActionId::ToggleRight, "Right"), (ActionId::ToggleBottom, "Bottom"), (ActionId::ToggleLeft, "Left")]
            {
                button_ui(ui, model, queue, id, Some(label));
            }
        });
    });
}

fn kind_switch_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for (kind, id) in ViewKind::ALL.into_iter().zip([ActionId::ShowFrame, ActionId::ShowStack, ActionId::ShowDog]) {
            button_ui(ui, model, queue, id, Some(kind.label()));
        }
    });
}

fn detect_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    if let Some(running) = model.busy.detecting {
        button_ui(ui, model, queue, ActionId::Cancel, None);
        let (fraction, stage) =
            running.progress.map_or((0.0, "Starting".to_owned()), |p| (p.fraction, p.stage.to_string()));
        let seconds = running.started.elapsed().as_secs_f32();
        let text = format!("{stage}  {:.0} %  {seconds:.1} s", 100.0 * fraction);
        ui.add(ProgressBar::new(fraction).desired_width(210.0).text(text));
        return;
    }
    let action = ActionId::Detect.action();
    let needed = model.needs_detection();
    let mut text = RichText::new("Detect");
    if needed {
        text = text.color(Color32::WHITE).strong();
    }
    let mut button = Button::new(text);
    if needed {
        button = button.fill(crate::app::style::ACCENT);
    }
    let tip = match &model.param_error {
        Some(error) => format!("{error}"),
        None => tooltip(ui.ctx(), action),
    };
    let response = ui.add_enabled(enabled(ActionId::Detect, model), button);
    if response.on_hover_text(tip.clone()).on_disabled_hover_text(tip).clicked() {
        queue.push(ActionId::Detect);
    }
    let mut auto = checked(ActionId::AutoDetect, model).unwrap_or(false);
    let tip = tooltip(ui.ctx(), ActionId::AutoDetect.action());
    if ui.checkbox(&mut auto, "Auto").on_hover_text(tip).clicked() {
        queue.push(ActionId::AutoDetect);
    }
    if let Some(found) = &model.found {
        let count = model.features().len();
        let noun = if count == 1 { "feature" } else { "features" };
        let text = format!("{count} {noun} in {:.2} s", found.elapsed.as_secs_f32());
        let times = &found.detection.times;
        let stages = format!(
            "Noise {:.2} s, search {:.2} s, descriptors {:.2} s",
            times.noise_secs, times.search_secs, times.describe_secs
        );
        ui.weak(text).on_hover_text(stages);
    }
}
