//! Curves kept for comparison: whether they are shown, their names, and their removal.

use crate::app::panel::widgets::name_field;
use crate::app::project::lab::Lab;
use egui::{TextEdit, Ui};

/// Draws the list.
pub fn kept_ui(ui: &mut Ui, lab: &mut Lab) {
    let mut forgotten = None;
    for (index, kept) in lab.kept.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            let shown = ui.checkbox(&mut kept.is_shown, "").on_hover_text(kept.result.report.summary());
            shown.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::CheckBox, true, kept.is_shown, format!("Show {}", kept.name))
            });
            let field = ui.add(TextEdit::singleline(&mut kept.name).desired_width(120.0));
            name_field(&field, "Name of kept curves", &kept.name);
            if ui.small_button("Remove").on_hover_text("Remove these curves").clicked() {
                forgotten = Some(index);
            }
        });
    }
    if let Some(index) = forgotten {
        lab.forget_kept(index);
    }
}
