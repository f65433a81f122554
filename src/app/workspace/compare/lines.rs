//! Matches of each method, between its panes of A and of B.

use crate::app::canvas::overlay::{MatchLine, MatchLineStyle, draw_match_lines};
use crate::app::inspector::{Drawn, chip_ui};
use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::compare::Contender;
use crate::app::workspace::pair::lines::{line_of, painter_over};
use crate::app::workspace::pair::views::MatchViews;
use egui::{Align2, Ui};

/// Draws the match lines and the number of inliers over the drawn panes.
pub fn lines_ui(ui: &Ui, model: &Model, drawn: &[(PaneId, Drawn)]) {
    let look = &model.pair.look;
    let style = MatchLineStyle { opacity: look.opacity, selected: None, hovered: None, others_faint: false };
    for method in Contender::ALL {
        let Some(matches) = model.method_matches(method) else { continue };
        let views = MatchViews::of(model, drawn, Some(method));
        for canvases in views.canvases().iter().filter(|canvases| canvases.places.iter().all(Option::is_some)) {
            let rows = matches.rows().filter(|row| look.shows(row.inlier));
            let lines: Vec<MatchLine> = rows.map(|row| line_of(&row, canvases.shifts)).collect();
            draw_match_lines(&painter_over(ui, &views, canvases), &canvases.panes, &lines, &style);
            let counts = matches.result.counts;
            let text = match counts.inliers {
                Some(inliers) => format!("{inliers} of {} matches are inliers", counts.putative),
                None => format!("{} matches", counts.putative),
            };
            if let [_, Some(b)] = canvases.places {
                chip_ui(ui, views.views[b].output, Align2::RIGHT_BOTTOM, &text, (method, "matches", canvases.places));
            }
        }
    }
}
