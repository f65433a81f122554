//! A row for each method: what it found in A and in B, and the matches between them.

use crate::app::canvas::overlay::{LineKind, MatchLine, MatchLineStyle, Pane, draw_match_lines};
use crate::app::inspector::chip_ui;
use crate::app::project::compare::Contender;
use crate::app::project::pair::Side;
use crate::app::window::BurstscopeApp;
use crate::app::workspace::compare::pane::{in_rect, pane_ui};
use egui::{Align2, Rect, Ui, pos2, vec2};

/// Points between panes.
const GAP: f32 = 4.0;

/// Draws the rows.
pub fn matches_ui(ui: &mut Ui, app: &mut BurstscopeApp, contenders: &[Contender]) {
    let room = ui.available_rect_before_wrap();
    let height = (room.height() - GAP * (contenders.len() - 1) as f32) / contenders.len() as f32;
    for (row, method) in contenders.iter().enumerate() {
        let top = room.top() + (height + GAP) * row as f32;
        let rect = Rect::from_min_size(pos2(room.left(), top), vec2(room.width(), height));
        row_ui(ui, app, *method, rect);
    }
}

fn row_ui(ui: &mut Ui, app: &mut BurstscopeApp, method: Contender, rect: Rect) {
    let half = 0.5 * (rect.width() - GAP);
    let rects = [rect.with_max_x(rect.left() + half), rect.with_min_x(rect.right() - half)];
    let outputs = Side::BOTH.map(|side| {
        let before = app.model.panes.of(side).view;
        let output = in_rect(ui, rects[side as usize], |ui| pane_ui(ui, app, (method, side)));
        if app.model.pair.links.views {
            let after = app.model.panes.of(side).view;
            app.model.panes.of_mut(side.other()).view.follow(&before, &after);
        }
        output
    });
    let painter = ui.painter_at(rect);
    let Some(matches) = app.model.method_matches(method) else { return };
    let look = &app.model.pair.look;
    let lines: Vec<MatchLine> = matches
        .rows()
        .filter(|row| look.shows(row.inlier))
        .map(|row| MatchLine {
            index: row.index,
            a: pos2(row.a.u, row.a.v),
            b: pos2(row.b.u, row.b.v),
            kind: LineKind::of(row.inlier),
        })
        .collect();
    let panes = [0, 1].map(|i| Pane { ui_from_image: outputs[i].ui_from_image, rect_ui: outputs[i].response.rect });
    let style = MatchLineStyle { opacity: look.opacity, selected: None, hovered: None, others_faint: false };
    draw_match_lines(&painter, &panes, &lines, &style);
    let counts = matches.result.counts;
    let text = match counts.inliers {
        Some(inliers) => format!("{inliers} of {} matches are inliers", counts.putative),
        None => format!("{} matches", counts.putative),
    };
    chip_ui(ui, &outputs[1], Align2::RIGHT_BOTTOM, &text, (method, "matches"));
}
