//! Frames around the parts of the window that a step highlights.

use crate::app::parts;
use egui::{Color32, Context, CornerRadius, Id, LayerId, Order, Stroke, StrokeKind};

/// Colour of the frame; also that of the selection in pictures.
const COLOUR: Color32 = Color32::from_rgb(255, 200, 60);

/// Draws frames around the highlighted parts.
pub fn highlights_ui(ctx: &Context) {
    let painter = ctx.layer_painter(LayerId::new(Order::Middle, Id::unique("lesson highlight")));
    for (_, rect) in parts::drawn(ctx) {
        let rect = rect.expand(3.0).intersect(ctx.content_rect().shrink(2.0));
        // A glow around it makes it visible over bright and dark pictures.
        for (width, alpha) in [(9.0, 26), (6.0, 50)] {
            let glow = Color32::from_rgba_unmultiplied(COLOUR.r(), COLOUR.g(), COLOUR.b(), alpha);
            painter.rect_stroke(rect, CornerRadius::same(6), Stroke::new(width, glow), StrokeKind::Middle);
        }
        painter.rect_stroke(rect, CornerRadius::same(5), Stroke::new(2.0, COLOUR), StrokeKind::Middle);
    }
}
