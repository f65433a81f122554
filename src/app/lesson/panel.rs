//! Panel of the open lesson: step number, explanation, task, back and forward.

use super::caption::Captions;
use super::snr::snr_ui;
use super::state::{Lessons, OpenLesson, Wish};
use crate::app::project::Model;
use crate::app::style;
use egui::{
    Align, Button, Color32, CornerRadius, Frame, Layout, Margin, RichText, ScrollArea, Sense, Stroke, Ui, vec2,
};

/// Clicks in the panel.
#[derive(Debug, Default)]
pub struct LessonClicks {
    /// Request to the lesson.
    pub wish: Option<Wish>,
    /// Name of the glossary entry to open.
    pub word: Option<String>,
}

/// Draws the panel of the open lesson.
pub fn lesson_ui(ui: &mut Ui, lessons: &mut Lessons, model: &mut Model, captions: &mut Captions) -> LessonClicks {
    let mut clicks = LessonClicks::default();
    let Some(open) = &mut lessons.open else { return clicks };
    header_ui(ui, open, &mut clicks);
    ui.separator();
    egui::Panel::bottom("lesson steps").frame(Frame::new().inner_margin(Margin::symmetric(0, 6))).show(ui, |ui| {
        steps_ui(ui, open, &mut clicks);
    });
    ScrollArea::vertical().id_salt(("lesson", open.step)).auto_shrink(false).show(ui, |ui| {
        let step = open.step().clone();
        ui.label(RichText::new(&step.title).size(17.0).strong());
        ui.add_space(4.0);
        ui.scope(|ui| {
            ui.style_mut().text_styles.insert(egui::TextStyle::Body, egui::FontId::proportional(14.0));
            clicks.word = captions.ui(ui, &step.caption);
        });
        ui.add_space(6.0);
        if let Some(spot) = step.state.spot {
            Frame::group(ui.style()).show(ui, |ui| {
                snr_ui(ui, model, &mut open.snr, spot, step.state.slope.unwrap_or_default());
            });
            ui.add_space(6.0);
        }
        if let Some(task) = &step.task {
            let word = task_ui(ui, &task.text, open, captions);
            clicks.word = clicks.word.take().or(word);
        }
        if !open.is_ready {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.weak("Opening the burst of this step…");
            });
        }
    });
    clicks
}

fn header_ui(ui: &mut Ui, open: &OpenLesson, clicks: &mut LessonClicks) {
    ui.horizontal(|ui| {
        ui.weak("Lesson");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let leave = ui.button("Leave").on_hover_text("Close the lesson; what was open before it comes back");
            leave.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "Leave lesson"));
            if leave.clicked() {
                clicks.wish = Some(Wish::Leave);
            }
            let again = ui.button("↺").on_hover_text("Set this step up again, as it began");
            again.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "Set the step up again"));
            if again.clicked() {
                clicks.wish = Some(Wish::Again);
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(egui::Label::new(RichText::new(&open.lesson.title).strong()).truncate());
            });
        });
    });
}

/// Draws the task, with a tick once it is done. Returns the glossary entry whose link was clicked.
fn task_ui(ui: &mut Ui, text: &str, open: &OpenLesson, captions: &mut Captions) -> Option<String> {
    let done = open.is_done();
    let colour = if done { style::good(ui) } else { style::ACCENT };
    let frame = Frame::new()
        .fill(colour.gamma_multiply(0.14))
        .stroke(Stroke::new(1.0, colour.gamma_multiply(0.7)))
        .corner_radius(CornerRadius::same(6))
        .inner_margin(Margin::symmetric(10, 7));
    frame
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            let head = if done { "✔ Done" } else { "Try it" };
            ui.label(RichText::new(head).strong().color(colour));
            captions.ui(ui, text)
        })
        .inner
}

/// Draws the back button, a dot for each step, and the forward button.
fn steps_ui(ui: &mut Ui, open: &OpenLesson, clicks: &mut LessonClicks) {
    let (step, count) = (open.step, open.lesson.steps.len());
    ui.separator();
    ui.horizontal(|ui| {
        ui.weak(format!("Step {} of {count}", step + 1));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| dots_ui(ui, open, clicks));
    });
    ui.add_space(3.0);
    ui.horizontal(|ui| {
        let width = 0.5 * (ui.available_width() - ui.spacing().item_spacing.x);
        let size = vec2(width, 28.0);
        let back = ui.add_enabled(step > 0, Button::new("Back").min_size(size));
        back.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, step > 0, "Step back"));
        if back.on_hover_text("The step before").clicked() {
            clicks.wish = Some(Wish::Step(step - 1));
        }
        let is_last = step + 1 == count;
        let label = if is_last { "Finish" } else { "Next" };
        let is_done = open.is_done() || open.step().task.is_none();
        let mut next =
            Button::new(RichText::new(label).color(if is_done { Color32::WHITE } else { ui.visuals().text_color() }));
        if is_done {
            next = next.fill(style::ACCENT);
        }
        let next = ui.add(next.min_size(size));
        let name = if is_last { "Finish the lesson" } else { "Next step" };
        next.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
        if next.clicked() {
            clicks.wish = Some(if is_last { Wish::Leave } else { Wish::Step(step + 1) });
        }
    });
}

/// Draws a dot for each step. The first is on the left, although drawing runs from the right.
fn dots_ui(ui: &mut Ui, open: &OpenLesson, clicks: &mut LessonClicks) {
    ui.spacing_mut().item_spacing.x = 2.0;
    for place in (0..open.lesson.steps.len()).rev() {
        let (rect, response) = ui.allocate_exact_size(vec2(13.0, 16.0), Sense::click());
        let title = format!("Step {}: {}", place + 1, open.lesson.steps[place].title);
        response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, place == open.step, &title));
        let (good, weak) = (style::good(ui), ui.visuals().weak_text_color());
        let painter = ui.painter();
        if open.done.contains(&place) {
            painter.circle_filled(rect.center(), 4.0, good);
        } else {
            painter.circle_stroke(rect.center(), 4.0, Stroke::new(1.2, weak));
        }
        if place == open.step {
            painter.circle_stroke(rect.center(), 6.0, Stroke::new(1.5, style::ACCENT));
        }
        if response.on_hover_text(title).clicked() {
            clicks.wish = Some(Wish::Step(place));
        }
    }
}
