//! Panel of the open lesson, a presenter's keys, frames and rings around what a step speaks of, the list of lessons.

use super::snr::{shown_spot, snr_ui};
use super::{LessonAction, Lessons, OpenLesson};
use crate::app::actions::{ActionId, Queue};
use crate::app::panel::widgets::{close_ui, modal_ui, named, weak_ui};
use crate::app::{document::Side, inspector::PaneWidgets, pane::PaneId};
use crate::app::{parts, style};
use crate::app::{results::Read, words::caption_ui};
use crate::teach::Lesson;
use egui::{
    Align, Button, Color32, Context, Frame, Id, Key, LayerId, Layout, Margin, Modifiers, Order, RichText, ScrollArea,
    Sense, Stroke, StrokeKind, Ui, pos2, vec2,
};

/// Size of the lesson's letters in a hall, in parts of the usual one.
const LETTERS_IN_HALL: f32 = 1.5;

/// Draws a text under its title, in letters larger than those of the body.
fn text_ui(ui: &mut Ui, title: &str, add_contents: impl FnOnce(&mut Ui)) {
    let size = egui::TextStyle::Body.resolve(ui.style()).size / 13.0;
    ui.label(RichText::new(title).size(17.0 * size).strong());
    ui.add_space(4.0);
    ui.scope(|ui| {
        ui.style_mut().text_styles.insert(egui::TextStyle::Body, egui::FontId::proportional(14.0 * size));
        add_contents(ui);
    });
}

pub fn lesson_ui(ui: &mut Ui, lessons: &mut Lessons, model: Read<'_>, queue: &mut Queue) -> Option<LessonAction> {
    let next = lessons.next_lesson();
    let (open, mut asked) = (lessons.open.as_mut()?, None);
    if model.document.panels.hall {
        ui.style_mut().text_styles.values_mut().for_each(|font| font.size *= LETTERS_IN_HALL);
    }
    header_ui(ui, open, &mut asked);
    ui.separator();
    egui::Panel::bottom("lesson steps").frame(Frame::new().inner_margin(Margin::symmetric(0, 6))).show(ui, |ui| {
        steps_ui(ui, open, next.as_deref(), &mut asked);
    });
    if open.is_ended {
        let area = ScrollArea::vertical().id_salt("lesson end").auto_shrink(false);
        area.show(ui, |ui| end_ui(ui, open, next.as_deref()));
        return asked;
    }
    ScrollArea::vertical().id_salt(("lesson", open.step)).auto_shrink(false).show(ui, |ui| {
        let step = open.step().clone();
        text_ui(ui, &step.title, |ui| caption_ui(ui, &step.caption));
        ui.add_space(6.0);
        if let Some(spot) = step.state.spot {
            Frame::group(ui.style()).show(ui, |ui| {
                snr_ui(ui, model, &mut open.snr, spot, step.state.slope.unwrap_or_default(), queue);
            });
            ui.add_space(6.0);
        }
        if let Some(task) = &step.task {
            task_ui(ui, &task.text, open);
        }
        if !open.is_ready {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.weak("Opening the burst of this step…");
            });
        }
    });
    asked
}

fn header_ui(ui: &mut Ui, open: &OpenLesson, asked: &mut Option<LessonAction>) {
    ui.horizontal(|ui| {
        ui.weak("Lesson");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            for (label, name, tip, action) in [
                ("Leave", "Leave lesson", "Close the lesson; what was open before it comes back", LessonAction::Leave),
                ("↺", "Set the step up again", "Set this step up again, as it began", LessonAction::Again),
            ] {
                let button = ui.button(label).on_hover_text(tip);
                named(&button, egui::Role::Button, name);
                *asked = button.clicked().then_some(action).or(*asked);
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(egui::Label::new(RichText::new(&open.lesson.title).strong()).truncate());
            });
        });
    });
}

fn task_ui(ui: &mut Ui, text: &str, open: &OpenLesson) {
    let done = open.is_done();
    let colour = if done { style::good(ui) } else { style::ACCENT };
    let frame = Frame::new().fill(colour.gamma_multiply(0.14)).stroke(Stroke::new(1.0, colour.gamma_multiply(0.7)));
    frame.corner_radius(6).inner_margin(Margin::symmetric(10, 7)).show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.label(RichText::new(if done { "✔ Done" } else { "Try it" }).strong().color(colour));
        caption_ui(ui, text);
    });
}

/// Draws the lesson's end: the lines of what was learnt, and what the next lesson is about.
fn end_ui(ui: &mut Ui, open: &OpenLesson, next: Option<&Lesson>) {
    text_ui(ui, "What you have learnt", |ui| {
        for line in &open.lesson.learnt {
            caption_ui(ui, &format!("- {line}"));
            ui.add_space(4.0);
        }
    });
    let missing = open.lesson.steps.len() - open.done.len();
    if missing > 0 {
        let steps = if missing == 1 { "1 step was" } else { &format!("{missing} steps were") };
        ui.add_space(6.0);
        ui.weak(format!("{steps} not tried: the empty dots below lead there."));
    }
    if let Some(next) = next {
        ui.add_space(10.0);
        ui.label(RichText::new(format!("Next: {}", next.title)).strong());
        weak_ui(ui, &next.about);
    }
}

fn steps_ui(ui: &mut Ui, open: &OpenLesson, next_lesson: Option<&Lesson>, clicked: &mut Option<LessonAction>) {
    let (step, count) = (open.step, open.lesson.steps.len());
    ui.separator();
    ui.horizontal(|ui| {
        ui.weak(if open.is_ended { "The end".to_owned() } else { format!("Step {} of {count}", step + 1) });
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| dots_ui(ui, open, clicked));
    });
    ui.add_space(3.0);
    ui.horizontal(|ui| {
        let size = vec2(0.5 * (ui.available_width() - ui.spacing().item_spacing.x), 28.0);
        let before = open.back();
        let back = ui.add_enabled(before.is_some(), Button::new("Back").min_size(size));
        back.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, before.is_some(), "Step back"));
        *clicked = before.filter(|_| back.on_hover_text("The step before").clicked()).or(*clicked);
        let asked = open.onward(next_lesson.is_some());
        let (label, name) = match asked {
            LessonAction::NextLesson => ("Next lesson", "Next lesson"),
            LessonAction::End => ("Finish", "Finish the lesson"),
            LessonAction::Step(_) => ("Next", "Next step"),
            LessonAction::Again | LessonAction::Leave => ("Close", "Close the lesson"),
        };
        let is_done = open.is_ended || open.is_done() || open.step().task.is_none();
        let colour = if is_done { Color32::WHITE } else { ui.visuals().text_color() };
        let next = Button::new(RichText::new(label).color(colour));
        let next = if is_done { next.fill(style::ACCENT) } else { next };
        let next = ui.add(next.min_size(size));
        named(&next, egui::Role::Button, name);
        *clicked = next.clicked().then_some(asked).or(*clicked);
    });
}

/// Draws a dot for each step. The first is on the left, although drawing runs from the right.
fn dots_ui(ui: &mut Ui, open: &OpenLesson, asked: &mut Option<LessonAction>) {
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
        if place == open.step && !open.is_ended {
            painter.circle_stroke(rect.center(), 6.0, Stroke::new(1.5, style::ACCENT));
        }
        *asked = response.on_hover_text(title).clicked().then_some(LessonAction::Step(place)).or(*asked);
    }
}

/// Colour of the frame; also that of the selection in pictures.
pub(super) const HIGHLIGHT: Color32 = Color32::from_rgb(255, 200, 60);

pub fn highlights_ui(ctx: &Context) {
    let painter = ctx.layer_painter(LayerId::new(Order::Middle, Id::unique("lesson highlight")));
    for (_, rect) in parts::drawn(ctx) {
        let rect = rect.expand(3.0).intersect(ctx.content_rect().shrink(2.0));
        // A glow around it makes it visible over bright and dark pictures.
        for (width, alpha) in [(9.0, 26), (6.0, 50)] {
            let glow = Color32::from_rgba_unmultiplied(HIGHLIGHT.r(), HIGHLIGHT.g(), HIGHLIGHT.b(), alpha);
            painter.rect_stroke(rect, 6.0, Stroke::new(width, glow), StrokeKind::Middle);
        }
        painter.rect_stroke(rect, 5.0, Stroke::new(2.0, HIGHLIGHT), StrokeKind::Middle);
    }
}

pub type Chosen = Option<std::sync::Arc<Lesson>>;

pub fn list_ui(ctx: &egui::Context, lessons: &mut Lessons, queue: &mut Queue) -> Chosen {
    let (mut chosen, mut is_open) = (None, lessons.list_is_open);
    modal_ui(ctx, &mut is_open, ("lessons", 520.0, "Lessons"), |ui| {
        ui.weak("Each takes a few minutes and runs in this window. What is open now comes back afterwards.");
        ui.add_space(8.0);
        // Of one height in all passes, so that no row moves under the pointer.
        let height = (ctx.content_rect().height() - 200.0).clamp(120.0, 480.0);
        let area = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
        area.auto_shrink(false).show(ui, |ui| chosen = rows_ui(ui, lessons));
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            close_ui(ui, "Close");
            if ui.button("Open lessons…").on_hover_text("A folder of your own lessons (TOML files)").clicked() {
                queue.push(ActionId::OpenLessons);
                ui.close();
            }
        });
    });
    lessons.list_is_open = is_open && chosen.is_none();
    chosen
}

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
        let button = Button::new(RichText::new(&lesson.title).strong());
        let response = ui.add(button.min_size(vec2(ui.available_width(), 26.0)));
        named(&response, egui::Role::Button, format!("Lesson: {}", lesson.title));
        chosen = response.on_hover_text(&lesson.about).clicked().then(|| lesson.clone()).or(chosen);
        weak_ui(ui, format!("{state} · {}", lesson.about));
        ui.add_space(6.0);
    }
    chosen
}

/// Steps that are asked for by keys in a hall: those of a presenter, and the arrows.
pub fn take_hall_keys(ctx: &Context, lessons: &Lessons, model: Read<'_>) -> Option<LessonAction> {
    let open = lessons.open.as_ref().filter(|_| model.document.panels.hall && !ctx.egui_wants_keyboard_input())?;
    let pressed = |keys: [Key; 2]| {
        ctx.input_mut(|input| keys.into_iter().filter(|key| input.consume_key(Modifiers::NONE, *key)).count() > 0)
    };
    if pressed([Key::PageDown, Key::ArrowRight]) {
        // At the end of the last lesson a presenter's key closes nothing.
        Some(open.onward(lessons.next_lesson().is_some())).filter(|asked| *asked != LessonAction::Leave)
    } else if pressed([Key::PageUp, Key::ArrowLeft]) {
        open.back()
    } else {
        None
    }
}

/// Draws rings around the places that the open step names, and around the spot that it measures.
pub fn rings_ui(ctx: &Context, lessons: &Lessons, model: Read<'_>, widgets: &PaneWidgets) {
    let Some(open) = lessons.open.as_ref().filter(|open| open.is_ready && !open.is_ended) else { return };
    let state = &open.step().state;
    let mut rings: Vec<_> = state.rings.iter().flatten().map(|ring| (ring.place, ring.radius)).collect();
    if let Some(spot) = state.spot
        && let Some((_, place)) = shown_spot(model, spot, state.slope.unwrap_or_default())
    {
        rings.extend([spot.inner, spot.ground[0], spot.ground[1]].map(|radius| (place, radius)));
    }
    let is_picture = |id: &PaneId| model.pane(*id).is_some_and(|pane| pane.side == Side::A && pane.shown().is_some());
    for id in model.document.panes.shown().into_iter().filter(is_picture) {
        let (Some(ui_from_image), Some(rect_ui)) = (widgets.ui_from_image(id), widgets.rect_ui(id)) else { continue };
        let layer = LayerId::new(Order::Background, Id::unique("lesson rings"));
        let painter = ctx.layer_painter(layer).with_clip_rect(rect_ui);
        for ([u, v], radius) in &rings {
            let centre = ui_from_image.pos(pos2(*u, *v));
            let radius = centre.distance(ui_from_image.pos(pos2(u + radius, *v)));
            for (width, colour) in [(3.5, Color32::from_black_alpha(160)), (1.5, HIGHLIGHT)] {
                painter.circle_stroke(centre, radius, Stroke::new(width, colour));
            }
        }
    }
}
