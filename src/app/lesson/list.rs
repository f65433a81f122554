//! List of the lessons, with the user's progress in each.

use super::state::Lessons;
use crate::app::actions::{ActionId, Queue};
use crate::teach::Lesson;
use egui::{RichText, ScrollArea, Ui, vec2};
use std::sync::Arc;

/// Chosen lesson, if any.
pub type Chosen = Option<Arc<Lesson>>;

/// Draws the list if it is open. Returns the chosen lesson.
pub fn list_ui(ctx: &egui::Context, lessons: &mut Lessons, queue: &mut Queue) -> Chosen {
    if !lessons.list_is_open {
        return None;
    }
    let mut chosen = None;
    let modal = egui::Modal::new(egui::Id::unique("lessons")).show(ctx, |ui| {
        ui.set_width(520.0);
        ui.heading("Lessons");
        ui.weak("Each takes a few minutes and runs in this window. What is open now comes back afterwards.");
        ui.add_space(8.0);
        ScrollArea::vertical().max_height(480.0).min_scrolled_height(300.0).show(ui, |ui| {
            chosen = rows_ui(ui, lessons);
        });
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            if ui.button("Close").clicked() {
                ui.close();
            }
            let own = ui.button("Open lessons…").on_hover_text("A folder of your own lessons (TOML files)");
            if own.clicked() {
                queue.push(ActionId::OpenLessons);
                ui.close();
            }
        });
    });
    if chosen.is_some() || modal.should_close() {
        lessons.list_is_open = false;
    }
    chosen
}

/// Draws a row for each lesson. Returns the chosen one.
pub fn rows_ui(ui: &mut Ui, lessons: &Lessons) -> Chosen {
    let mut chosen = None;
    for lesson in lessons.all() {
        let progress = lessons.progress_in(lesson);
        let (done, count) = (progress.done.len(), lesson.steps.len());
        let state = match done {
            0 if progress.step == 0 => format!("{count} steps"),
            done if done == count => "✔ done".to_owned(),
            _ => format!("step {} of {count}", progress.step + 1),
        };
        let button =
            egui::Button::new(RichText::new(&lesson.title).strong()).min_size(vec2(ui.available_width(), 26.0));
        let response = ui.add(button);
        response
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Lesson: {}", lesson.title)));
        if response.on_hover_text(&lesson.about).clicked() {
            chosen = Some(lesson.clone());
        }
        ui.add(egui::Label::new(RichText::new(format!("{state} · {}", lesson.about)).weak()).wrap());
        ui.add_space(6.0);
    }
    chosen
}
