//! Slope plane: the grid's slopes as dots, whose size grows with the number of features there; dragging moves the slope
//! in both directions at once.

use crate::app::project::Model;
use crate::app::project::cursor::slope_limit;
use crate::detector::Slope;
use egui::{Sense, Stroke, StrokeKind, Ui, pos2, vec2};

/// Draws the pad.
pub fn slope_pad_ui(ui: &mut Ui, model: &mut Model) {
    let side = ui.available_width().min(170.0);
    let (full, _) = ui.allocate_exact_size(vec2(ui.available_width(), side), Sense::hover());
    let rect = egui::Rect::from_center_size(full.center(), vec2(side, side));
    let response = ui.interact(rect, ui.scope_id().with("slope pad"), Sense::click_and_drag());
    let grid = model.cursor_params().slopes;
    let limit = slope_limit(&grid);
    let scale = (0.5 * side - 8.0) / limit;
    let ui_from_slope = |s: Slope| rect.center() + scale * vec2(s.u, s.v);
    if let Some(pos) = response.interact_pointer_pos() {
        let at = (pos - rect.center()) / scale;
        model.playing = false;
        let pane = model.focused_mut();
        pane.cursor.slope = Slope::new(at.x.clamp(-limit, limit), at.y.clamp(-limit, limit));
        pane.show_slope();
    }
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    painter.rect_stroke(rect, 4.0, ui.visuals().widgets.noninteractive.bg_stroke, StrokeKind::Inside);
    let axis = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    painter.line_segment([pos2(rect.left(), rect.center().y), pos2(rect.right(), rect.center().y)], axis);
    painter.line_segment([pos2(rect.center().x, rect.top()), pos2(rect.center().x, rect.bottom())], axis);
    let mut counts = vec![0usize; grid.len()];
    let found = model.found_of(model.focused().side).filter(|f| f.detection.slopes == grid);
    if let Some(found) = found {
        for feature in &found.detection.features {
            if let Some(count) = counts.get_mut(feature.slope_index) {
                *count += 1;
            }
        }
    }
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
    let largest = (0.45 * grid.u.step().min(grid.v.step()) * scale).clamp(2.0, 8.0);
    for (slope, &count) in grid.slopes().zip(&counts) {
        let colour = if count > 0 { ui.visuals().hyperlink_color } else { ui.visuals().weak_text_color() };
        let radius = 1.2 + (largest - 1.2) * (count as f32 / most).sqrt();
        painter.circle_filled(ui_from_slope(slope), radius, colour);
    }
    let here = ui_from_slope(model.cursor().slope);
    painter.circle_stroke(here, 5.5, Stroke::new(2.0, ui.visuals().strong_text_color()));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Slope plane"));
    crate::app::panel::widgets::hint(
        response,
        "Slope plane: u to the right, v downwards. Dots: slopes of the grid, larger where more features were found. Drag to change both.",
    );
}
