//! Page shown before a burst is open, the card over the demo at the first start, which never returns once it was
//! dismissed, and the hint shown while files are dragged over the window.

use crate::app::actions::menu::dataset_label;
use crate::app::actions::{ActionId, Queue, keys_text, tooltip};
use crate::app::document::{Action, Side};
use crate::app::lesson::{Chosen, Lessons};
use crate::app::panel::widgets::{named, progress_ui};
use crate::app::{results::Read, settings::Settings, style};
use egui::{Align2, Area, Button, Color32, Context, Frame, Id, Rect, RichText, ScrollArea, Stroke, Ui, vec2};

pub fn welcome_ui(ui: &mut Ui, model: Read<'_>, remembered: &Settings, lessons: &Lessons, queue: &mut Queue) -> Chosen {
    let mut chosen = None;
    let above = (ui.available_height() * 0.10).max(16.0);
    let page = |ui: &mut Ui| {
        ui.add_space(above);
        ui.label(RichText::new("Burstscope").size(28.0).strong());
        ui.weak("See what a burst of dark, noisy frames shows at every slope and scale");
        ui.add_space(20.0);
        if let Some(running) = model.results.slots.a.opening.running {
            progress_ui(ui, &running, Some(280.0), "Opening…");
            queue.push_if(ui.button("Cancel").clicked(), ActionId::Cancel);
            return;
        }
        for id in
            [ActionId::OpenFolder, ActionId::OpenFiles, ActionId::OpenDataset, ActionId::OpenPath, ActionId::OpenDemo]
        {
            let action = id.action();
            let keys = action.shortcut.map(|shortcut| keys_text(ui.ctx(), &shortcut)).unwrap_or_default();
            let button = egui::Button::new(action.label).right_text(RichText::new(keys).weak());
            let response = ui.add(button.min_size(vec2(280.0, 28.0)));
            named(&response, egui::Role::Button, action.label);
            queue.push_if(response.on_hover_text(tooltip(ui.ctx(), action)).clicked(), id);
        }
        ui.add_space(8.0);
        ui.weak("or drop a folder, a folder of bursts, image files, a multi-page TIFF or a .npy stack here");
        let bursts = remembered.recent.iter().take(6).map(|s| (s.label(), Action::Open(Side::A, s.clone())));
        let datasets = remembered.datasets.iter().take(4).map(|s| (dataset_label(s), Action::OpenDataset(s.clone())));
        let mut recent = bursts.chain(datasets).peekable();
        if recent.peek().is_some() {
            ui.add_space(18.0);
            ui.label(RichText::new("Recent").strong());
        }
        for (label, open) in recent {
            queue.push_if(ui.link(label).clicked(), open);
        }
        ui.add_space(18.0);
        ui.label(RichText::new("Lessons").strong());
        ui.weak("Learn on live data how burst features are found, in a few minutes each");
        for lesson in lessons.all() {
            let link = ui.link(&lesson.title).on_hover_text(&lesson.about);
            named(&link, egui::Role::Link, format!("Lesson: {}", lesson.title));
            chosen = link.clicked().then(|| lesson.clone()).or(chosen.take());
        }
    };
    // A small window scrolls.
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| ui.vertical_centered(page));
    chosen
}

/// Draws a hint while files are dragged over the window; `panes` are the places where they open, each with its text.
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

const CARD_WIDTH: f32 = 336.0;
/// Minimum size of a picture with the card over it, in points.
const CARD_ROOM: egui::Vec2 = vec2(400.0, 260.0);

/// Draws the card over the picture in `rect_ui`, if it is shown. Returns the chosen lesson.
pub fn card_ui(ctx: &Context, model: Read<'_>, lessons: &Lessons, rect_ui: Rect, queue: &mut Queue) -> Chosen {
    let of_demo = model.burst_of(Side::A).is_some_and(|open| open.source == crate::requests::BurstSource::Demo);
    let inspects_demo = of_demo && !model.is_in_lesson() && model.document.workspace.inspects();
    let has_room = rect_ui.width() >= CARD_ROOM.x && rect_ui.height() >= CARD_ROOM.y;
    if !(model.document.panels.welcome && inspects_demo && has_room) {
        return None;
    }
    let (mut chosen, mut panels) = (None, model.document.panels);
    let corner = rect_ui.left_bottom() + vec2(16.0, -16.0);
    Area::new(Id::unique("first start")).pivot(Align2::LEFT_BOTTOM).fixed_pos(corner).show(ctx, |ui| {
        let frame = Frame::popup(ui.style()).stroke(Stroke::new(1.0, style::ACCENT)).inner_margin(14).corner_radius(8);
        frame.show(ui, |ui| {
            ui.set_width(CARD_WIDTH);
            ui.strong("Drag in the slope plane: each depth of the dark street comes out at its own slope.");
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                let text = RichText::new("Three-minute lesson").color(Color32::WHITE);
                let first = lessons.all().next();
                if ui.add_enabled(first.is_some(), Button::new(text).fill(style::ACCENT)).clicked() {
                    chosen = first.cloned();
                    panels.welcome = false;
                }
                panels.welcome &= !ui.button("Explore").clicked();
            });
            ui.add_space(4.0);
            ui.weak("Shift+click any place: why there is a feature, or none.");
        });
    });
    queue.edit(model.document, Action::SetPanels(panels));
    chosen
}
