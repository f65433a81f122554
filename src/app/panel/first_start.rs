//! Card of the first start, over the demo: what this is, and the ways to go on. Once dismissed it never returns.

use crate::app::actions::Queue;
use crate::app::document::Action;
use crate::app::lesson::{Chosen, Lessons};
use crate::app::project::Model;
use crate::app::project::workspace::Workspace;
use crate::app::style;
use crate::requests::BurstSource;
use egui::{Align2, Area, Button, Color32, Context, Frame, Id, Rect, RichText, Stroke, vec2};

/// Width of the card, in points.
const WIDTH: f32 = 336.0;
/// Minimum size of a picture with the card over it, in points.
const ROOM: egui::Vec2 = vec2(400.0, 260.0);

pub fn is_shown(model: &Model) -> bool {
    let of_demo = model.slots.a.burst.as_ref().is_some_and(|open| open.source == BurstSource::Demo);
    model.panels.welcome && of_demo && !model.is_in_lesson() && model.workspace == Workspace::Inspect
}

/// Draws the card over the picture in `rect_ui`, if it is shown. Returns the chosen lesson.
pub fn card_ui(ctx: &Context, model: &Model, lessons: &Lessons, rect_ui: Rect, queue: &mut Queue) -> Chosen {
    if !is_shown(model) || rect_ui.width() < ROOM.x || rect_ui.height() < ROOM.y {
        return None;
    }
    let (mut chosen, mut panels) = (None, model.panels);
    let corner = rect_ui.left_bottom() + vec2(16.0, -16.0);
    Area::new(Id::unique("first start")).pivot(Align2::LEFT_BOTTOM).fixed_pos(corner).show(ctx, |ui| {
        let frame = Frame::popup(ui.style()).stroke(Stroke::new(1.0, style::ACCENT)).inner_margin(14).corner_radius(8);
        frame.show(ui, |ui| {
            ui.set_width(WIDTH);
            ui.label(RichText::new("A street at night: ten dark frames").size(15.0).strong());
            ui.label("Drag Slope u: each depth comes out at its own slope.");
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
    queue.set(&model.panels, panels, Action::SetPanels);
    chosen
}
