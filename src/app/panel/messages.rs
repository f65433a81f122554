//! Error messages over the picture, until they are dismissed.

use crate::app::project::messages::Messages;
use egui::{Align2, Area, Frame, Id, RichText, vec2};

/// Draws the errors that are not dismissed, in the lower right corner.
pub fn messages_ui(ctx: &egui::Context, messages: &mut Messages) {
    let mut dismissed = None;
    Area::new(Id::unique("messages")).anchor(Align2::RIGHT_BOTTOM, vec2(-12.0, -36.0)).show(ctx, |ui| {
        for message in messages.errors() {
            let colour = ui.visuals().error_fg_color;
            Frame::popup(ui.style()).stroke(egui::Stroke::new(1.0, colour)).show(ui, |ui| {
                ui.set_width(400.0);
                ui.horizontal(|ui| {
                    ui.label(RichText::new(&message.title).strong().color(colour));
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        let name = format!("Dismiss: {}", message.title);
                        let close = ui.add(egui::Button::new("✖").frame(false)).on_hover_text("Dismiss");
                        close.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
                        if close.clicked() {
                            dismissed = Some(message.id);
                        }
                        if ui.small_button("Copy").on_hover_text("Copy the message").clicked() {
                            ui.ctx().copy_text(format!("{}: {}", message.title, message.text));
                        }
                    });
                });
                ui.add(egui::Label::new(&message.text).wrap());
            });
        }
    });
    if let Some(id) = dismissed {
        messages.dismiss(id);
    }
}
