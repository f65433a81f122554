//! Descriptor, drawn as 4×4 roses of eight directions each.

use crate::detector::Descriptor;
use egui::{Color32, Rect, Sense, Stroke, StrokeKind, Ui, Vec2, vec2};

/// Number of cells on a side, and of directions in a cell.
const CELLS: usize = 4;
const DIRECTIONS: usize = 8;

/// Draws the roses in a square of `side` points, in the feature's own frame: its orientation points to the right.
/// `name` is for screen readers.
pub fn descriptor_ui(ui: &mut Ui, name: &str, descriptor: &Descriptor, side: f32, colour: Color32) {
    let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
    let painter = ui.painter_at(rect.expand(1.0));
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let cell = side / CELLS as f32;
    let grid = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    let longest = f32::from(descriptor.iter().copied().max().unwrap_or(0).max(1));
    for row in 0..CELLS {
        for column in 0..CELLS {
            let square = Rect::from_min_size(rect.min + cell * vec2(column as f32, row as f32), Vec2::splat(cell));
            painter.rect_stroke(square, 0.0, grid, StrokeKind::Middle);
            for direction in 0..DIRECTIONS {
                let value = f32::from(descriptor[(row * CELLS + column) * DIRECTIONS + direction]) / longest;
                let tip = 0.46 * cell * value * Vec2::angled(angle_of(direction));
                painter.line_segment([square.center(), square.center() + tip], Stroke::new(1.5, colour));
            }
        }
    }
    painter.rect_stroke(rect, 2.0, grid, StrokeKind::Inside);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    response.on_hover_text(
        "Descriptor: strength of the gradients in 8 directions in each of 4 × 4 cells. The feature's orientation points to the right.",
    );
}

/// Direction of a descriptor's element within its cell, radians from +u towards +v of the feature's own frame. In UBC's
/// layout the directions run the other way round; the first one stays.
fn angle_of(direction: usize) -> f32 {
    -std::f32::consts::TAU * direction as f32 / DIRECTIONS as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_roses_turn_against_the_order_of_the_elements() {
        assert_eq!(angle_of(0), 0.0);
        for (direction, tip) in [(2, vec2(0.0, -1.0)), (4, vec2(-1.0, 0.0)), (6, vec2(0.0, 1.0))] {
            assert!((Vec2::angled(angle_of(direction)) - tip).length() < 1e-6, "element {direction}");
        }
    }
}
