//! Small drawn buttons of a pane's header.

use egui::{Pos2, Rect, Response, Sense, Stroke, StrokeKind, Ui, pos2, vec2};

/// Picture on a button.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Icon {
    /// Pane split to the right.
    SplitRight,
    /// Pane split downwards.
    SplitDown,
    /// Three lines: a menu.
    Menu,
    /// A cross.
    Close,
}

/// Size of a button, in points.
pub const ICON_SIZE: egui::Vec2 = vec2(20.0, 18.0);

/// Draws a button called `name`.
pub fn icon_button_ui(ui: &mut Ui, icon: Icon, name: &str, tip: &str, enabled: bool) -> Response {
    let sense = if enabled { Sense::click() } else { Sense::hover() };
    let (rect, response) = ui.allocate_exact_size(ICON_SIZE, sense);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, name));
    if response.hovered() && enabled {
        ui.painter().rect_filled(rect, 4.0, ui.visuals().widgets.hovered.weak_bg_fill);
    }
    let colour =
        if response.hovered() && enabled { ui.visuals().strong_text_color() } else { ui.visuals().weak_text_color() };
    draw(ui, icon, rect, Stroke::new(1.0, colour));
    response.on_hover_text(tip)
}

fn draw(ui: &Ui, icon: Icon, rect: Rect, stroke: Stroke) {
    let painter = ui.painter();
    let frame = Rect::from_center_size(rect.center(), vec2(13.0, 11.0));
    let line = |from: Pos2, to: Pos2| painter.line_segment([from, to], stroke);
    match icon {
        Icon::SplitRight => {
            painter.rect_stroke(frame, 2.0, stroke, StrokeKind::Inside);
            line(pos2(frame.center().x, frame.top()), pos2(frame.center().x, frame.bottom()));
        }
        Icon::SplitDown => {
            painter.rect_stroke(frame, 2.0, stroke, StrokeKind::Inside);
            line(pos2(frame.left(), frame.center().y), pos2(frame.right(), frame.center().y));
        }
        Icon::Menu => {
            for dy in [-3.5, 0.0, 3.5] {
                line(rect.center() + vec2(-5.0, dy), rect.center() + vec2(5.0, dy));
            }
        }
        Icon::Close => {
            for sign in [-1.0, 1.0] {
                line(rect.center() + vec2(-4.0, -4.0 * sign), rect.center() + vec2(4.0, 4.0 * sign));
            }
        }
    }
}
