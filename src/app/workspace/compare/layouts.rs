//! The pictures of the methods: a pane for each, or two in one place.

use super::pane::{in_rect, pane_ui};
use crate::app::inspector::over_handle_ui;
use crate::app::project::compare::{Contender, Layout};
use crate::app::project::pair::Side;
use crate::app::window::BurstscopeApp;
use crate::app::workspace::compare::matches::matches_ui;
use crate::app::workspace::compare::pictures::{ComparePictures, features_ui, label_ui};
use egui::{Align2, Rect, Ui, pos2, vec2};

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
pub(crate) fn pane_rects(room: Rect, count: usize) -> Vec<Rect> {
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

fn panes_ui(ui: &mut Ui, app: &mut BurstscopeApp, contenders: &[Contender]) {
    let room = ui.available_rect_before_wrap();
    for (method, rect) in contenders.iter().zip(pane_rects(room, contenders.len())) {
        // One view for all: what is looked at in one is looked at in all.
        in_rect(ui, rect, |ui| pane_ui(ui, app, (*method, Side::A)));
    }
}

fn flip_ui(ui: &mut Ui, app: &mut BurstscopeApp) {
    let look = &app.model.compare.look;
    let method = look.two[usize::from(look.flipped)];
    pane_ui(ui, app, (method, Side::A));
}

fn wipe_ui(ui: &mut Ui, app: &mut BurstscopeApp) {
    let [left, right] = app.model.compare.look.two;
    let pictures = &mut app.compare_pictures;
    let (below, above) = (pictures.of(&app.model, left, Side::A), pictures.of(&app.model, right, Side::A));
    let mut view = app.model.panes.of(Side::A).view;
    let mut output = ComparePictures::canvas(&below, "Wipe").show(ui, &mut view);
    app.model.panes.of_mut(Side::A).view = view;
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
    over_handle_ui(ui, &mut app.model.compare.look.wipe, rect);
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
