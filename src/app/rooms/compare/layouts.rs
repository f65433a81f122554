//! The pictures of the methods: a pane for each, or two in one place.

use super::matches::matches_ui;
use super::pictures::{ComparePictures, features_ui, label_ui};
use crate::app::state::compare::{Contender, Layout};
use crate::app::state::pair::Side;
use crate::app::window::BurstscopeApp;
use egui::{Align, Align2, Color32, CursorIcon, Rect, Sense, Stroke, Ui, UiBuilder, pos2, vec2};

/// Points between panes.
const GAP: f32 = 6.0;

/// Draws the layout that is chosen.
pub fn layouts_ui(ui: &mut Ui, app: &mut BurstscopeApp) {
    let contenders = app.model.contenders();
    if contenders.is_empty() {
        ui.centered_and_justified(|ui| ui.weak("Choose methods in the table below"));
        return;
    }
    let has_second = app.model.burst_of(Side::B).is_some();
    match app.model.compare.look.layout {
        Layout::Wipe => wipe_ui(ui, app),
        Layout::Flip => flip_ui(ui, app),
        Layout::Matches if has_second => matches_ui(ui, app, &contenders),
        Layout::Panes | Layout::Matches => panes_ui(ui, app, &contenders),
    }
}

/// Equal rectangles for `count` panes: in one row as long as they are not too narrow, else in two.
pub(super) fn pane_rects(room: Rect, count: usize) -> Vec<Rect> {
    let rows = if count > 3 || (count > 1 && room.width() / (count as f32) < 260.0) { 2 } else { 1 };
    let columns = count.div_ceil(rows);
    let size = vec2(
        (room.width() - GAP * (columns - 1) as f32) / columns as f32,
        (room.height() - GAP * (rows - 1) as f32) / rows as f32,
    );
    (0..count)
        .map(|i| {
            let (column, row) = (i % columns, i / columns);
            let corner = room.min + vec2((size.x + GAP) * column as f32, (size.y + GAP) * row as f32);
            Rect::from_min_size(corner, size)
        })
        .collect()
}

pub(super) fn in_rect<T>(ui: &mut Ui, rect: Rect, draw: impl FnOnce(&mut Ui) -> T) -> T {
    ui.scope_builder(UiBuilder::new().max_rect(rect).layout(egui::Layout::top_down(Align::Min)), draw).inner
}

fn panes_ui(ui: &mut Ui, app: &mut BurstscopeApp, contenders: &[Contender]) {
    let room = ui.available_rect_before_wrap();
    for (method, rect) in contenders.iter().zip(pane_rects(room, contenders.len())) {
        // One view for all: what is looked at in one is looked at in all.
        in_rect(ui, rect, |ui| app.compare_pictures.pane_ui(ui, &app.model, (*method, Side::A), &mut app.view));
    }
}

fn flip_ui(ui: &mut Ui, app: &mut BurstscopeApp) {
    let look = &app.model.compare.look;
    let method = look.two[usize::from(look.flipped)];
    app.compare_pictures.pane_ui(ui, &app.model, (method, Side::A), &mut app.view);
}

fn wipe_ui(ui: &mut Ui, app: &mut BurstscopeApp) {
    let [left, right] = app.model.compare.look.two;
    let pictures = &mut app.compare_pictures;
    let (below, above) = (pictures.of(&app.model, left, Side::A), pictures.of(&app.model, right, Side::A));
    let mut output = ComparePictures::canvas(&below, "Wipe").show(ui, &mut app.view);
    let rect = output.response.rect;
    let x = egui::lerp(rect.x_range(), app.model.compare.look.wipe);
    let over = ComparePictures::canvas(&above, "Wipe, right side").show_over(
        ui,
        &output,
        Rect::from_min_max(pos2(x, rect.top()), rect.max),
    );
    output.painter.set_clip_rect(Rect::from_min_max(rect.min, pos2(x, rect.bottom())));
    features_ui(ui, &app.model, left, Side::A, &output);
    features_ui(ui, &app.model, right, Side::A, &over);
    label_ui(ui, &output, &app.model, (left, Side::A), Align2::LEFT_TOP);
    label_ui(ui, &over, &app.model, (right, Side::A), Align2::RIGHT_TOP);
    handle_ui(ui, &mut app.model.compare.look.wipe, rect);
}

/// The line of the wipe, which can be dragged.
fn handle_ui(ui: &Ui, wipe: &mut f32, rect: Rect) {
    let x = egui::lerp(rect.x_range(), *wipe);
    let line = Rect::from_center_size(pos2(x, rect.center().y), vec2(12.0, rect.height()));
    let response = ui.interact(line, ui.scope_id().with("wipe handle"), Sense::drag());
    if let Some(pos) = response.interact_pointer_pos() {
        *wipe = ((pos.x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
    }
    let lit = response.hovered() || response.dragged();
    let painter = ui.painter_at(rect);
    for (width, colour) in [(5.0, Color32::from_black_alpha(140)), (if lit { 3.0 } else { 2.0 }, Color32::WHITE)] {
        painter.vline(x, rect.y_range(), Stroke::new(width, colour));
    }
    let grip = pos2(x, rect.center().y);
    painter.circle_filled(grip, 9.0, Color32::from_black_alpha(170));
    painter.circle_stroke(grip, 9.0, Stroke::new(1.5, Color32::WHITE));
    for sign in [-1.0, 1.0] {
        let tip = grip + vec2(6.0 * sign, 0.0);
        for turn in [-1.0, 1.0] {
            painter.line_segment([tip, tip + vec2(-3.0 * sign, 3.0 * turn)], Stroke::new(1.5, Color32::WHITE));
        }
    }
    let value = f64::from(*wipe);
    response.widget_info(|| egui::WidgetInfo::slider(true, value, "Wipe line"));
    response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panes_are_equal_and_do_not_overlap() {
        let room = Rect::from_min_size(pos2(10.0, 20.0), vec2(900.0, 500.0));
        for count in 1..=5 {
            let rects = pane_rects(room, count);
            assert_eq!(rects.len(), count);
            for (i, a) in rects.iter().enumerate() {
                assert!(room.expand(0.01).contains_rect(*a) && (a.size() - rects[0].size()).length() < 1e-3);
                assert!(rects[..i].iter().all(|b| !a.intersects(*b)), "{count}: {rects:?}");
            }
        }
    }
}
