//! What a step points at: a frame around it that nothing else has.

use crate::app::parts;
use egui::{Color32, Context, CornerRadius, Id, LayerId, Order, Stroke, StrokeKind};

/// The colour of the frame; the one of what is selected in pictures.
const COLOUR: Color32 = Color32::from_rgb(255, 200, 60);

/// Draws the frames around what is pointed at.
pub fn highlights_ui(ctx: &Context) {
    let painter = ctx.layer_painter(LayerId::new(Order::Middle, Id::unique("lesson highlight")));
    for (_, rect) in parts::drawn(ctx) {
        let rect = rect.expand(3.0).intersect(ctx.content_rect().shrink(2.0));
        // Around it a glow, so that it is seen over bright and dark pictures alike.
        for (width, alpha) in [(9.0, 26), (6.0, 50)] {
            let glow = Color32::from_rgba_unmultiplied(COLOUR.r(), COLOUR.g(), COLOUR.b(), alpha);
            painter.rect_stroke(rect, CornerRadius::same(6), Stroke::new(width, glow), StrokeKind::Middle);
        }
        painter.rect_stroke(rect, CornerRadius::same(5), Stroke::new(2.0, COLOUR), StrokeKind::Middle);
    }
}
